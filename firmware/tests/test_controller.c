#include "../core/hero_config.h"
#include "../core/hero_wheels.h"
#include "check.h"

static void the_reading_picks_the_pair(void) {
  struct hero_controller controller = {{1, 2, 3, 4}};
  CHECK_EQUAL(hero_controller_act(&controller, false).v, 1);
  CHECK_EQUAL(hero_controller_act(&controller, false).omega, 2);
  CHECK_EQUAL(hero_controller_act(&controller, true).v, 3);
  CHECK_EQUAL(hero_controller_act(&controller, true).omega, 4);
}

static void genes_beyond_the_limits_are_out_of_range(void) {
  const fix_t limit[4] = {HERO_MAX_SPEED, HERO_MAX_TURN, HERO_MAX_SPEED, HERO_MAX_TURN};
  for (int i = 0; i < 4; i++) {
    for (int sign = -1; sign <= 1; sign += 2) {
      struct hero_controller controller = {{0, 0, 0, 0}};
      controller.gene[i] = sign * limit[i];
      CHECK(hero_controller_in_range(&controller));
      controller.gene[i] += sign;
      CHECK(!hero_controller_in_range(&controller));
      controller.gene[i] = INT32_MIN;
      CHECK(!hero_controller_in_range(&controller));
    }
  }
}

static void wheels_and_motion_are_inverse(void) {
  for (int i = 0; i < 500; i++) {
    struct hero_unicycle motion = {(fix_t)(check_random() % 12001) - 6000, (fix_t)(check_random() % 200001) - 100000};
    struct hero_unicycle back = hero_wheels_motion(hero_wheels_from(motion));
    CHECK_NEAR(back.v, motion.v, 1);
    CHECK_NEAR(back.omega, motion.omega, 32 + fix_abs(motion.omega) / 10000); /* wheels are rounded, the base is small */
  }
}

static void turning_left_drives_the_right_wheel(void) {
  struct hero_wheels wheels = hero_wheels_from((struct hero_unicycle){0, FIX_ONE});
  CHECK_NEAR(wheels.rim[HERO_RIGHT], HERO_WHEEL_BASE / 2, 1);
  CHECK_NEAR(wheels.rim[HERO_LEFT], -HERO_WHEEL_BASE / 2, 1);
}

static void too_fast_keeps_the_curvature(void) {
  struct hero_unicycle desired = {HERO_MAX_SPEED, HERO_MAX_TURN};
  struct hero_wheels wheels = hero_wheels_from(desired);
  struct hero_unicycle motion = hero_wheels_motion(wheels);
  CHECK_NEAR(wheels.rim[HERO_RIGHT], HERO_MAX_RIM_SPEED, 1);
  CHECK_NEAR(fix_mul(motion.omega, FIX_ONE / 15), motion.v, 20); /* 3 rad/s to 0.2 m/s */
}

void test_controller(void) {
  the_reading_picks_the_pair();
  genes_beyond_the_limits_are_out_of_range();
  wheels_and_motion_are_inverse();
  turning_left_drives_the_right_wheel();
  too_fast_keeps_the_curvature();
}
