#include "hero_odometry.h"

#include "hero_config.h"

void hero_odometry_add(struct hero_odometry *odometry, int32_t left, int32_t right) {
  if (left == 0 && right == 0) return;
  uint32_t half_turn = ((uint32_t)right - (uint32_t)left) * HERO_HALF_TICK_TURN;
  uint32_t halfway = odometry->heading + half_turn; /* the chord of an arc points along its middle */
  int32_t path = (left + right) * HERO_HALF_TICK;   /* m as Q8.24 */
  odometry->x += fix_mul(path, fix_cos(halfway));
  odometry->y += fix_mul(path, fix_sin(halfway));
  odometry->heading += 2u * half_turn;
}
