/* The paper's controller: four numbers, one bit of sensing. */
#ifndef HERO_CONTROLLER_H
#define HERO_CONTROLLER_H

#include <stdbool.h>

#include "hero_fixed.h"

struct hero_controller {
  fix_t gene[4]; /* v0, w0, v1, w1: m/s and rad/s, (v0, w0) while nothing is detected, else (v1, w1) */
};

struct hero_unicycle {
  fix_t v;     /* forward speed, m/s */
  fix_t omega; /* turn rate, rad/s, counter-clockwise */
};

/* Whether every gene lies within the robot's physical limits. */
bool hero_controller_in_range(const struct hero_controller *controller);

struct hero_unicycle hero_controller_act(const struct hero_controller *controller, bool detected);

#endif
