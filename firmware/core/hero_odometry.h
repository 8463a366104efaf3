/* Dead reckoning from every encoder edge of both wheels. */
#ifndef HERO_ODOMETRY_H
#define HERO_ODOMETRY_H

#include "hero_fixed.h"

struct hero_odometry {
  int32_t x, y;     /* m as Q8.24: 60 nm steps, +-128 m */
  uint32_t heading; /* binary angle: 2^32 is one turn, counter-clockwise; exact in ticks, wraps by itself */
};

/* Adds signed edges of the left and right wheel. */
void hero_odometry_add(struct hero_odometry *odometry, int32_t left, int32_t right);

#endif
