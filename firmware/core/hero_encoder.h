/* Wheel speed from the time between encoder edges.
 *
 * One tick is 1.6 mm of rim: counted over a control period of 20 ms that would be steps of 80 mm/s. The time between
 * edges resolves the same speed to a fraction of a percent. The encoder has one channel: its sign is the servo's. */
#ifndef HERO_ENCODER_H
#define HERO_ENCODER_H

#include <stdbool.h>

#include "hero_fixed.h"

struct hero_encoder {
  uint32_t count;    /* edges counted so far, wraps */
  uint32_t edge_us;  /* time of the last edge, low 32 bits of robot time */
  uint32_t quiet_us; /* the wheel is known to have been without an edge since this time */
  fix_t interval;    /* |speed| over the last interval between edges, m/s; holds while `known` */
  bool known;
  bool rested; /* no edge for so long that the next one ends no interval */
  int8_t direction;  /* sign that edges are counted with: -1 or +1 */
  int8_t driven;     /* sign of the pulse given: -1, 0, +1 */
  uint32_t driven_us; /* since when */
};

void hero_encoder_start(struct hero_encoder *encoder, uint32_t count, uint32_t now_us);

/* Tells the encoder the direction in which the servo is driven from now on. */
void hero_encoder_drive(struct hero_encoder *encoder, int sign, uint32_t now_us);

/* Takes the interrupt's counter and time stamp; returns the new edges with their sign. */
int32_t hero_encoder_take(struct hero_encoder *encoder, uint32_t count, uint32_t edge_us, uint32_t now_us);

/* Signed rim speed, m/s. While no interval is known the wheel is believed to do what it is told (`target`), as far as
 * the time without an edge allows. */
fix_t hero_encoder_speed(const struct hero_encoder *encoder, fix_t target, uint32_t now_us);

#endif
