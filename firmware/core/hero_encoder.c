#include "hero_encoder.h"

#include "hero_config.h"

#define MOST_TIMED 40u    /* edges in one interval that a speed is worked out from: keeps the product within 32 bits */
#define MOST_COUNTED 1000u /* edges taken at once: 6 s of full speed; more is a fault of the counter */
#define MOST_SPEED (16 * FIX_ONE)

/* Time since an event, us; 0 for one that an interrupt stamped after `now` was taken. */
static uint32_t elapsed(uint32_t now_us, uint32_t since_us) {
  uint32_t time = now_us - since_us;
  return time > INT32_MAX ? 0 : time;
}

void hero_encoder_start(struct hero_encoder *encoder, uint32_t count, uint32_t now_us) {
  *encoder = (struct hero_encoder){.count = count, .edge_us = now_us, .quiet_us = now_us, .rested = true, .direction = 1};
}

void hero_encoder_drive(struct hero_encoder *encoder, int sign, uint32_t now_us) {
  if (sign == encoder->driven) return;
  if (encoder->driven == 0) encoder->quiet_us = now_us; /* it stood: no edge was to be expected before */
  encoder->driven = (int8_t)sign;
  encoder->driven_us = now_us;
}

/* After a reversal the wheel coasts on: edges keep the old sign until it must have turned round. */
static void turn_round(struct hero_encoder *encoder, uint32_t now_us) {
  if (encoder->driven == 0 || encoder->driven == encoder->direction) return;
  if (encoder->known && elapsed(now_us, encoder->driven_us) < HERO_ENCODER_REVERSAL_US) return;
  encoder->direction = encoder->driven;
  encoder->known = false;
  encoder->quiet_us = now_us;
}

static void take_edges(struct hero_encoder *encoder, uint32_t edges, uint32_t edge_us) {
  uint32_t interval = edge_us - encoder->edge_us;
  encoder->known = !encoder->rested && interval > 0 && interval <= HERO_ENCODER_STANDSTILL_US;
  if (encoder->known) {
    uint32_t speed = (edges > MOST_TIMED ? MOST_TIMED : edges) * HERO_TICK_SPEED / interval;
    encoder->interval = speed > (uint32_t)MOST_SPEED ? MOST_SPEED : (fix_t)speed;
  }
  encoder->rested = false;
  encoder->edge_us = encoder->quiet_us = edge_us;
}

int32_t hero_encoder_take(struct hero_encoder *encoder, uint32_t count, uint32_t edge_us, uint32_t now_us) {
  uint32_t edges = count - encoder->count;
  turn_round(encoder, now_us);
  if (edges > 0) {
    take_edges(encoder, edges, edge_us);
  } else if (elapsed(now_us, encoder->edge_us) > HERO_ENCODER_STANDSTILL_US) {
    encoder->known = false;
    encoder->rested = true;
  }
  encoder->count = count;
  return encoder->direction * (int32_t)(edges > MOST_COUNTED ? MOST_COUNTED : edges);
}

fix_t hero_encoder_speed(const struct hero_encoder *encoder, fix_t target, uint32_t now_us) {
  uint32_t quiet = elapsed(now_us, encoder->quiet_us);
  uint32_t bound = quiet > 0 ? HERO_TICK_SPEED / quiet : (uint32_t)FIX_MAX; /* faster would have given an edge */
  fix_t speed = encoder->known ? encoder->interval : (encoder->driven != 0 ? fix_abs(target) : 0);
  if ((uint32_t)speed > bound) speed = (fix_t)bound;
  bool backwards = encoder->known ? encoder->direction < 0 : target < 0;
  return backwards ? -speed : speed;
}
