#include "hero_wheels.h"

#include "hero_config.h"

struct hero_wheels hero_wheels_from(struct hero_unicycle motion) {
  fix_t turn = fix_mul(motion.omega, HERO_WHEEL_BASE) / 2;
  struct hero_wheels wheels = {{motion.v - turn, motion.v + turn}};
  fix_t left = fix_abs(wheels.rim[HERO_LEFT]), right = fix_abs(wheels.rim[HERO_RIGHT]);
  fix_t fastest = left > right ? left : right;
  if (fastest <= HERO_MAX_RIM_SPEED) return wheels;
  fix_t scale = fix_ratio(HERO_MAX_RIM_SPEED, fastest);
  for (int side = 0; side < 2; side++) wheels.rim[side] = fix_mul(wheels.rim[side], scale);
  return wheels;
}

struct hero_unicycle hero_wheels_motion(struct hero_wheels wheels) {
  fix_t left = wheels.rim[HERO_LEFT], right = wheels.rim[HERO_RIGHT];
  return (struct hero_unicycle){.v = (left + right) / 2, .omega = fix_mul(right - left, HERO_WHEEL_BASE_INVERSE)};
}
