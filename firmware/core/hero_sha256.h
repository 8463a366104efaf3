/* SHA-256 (FIPS 180-4) and HMAC-SHA256 (RFC 2104) for short messages; no heap, no tables but the standard's own. */
#ifndef HERO_SHA256_H
#define HERO_SHA256_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define HERO_DIGEST_SIZE 32u
#define HERO_KEY_SIZE 32u

struct hero_sha256 {
  uint32_t state[8];
  uint32_t length; /* bytes taken in so far; messages stay far below 2^29 bytes */
  uint8_t block[64];
};

void hero_sha256_start(struct hero_sha256 *hash);
void hero_sha256_add(struct hero_sha256 *hash, const uint8_t *data, size_t size);
void hero_sha256_finish(struct hero_sha256 *hash, uint8_t digest[HERO_DIGEST_SIZE]);

/* Tag of `data` under a key of HERO_KEY_SIZE bytes. */
void hero_hmac(const uint8_t key[HERO_KEY_SIZE], const uint8_t *data, size_t size, uint8_t tag[HERO_DIGEST_SIZE]);

/* Whether two tags are equal, in a time that does not depend on where they differ. */
bool hero_same_tag(const uint8_t a[HERO_DIGEST_SIZE], const uint8_t b[HERO_DIGEST_SIZE]);

#endif
