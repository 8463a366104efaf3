/* The whole robot: boards call hero_robot_boot once and hero_robot_poll for ever. */
#ifndef HERO_ROBOT_H
#define HERO_ROBOT_H

#include "hero_battery.h"
#include "hero_encoder.h"
#include "hero_hal.h"
#include "hero_odometry.h"
#include "hero_supervisor.h"
#include "hero_velocity.h"
#include "hero_wheels.h"

struct hero_robot {
  const struct hero_hal *hal;
  struct hero_settings settings;
  struct hero_link link;
  struct hero_supervisor supervisor;
  struct hero_detection detection;
  struct hero_battery battery;
  struct hero_odometry odometry;
  struct hero_encoder encoder[2];
  struct hero_velocity velocity[2];
  struct hero_unicycle command; /* what the controller asks for now; zero unless it may move */
  struct hero_wheels measured;
  uint64_t stalled_since_us[2]; /* since when a wheel gets the full pulse without an edge; 0: it does not */
  uint64_t control_us;     /* time of the next control period */
  uint64_t status_us;      /* time of the next report */
  uint32_t result_sequence; /* of the last command that was no heartbeat */
  uint8_t result;
  uint8_t faults;           /* bits present now */
  bool sensor_fell_silent;  /* and has not been restarted yet */
  struct hero_peer server;  /* sender of the last accepted command; port 0: none yet */
};

/* Starts from nothing: reads settings, draws the boot nonce, releases the servos. */
void hero_robot_boot(struct hero_robot *robot, const struct hero_hal *hal, uint64_t now_us);

/* Does what is due: receives, senses, supervises, controls, reports. To be called at least once a millisecond; `now_us`
 * is the time since power-on and never falls. */
void hero_robot_poll(struct hero_robot *robot, uint64_t now_us);

#endif
