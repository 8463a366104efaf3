#include "hero_sha256.h"

#include <string.h>

/* First 32 bits of the fractional parts of the cube roots of the first 64 primes (FIPS 180-4, 4.2.2). */
static const uint32_t ROUND[64] = {
  0x428a2f98, 0x71374491, 0xb5c0fbcf, 0xe9b5dba5, 0x3956c25b, 0x59f111f1, 0x923f82a4, 0xab1c5ed5,
  0xd807aa98, 0x12835b01, 0x243185be, 0x550c7dc3, 0x72be5d74, 0x80deb1fe, 0x9bdc06a7, 0xc19bf174,
  0xe49b69c1, 0xefbe4786, 0x0fc19dc6, 0x240ca1cc, 0x2de92c6f, 0x4a7484aa, 0x5cb0a9dc, 0x76f988da,
  0x983e5152, 0xa831c66d, 0xb00327c8, 0xbf597fc7, 0xc6e00bf3, 0xd5a79147, 0x06ca6351, 0x14292967,
  0x27b70a85, 0x2e1b2138, 0x4d2c6dfc, 0x53380d13, 0x650a7354, 0x766a0abb, 0x81c2c92e, 0x92722c85,
  0xa2bfe8a1, 0xa81a664b, 0xc24b8b70, 0xc76c51a3, 0xd192e819, 0xd6990624, 0xf40e3585, 0x106aa070,
  0x19a4c116, 0x1e376c08, 0x2748774c, 0x34b0bcb5, 0x391c0cb3, 0x4ed8aa4a, 0x5b9cca4f, 0x682e6ff3,
  0x748f82ee, 0x78a5636f, 0x84c87814, 0x8cc70208, 0x90befffa, 0xa4506ceb, 0xbef9a3f7, 0xc67178f2,
};

/* First 32 bits of the fractional parts of the square roots of the first 8 primes (FIPS 180-4, 5.3.3). */
static const uint32_t START[8] = {
  0x6a09e667, 0xbb67ae85, 0x3c6ef372, 0xa54ff53a, 0x510e527f, 0x9b05688c, 0x1f83d9ab, 0x5be0cd19,
};

static uint32_t turn(uint32_t x, unsigned bits) { return (x >> bits) | (x << (32u - bits)); }

static uint32_t big_endian(const uint8_t *p) {
  return ((uint32_t)p[0] << 24) | ((uint32_t)p[1] << 16) | ((uint32_t)p[2] << 8) | (uint32_t)p[3];
}

/* Word t of the message schedule, kept in a ring of 16 words to spare 192 bytes of stack. */
static uint32_t schedule(uint32_t ring[16], unsigned t) {
  uint32_t early = ring[(t + 1u) & 15u], late = ring[(t + 14u) & 15u];
  uint32_t small0 = turn(early, 7) ^ turn(early, 18) ^ (early >> 3);
  uint32_t small1 = turn(late, 17) ^ turn(late, 19) ^ (late >> 10);
  return ring[t & 15u] += small0 + ring[(t + 9u) & 15u] + small1;
}

static void compress(uint32_t state[8], const uint8_t block[64]) {
  uint32_t ring[16], s[8];
  for (unsigned i = 0; i < 16; i++) ring[i] = big_endian(block + 4 * i);
  memcpy(s, state, sizeof s);
  for (unsigned t = 0; t < 64; t++) {
    uint32_t word = t < 16 ? ring[t] : schedule(ring, t);
    uint32_t choice = (s[4] & s[5]) ^ (~s[4] & s[6]);
    uint32_t majority = (s[0] & s[1]) ^ (s[0] & s[2]) ^ (s[1] & s[2]);
    uint32_t first = s[7] + (turn(s[4], 6) ^ turn(s[4], 11) ^ turn(s[4], 25)) + choice + ROUND[t] + word;
    uint32_t second = (turn(s[0], 2) ^ turn(s[0], 13) ^ turn(s[0], 22)) + majority;
    memmove(s + 1, s, 7 * sizeof s[0]);
    s[4] += first;
    s[0] = first + second;
  }
  for (unsigned i = 0; i < 8; i++) state[i] += s[i];
}

void hero_sha256_start(struct hero_sha256 *hash) {
  memcpy(hash->state, START, sizeof START);
  hash->length = 0;
}

void hero_sha256_add(struct hero_sha256 *hash, const uint8_t *data, size_t size) {
  for (size_t i = 0; i < size; i++) {
    hash->block[hash->length++ & 63u] = data[i];
    if ((hash->length & 63u) == 0) compress(hash->state, hash->block);
  }
}

void hero_sha256_finish(struct hero_sha256 *hash, uint8_t digest[HERO_DIGEST_SIZE]) {
  uint32_t bits = hash->length << 3, over = hash->length >> 29;
  const uint8_t one = 0x80, zero = 0;
  hero_sha256_add(hash, &one, 1);
  while ((hash->length & 63u) != 56u) hero_sha256_add(hash, &zero, 1);
  for (int shift = 24; shift >= 0; shift -= 8) hero_sha256_add(hash, &(uint8_t){(uint8_t)(over >> shift)}, 1);
  for (int shift = 24; shift >= 0; shift -= 8) hero_sha256_add(hash, &(uint8_t){(uint8_t)(bits >> shift)}, 1);
  for (unsigned i = 0; i < HERO_DIGEST_SIZE; i++) digest[i] = (uint8_t)(hash->state[i / 4] >> (24 - 8 * (i % 4)));
}

/* H((key xor pad) || data): one of the two nested hashes of RFC 2104. */
static void keyed(const uint8_t *key, uint8_t pad, const uint8_t *data, size_t size, uint8_t *digest) {
  struct hero_sha256 hash;
  uint8_t block[64];
  memset(block, pad, sizeof block);
  for (unsigned i = 0; i < HERO_KEY_SIZE; i++) block[i] ^= key[i];
  hero_sha256_start(&hash);
  hero_sha256_add(&hash, block, sizeof block);
  hero_sha256_add(&hash, data, size);
  hero_sha256_finish(&hash, digest);
}

void hero_hmac(const uint8_t key[HERO_KEY_SIZE], const uint8_t *data, size_t size, uint8_t tag[HERO_DIGEST_SIZE]) {
  uint8_t inner[HERO_DIGEST_SIZE];
  keyed(key, 0x36, data, size, inner);
  keyed(key, 0x5c, inner, sizeof inner, tag);
}

bool hero_same_tag(const uint8_t a[HERO_DIGEST_SIZE], const uint8_t b[HERO_DIGEST_SIZE]) {
  uint8_t difference = 0;
  for (unsigned i = 0; i < HERO_DIGEST_SIZE; i++) difference = (uint8_t)(difference | (a[i] ^ b[i]));
  return difference == 0;
}
