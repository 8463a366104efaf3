#include "../core/hero_config.h"
#include "../core/hero_odometry.h"
#include "check.h"

static void straight_ahead_counts_every_tick(void) {
  struct hero_odometry odometry = {0, 0, 0};
  for (int i = 0; i < 1000; i++) hero_odometry_add(&odometry, 1, 1);
  CHECK_NEAR(odometry.x, 2000 * HERO_HALF_TICK, 0);
  CHECK_EQUAL(odometry.y, 0);
  CHECK_EQUAL(odometry.heading, 0);
}

static void backwards_undoes_forwards(void) {
  struct hero_odometry odometry = {0, 0, 0};
  for (int i = 0; i < 500; i++) hero_odometry_add(&odometry, 2, 3);
  for (int i = 0; i < 500; i++) hero_odometry_add(&odometry, -2, -3);
  CHECK_NEAR(odometry.x, 0, 500);
  CHECK_NEAR(odometry.y, 0, 500); /* 30 um */
  CHECK_EQUAL(odometry.heading, 0);
}

static void turning_in_place_stays_in_place(void) {
  struct hero_odometry odometry = {0, 0, 0};
  for (int i = 0; i < 1000; i++) hero_odometry_add(&odometry, -1, 1);
  CHECK_EQUAL(odometry.x, 0);
  CHECK_EQUAL(odometry.y, 0);
  CHECK_EQUAL(odometry.heading, 4000u * HERO_HALF_TICK_TURN);
}

/* A full circle of the left wheel still: radius half a base, back where it began. */
static void a_circle_closes(void) {
  struct hero_odometry odometry = {0, 0, 0};
  int32_t highest = 0;
  int ticks = (int)(0xffffffffu / (2u * HERO_HALF_TICK_TURN)); /* one turn, to a tick */
  for (int i = 0; i < ticks; i++) {
    hero_odometry_add(&odometry, 0, 1);
    if (odometry.y > highest) highest = odometry.y;
  }
  CHECK_NEAR(odometry.x, 0, 30000); /* a tick is 27,013 */
  CHECK_NEAR(odometry.y, 0, 2000);
  CHECK_NEAR(highest, HERO_WHEEL_BASE * 256, HERO_WHEEL_BASE); /* the diameter is the base */
}

void test_odometry(void) {
  straight_ahead_counts_every_tick();
  backwards_undoes_forwards();
  turning_in_place_stays_in_place();
  a_circle_closes();
}
