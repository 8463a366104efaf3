#include "../core/hero_config.h"
#include "../core/hero_velocity.h"
#include "check.h"

static struct hero_velocity loop;

static void no_error_gives_the_data_sheets_pulse(void) {
  hero_velocity_reset(&loop);
  CHECK_NEAR(hero_velocity_step(&loop, HERO_MAX_RIM_SPEED, HERO_MAX_RIM_SPEED), HERO_SERVO_SPAN_US, 1);
  hero_velocity_reset(&loop);
  CHECK_NEAR(hero_velocity_step(&loop, -HERO_MAX_RIM_SPEED, -HERO_MAX_RIM_SPEED), -HERO_SERVO_SPAN_US, 1);
  CHECK_EQUAL(hero_velocity_step(&loop, 0, 3000), 0);
  CHECK_EQUAL(loop.integral, 0);
}

/* A servo that is a third weaker than the data sheet's, with lag: the integral makes up for it. */
static void the_integral_makes_up_for_a_weak_servo(void) {
  fix_t speed = 0, target = 5000;
  hero_velocity_reset(&loop);
  for (int i = 0; i < 400; i++) {
    int32_t pulse = hero_velocity_step(&loop, target, speed);
    speed += ((fix_t)(pulse * FIX_ONE / HERO_SERVO_US_PER_SPEED * 2 / 3) - speed) / 3;
  }
  CHECK_NEAR(speed, target, 60); /* one us of pulse is 46 units here */
}

static void a_held_wheel_does_not_wind_up(void) {
  hero_velocity_reset(&loop);
  for (int i = 0; i < 5000; i++) CHECK(hero_velocity_step(&loop, 5000, 0) <= HERO_SERVO_SPAN_US);
  int steps = 0;
  while (hero_velocity_step(&loop, 5000, 7000) > 73 && steps < 200) steps++; /* let go, it runs too fast */
  CHECK(steps < 60);
}

static void any_number_stays_within_the_span(void) {
  hero_velocity_reset(&loop);
  for (int i = 0; i < 2000; i++) {
    int32_t pulse = hero_velocity_step(&loop, fix_clamp((fix_t)check_random(), 16 * FIX_ONE), fix_clamp((fix_t)check_random(), 16 * FIX_ONE));
    CHECK(pulse >= -HERO_SERVO_SPAN_US && pulse <= HERO_SERVO_SPAN_US);
  }
}

void test_velocity(void) {
  no_error_gives_the_data_sheets_pulse();
  the_integral_makes_up_for_a_weak_servo();
  a_held_wheel_does_not_wind_up();
  any_number_stays_within_the_span();
}
