#include "../core/hero_frame.h"

#include <string.h>

#include "check.h"

static const uint8_t KEY[32] = "the key of robot number seven  ";

static size_t sealed(uint8_t *out) {
  static const uint8_t payload[5] = {1, 2, 3, 4, 5};
  struct hero_frame frame = {.type = HERO_START, .robot = 0x1234, .nonce = 0x1122334455667788u, .sequence = 0xa1b2c3d4u,
                             .payload = payload, .payload_size = 5};
  return hero_frame_seal(KEY, &frame, out, HERO_FRAME_MAX);
}

static void a_sealed_frame_reads_back(void) {
  uint8_t data[HERO_FRAME_MAX];
  struct hero_frame frame;
  size_t size = sealed(data);
  CHECK_EQUAL(size, 57);
  CHECK(hero_frame_parse(data, size, &frame));
  CHECK(hero_frame_authentic(KEY, data, size));
  CHECK_EQUAL(frame.type, HERO_START);
  CHECK_EQUAL(frame.robot, 0x1234);
  CHECK(frame.nonce == 0x1122334455667788u);
  CHECK(frame.sequence == 0xa1b2c3d4u);
  CHECK_EQUAL(frame.payload_size, 5);
  CHECK_EQUAL(frame.payload[4], 5);
}

static void every_bit_is_covered(void) {
  uint8_t data[HERO_FRAME_MAX];
  struct hero_frame frame;
  size_t size = sealed(data);
  for (size_t bit = 0; bit < 8 * size; bit++) {
    data[bit / 8] ^= (uint8_t)(1u << bit % 8);
    CHECK(!hero_frame_parse(data, size, &frame) || !hero_frame_authentic(KEY, data, size));
    data[bit / 8] ^= (uint8_t)(1u << bit % 8);
  }
}

static void every_other_length_is_refused(void) {
  uint8_t data[HERO_FRAME_MAX + 8] = {0};
  struct hero_frame frame;
  size_t size = sealed(data);
  for (size_t other = 0; other <= sizeof data; other++) CHECK(hero_frame_parse(data, other, &frame) == (other == size));
}

static void what_does_not_fit_is_not_sealed(void) {
  uint8_t data[HERO_FRAME_MAX], payload[HERO_PAYLOAD_MAX + 1] = {0};
  struct hero_frame frame = {.type = HERO_STATUS, .payload = payload, .payload_size = HERO_PAYLOAD_MAX + 1};
  CHECK_EQUAL(hero_frame_seal(KEY, &frame, data, sizeof data), 0);
  frame.payload_size = HERO_PAYLOAD_MAX;
  CHECK_EQUAL(hero_frame_seal(KEY, &frame, data, sizeof data), HERO_FRAME_MAX);
  CHECK_EQUAL(hero_frame_seal(KEY, &frame, data, sizeof data - 1), 0);
}

void test_frame(void) {
  a_sealed_frame_reads_back();
  every_bit_is_covered();
  every_other_length_is_refused();
  what_does_not_fit_is_not_sealed();
}
