#include "../core/hero_config.h"
#include "../core/hero_encoder.h"
#include "check.h"

#define PERIOD ((uint32_t)HERO_CONTROL_PERIOD_US)

static struct hero_encoder encoder;

/* Runs a wheel with an edge every `spacing` us for `periods` control periods from `start`; returns the signed edges. */
static int32_t run_wheel(uint32_t start, uint32_t spacing, int periods, int sign) {
  int32_t counted = 0;
  hero_encoder_start(&encoder, 0, start);
  hero_encoder_drive(&encoder, sign, start);
  for (int i = 1; i <= periods; i++) {
    uint32_t elapsed = (uint32_t)i * PERIOD, edges = elapsed / spacing;
    counted += hero_encoder_take(&encoder, edges, start + edges * spacing, start + elapsed);
  }
  return counted;
}

static void speed_is_far_finer_than_a_tick_a_period(void) {
  for (uint32_t spacing = 7000; spacing < 200000; spacing += 3777) {
    uint32_t start = 0xfff00000u; /* the clock wraps within the test */
    run_wheel(start, spacing, 60, 1);
    fix_t truth = (fix_t)(HERO_TICK_SPEED / spacing);
    CHECK_NEAR(hero_encoder_speed(&encoder, 0, start + 60 * PERIOD), truth, truth / 500 + 2);
  }
}

static void every_edge_is_counted_with_its_sign(void) {
  CHECK_EQUAL(run_wheel(5, 13000, 650, 1), 1000);
  CHECK_EQUAL(run_wheel(5, 13000, 650, -1), -1000);
}

static void a_wheel_that_stops_fades_to_zero(void) {
  run_wheel(0, 20000, 50, 1);
  uint32_t now = 50 * PERIOD;
  fix_t before = hero_encoder_speed(&encoder, 6000, now);
  for (int i = 0; i < 50; i++) hero_encoder_take(&encoder, 50, 50 * PERIOD, now += PERIOD);
  CHECK(hero_encoder_speed(&encoder, 6000, now) < before / 40); /* no edge for a second: below a tick a second */
  hero_encoder_drive(&encoder, 0, now);
  CHECK_EQUAL(hero_encoder_speed(&encoder, 0, now), 0);
}

static void a_starting_wheel_is_believed_until_time_contradicts(void) {
  hero_encoder_start(&encoder, 0, 0);
  hero_encoder_drive(&encoder, 1, 1000000u);
  CHECK_EQUAL(hero_encoder_speed(&encoder, 5000, 1010000u), 5000);
  CHECK_NEAR(hero_encoder_speed(&encoder, 5000, 1100000u), HERO_TICK_SPEED / 100000u, 1); /* 0.1 s without an edge */
  CHECK_NEAR(hero_encoder_speed(&encoder, -5000, 1100000u), -(long)(HERO_TICK_SPEED / 100000u), 1);
}

static void an_edge_stamped_after_now_does_no_harm(void) {
  run_wheel(0, 20000, 50, 1);
  hero_encoder_take(&encoder, 51, 51 * PERIOD, 51 * PERIOD - 3); /* the interrupt came after `now` was taken */
  CHECK_NEAR(hero_encoder_speed(&encoder, 5276, 51 * PERIOD - 3), HERO_TICK_SPEED / 20000u, 1);
}

static void a_reversing_wheel_keeps_its_sign_while_it_coasts(void) {
  run_wheel(0, 20000, 50, 1);
  uint32_t now = 50 * PERIOD;
  hero_encoder_drive(&encoder, -1, now);
  CHECK_EQUAL(hero_encoder_take(&encoder, 51, now + 20000, now + 20000), 1);
  CHECK_EQUAL(hero_encoder_take(&encoder, 52, now + 40000, now + 40000), 1);
  CHECK_EQUAL(hero_encoder_take(&encoder, 53, now + 80000, now + 80000), -1);
}

static void nonsense_from_the_counter_stays_bounded(void) {
  run_wheel(0, 20000, 50, 1);
  CHECK(hero_encoder_take(&encoder, 0x80000000u, 50 * PERIOD + 1, 51 * PERIOD) <= 1000);
  CHECK(hero_encoder_speed(&encoder, 0, 51 * PERIOD) <= 16 * FIX_ONE);
}

void test_encoder(void) {
  speed_is_far_finer_than_a_tick_a_period();
  every_edge_is_counted_with_its_sign();
  a_wheel_that_stops_fades_to_zero();
  a_starting_wheel_is_believed_until_time_contradicts();
  an_edge_stamped_after_now_does_no_harm();
  a_reversing_wheel_keeps_its_sign_while_it_coasts();
  nonsense_from_the_counter_stays_bounded();
}
