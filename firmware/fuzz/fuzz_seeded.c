/* The fuzz target without libFuzzer: N seeded frames, mutants of valid ones and rubbish.  Usage: fuzz_seeded [N] [seed] */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "../core/hero_frame.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

extern unsigned long fuzz_runs;

static uint64_t state;

static uint32_t draw(uint32_t below) {
  state ^= state << 13;
  state ^= state >> 7;
  state ^= state << 17;
  return (uint32_t)(state >> 32) % below;
}

/* A whole frame with a wrong tag and some bytes changed, its length mostly right. */
static size_t mutant(uint8_t *out) {
  static const uint8_t key[HERO_KEY_SIZE];
  uint8_t payload[HERO_PAYLOAD_MAX];
  struct hero_frame frame = {.type = (uint8_t)(1 + draw(8)), .robot = 7, .sequence = draw(1000), .payload = payload};
  frame.payload_size = (uint16_t)draw(30);
  for (unsigned i = 0; i < frame.payload_size; i++) payload[i] = (uint8_t)draw(256);
  size_t size = hero_frame_seal(key, &frame, out, HERO_FRAME_MAX);
  for (uint32_t flips = draw(6); flips > 0; flips--) out[draw((uint32_t)size)] ^= (uint8_t)(1u << draw(8));
  return draw(4) == 0 ? draw((uint32_t)size + 1) : size;
}

/* An authentic command: type, sequence step, payload; mostly of the size that the type asks for. */
static size_t command(uint8_t *out) {
  static const uint8_t sizes[8] = {0, 8, 8, 12, 0, 0, 0, 20};
  uint8_t type = (uint8_t)draw(8);
  size_t size = draw(8) == 0 ? draw(40) : sizes[type];
  out[0] = draw(16) == 0 ? (uint8_t)draw(256) : type;
  out[1] = (uint8_t)draw(256);
  for (size_t i = 0; i < size; i++) out[2 + i] = i % 4 < 2 ? (uint8_t)draw(256) : (uint8_t)(draw(8) == 0 ? draw(256) : 0);
  return size + 2;
}

int main(int count, char **arguments) {
  unsigned long frames = count > 1 ? strtoul(arguments[1], NULL, 10) : 50000;
  state = 0x9e3779b97f4a7c15u + (count > 2 ? strtoul(arguments[2], NULL, 10) : 0);
  for (unsigned long i = 0; i < frames; i++) {
    uint8_t data[HERO_FRAME_MAX + 32];
    uint32_t kind = draw(3);
    size_t size;
    data[0] = (uint8_t)(kind == 2 ? 200 : 0);
    if (kind == 0) {
      size = draw(HERO_FRAME_MAX + 30);
      for (size_t k = 0; k < size; k++) data[1 + k] = (uint8_t)draw(256);
    } else {
      size = kind == 1 ? mutant(data + 1) : command(data + 1);
    }
    LLVMFuzzerTestOneInput(data, size + 1);
  }
  printf("%lu frames, no fault; in RUN after %lu of them\n", frames, fuzz_runs);
  return fuzz_runs == 0; /* a fuzzer that never got the robot to move has shown nothing */
}
