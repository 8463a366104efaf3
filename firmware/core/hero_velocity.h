/* A wheel's velocity loop: feed-forward, PI, anti-windup. */
#ifndef HERO_VELOCITY_H
#define HERO_VELOCITY_H

#include "hero_fixed.h"

struct hero_velocity {
  fix_t integral; /* us of pulse */
};

void hero_velocity_reset(struct hero_velocity *loop);

/* Offset from the halt pulse, us, for a wheel that should run at `target` and runs at `measured`, m/s; called once a
 * control period. A target of zero gives the halt pulse and clears the integral. */
int32_t hero_velocity_step(struct hero_velocity *loop, fix_t target, fix_t measured);

#endif
