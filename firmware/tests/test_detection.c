#include "../core/hero_config.h"
#include "../core/hero_detection.h"
#include "check.h"

static struct hero_detection detection;
static uint64_t now_us;

static bool read_range(int distance_mm, bool valid) {
  now_us += HERO_TOF_PERIOD_MS * 1000u;
  hero_detection_take(&detection, (struct hero_range){(uint16_t)distance_mm, valid}, now_us);
  return detection.seen;
}

static void begin(void) {
  now_us = 0x1ffffff00u; /* far beyond 32 bits */
  hero_detection_start(&detection, now_us);
}

static void one_reading_is_not_enough(void) {
  begin();
  CHECK(!read_range(HERO_TOF_THRESHOLD_MM / 2, true));
  CHECK(!read_range(0, false));
  for (int i = 1; i < HERO_TOF_DEBOUNCE; i++) CHECK(!read_range(HERO_TOF_THRESHOLD_MM / 2, true));
  CHECK(read_range(HERO_TOF_THRESHOLD_MM / 2, true));
  for (int i = 1; i < HERO_TOF_DEBOUNCE; i++) CHECK(read_range(0, false));
  CHECK(!read_range(0, false));
}

static void the_threshold_is_the_robot_files(void) {
  begin();
  for (int i = 0; i < 9; i++) CHECK(!read_range(HERO_TOF_THRESHOLD_MM + 1, true));
  for (int i = 0; i < 9; i++) read_range(HERO_TOF_THRESHOLD_MM, true);
  CHECK(detection.seen);
  CHECK_EQUAL(detection.range_mm, HERO_TOF_THRESHOLD_MM);
}

static void too_near_and_invalid_are_nothing(void) {
  begin();
  for (int i = 0; i < 9; i++) CHECK(!read_range(HERO_TOF_MIN_MM - 1, true));
  for (int i = 0; i < 9; i++) CHECK(!read_range(300, false));
  CHECK_EQUAL(detection.range_mm, 0);
}

static void silence_is_nothing_and_a_fault(void) {
  begin();
  for (int i = 0; i < 9; i++) read_range(300, true);
  CHECK(hero_detection_alive(&detection, now_us + HERO_TOF_TIMEOUT_US));
  CHECK(detection.seen);
  CHECK(!hero_detection_alive(&detection, now_us + HERO_TOF_TIMEOUT_US + 1));
  CHECK(!detection.seen);
}

void test_detection(void) {
  one_reading_is_not_enough();
  the_threshold_is_the_robot_files();
  too_near_and_invalid_are_nothing();
  silence_is_nothing_and_a_fault();
}
