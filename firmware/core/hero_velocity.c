#include "hero_velocity.h"

#include "hero_config.h"

#define SPAN ((fix_t)HERO_SERVO_SPAN_US * FIX_ONE)

void hero_velocity_reset(struct hero_velocity *loop) { loop->integral = 0; }

/* Pulse offset at which an unloaded servo of the data sheet runs at this speed, us as Q16.16. */
static fix_t feed_forward(fix_t target) {
  fix_t dead = (fix_t)HERO_SERVO_DEADBAND_US * FIX_ONE / 2;
  return target * HERO_SERVO_US_PER_SPEED + (target > 0 ? dead : -dead);
}

int32_t hero_velocity_step(struct hero_velocity *loop, fix_t target, fix_t measured) {
  if (target == 0) {
    hero_velocity_reset(loop);
    return 0;
  }
  fix_t error = fix_clamp(target - measured, HERO_MAX_RIM_SPEED); /* keeps the products below within 32 bits */
  fix_t unclamped = feed_forward(fix_clamp(target, HERO_MAX_RIM_SPEED)) + error * HERO_VELOCITY_KP + loop->integral;
  fix_t pulse = fix_clamp(unclamped, SPAN);
  if (pulse == unclamped || (unclamped > 0) != (error > 0)) { /* anti-windup: integrate only what helps */
    loop->integral = fix_clamp(loop->integral + error * HERO_VELOCITY_KI_STEP, SPAN);
  }
  return (pulse + (pulse > 0 ? FIX_ONE / 2 : -FIX_ONE / 2)) / FIX_ONE;
}
