/* Unicycle to wheels and back. */
#ifndef HERO_WHEELS_H
#define HERO_WHEELS_H

#include "hero_controller.h"

enum { HERO_LEFT = 0, HERO_RIGHT = 1 };

struct hero_wheels {
  fix_t rim[2]; /* rim speed of the left and right wheel, m/s */
};

/* Rim speeds for a motion; beyond what the servos reach both are scaled alike, so that the path keeps its curvature. */
struct hero_wheels hero_wheels_from(struct hero_unicycle motion);

struct hero_unicycle hero_wheels_motion(struct hero_wheels wheels);

#endif
