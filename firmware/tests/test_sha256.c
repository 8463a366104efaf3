#include "../core/hero_sha256.h"

#include <string.h>

#include "check.h"

static uint8_t nibble(char c) { return (uint8_t)(c <= '9' ? c - '0' : c - 'a' + 10); }

static bool is_hex(const uint8_t digest[32], const char *hex) {
  for (int i = 0; i < 32; i++) {
    if (digest[i] != (uint8_t)(nibble(hex[2 * i]) << 4 | nibble(hex[2 * i + 1]))) return false;
  }
  return true;
}

static bool hashes_to(const char *message, const char *hex) {
  struct hero_sha256 hash;
  uint8_t digest[32];
  hero_sha256_start(&hash);
  hero_sha256_add(&hash, (const uint8_t *)message, strlen(message));
  hero_sha256_finish(&hash, digest);
  return is_hex(digest, hex);
}

/* FIPS 180-4 examples. */
static void hashes_the_standards_messages(void) {
  CHECK(hashes_to("", "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855"));
  CHECK(hashes_to("abc", "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad"));
  CHECK(hashes_to("abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq",
                  "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1"));
  CHECK(hashes_to("abcdefghbcdefghicdefghijdefghijkefghijklfghijklmghijklmnhijklmnoijklmnopjklmnopqklmnopqrlmnopqrsmnopqrstnopqrstu",
                  "cf5b16a778af8380036ce59e7b0492370b249b11e8f07a51afac45037afee9d1"));
}

static void hashes_a_long_message_in_odd_pieces(void) {
  struct hero_sha256 hash;
  uint8_t piece[125], digest[32];
  memset(piece, 'a', sizeof piece);
  hero_sha256_start(&hash);
  for (int i = 0; i < 8000; i++) hero_sha256_add(&hash, piece, sizeof piece); /* a million */
  hero_sha256_finish(&hash, digest);
  CHECK(is_hex(digest, "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0"));
}

/* RFC 4231, cases 1, 2 and 3: a shorter key is a key of 32 bytes that ends in zeros. */
static void tags_the_standards_messages(void) {
  uint8_t key[32] = {0}, data[50], tag[32];
  memset(key, 0x0b, 20);
  hero_hmac(key, (const uint8_t *)"Hi There", 8, tag);
  CHECK(is_hex(tag, "b0344c61d8db38535ca8afceaf0bf12b881dc200c9833da726e9376c2e32cff7"));
  memset(key, 0, sizeof key);
  memcpy(key, "Jefe", 4);
  hero_hmac(key, (const uint8_t *)"what do ya want for nothing?", 28, tag);
  CHECK(is_hex(tag, "5bdcc146bf60754e6a042426089575c75a003f089d2739839dec58b964ec3843"));
  memset(key, 0, sizeof key);
  memset(key, 0xaa, 20);
  memset(data, 0xdd, sizeof data);
  hero_hmac(key, data, sizeof data, tag);
  CHECK(is_hex(tag, "773ea91e36800e46854db8ebd09181a72959098b3ef8c122d9635514ced565fe"));
}

static void tags_differ_by_one_bit_anywhere(void) {
  uint8_t a[32] = {0}, b[32] = {0};
  CHECK(hero_same_tag(a, b));
  for (int i = 0; i < 256; i++) {
    b[i / 8] ^= (uint8_t)(1 << i % 8);
    CHECK(!hero_same_tag(a, b));
    b[i / 8] = 0;
  }
}

void test_sha256(void) {
  hashes_the_standards_messages();
  hashes_a_long_message_in_odd_pieces();
  tags_the_standards_messages();
  tags_differ_by_one_bit_anywhere();
}
