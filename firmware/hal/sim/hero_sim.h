/* A simulated board: servos, encoders, range sensor, battery and a mailbox around the robot's own code.
 *
 * This is the lab bench, not the robot: it may use floating point. Time is simulated and only moves in hero_sim_run, so
 * the same calls give the same bits. */
#ifndef HERO_SIM_H
#define HERO_SIM_H

#include "../../core/hero_robot.h"

#define HERO_MAILBOX 16u /* datagrams that wait at most; more are lost, as on a network card */

struct hero_datagram {
  size_t size;
  uint8_t data[HERO_FRAME_MAX + 64]; /* room for one that is too long */
};

struct hero_mailbox {
  uint32_t first, waiting;
  struct hero_datagram datagram[HERO_MAILBOX];
};

struct hero_sim_wheel {
  double speed;       /* rim speed of the servo, m/s, forward positive */
  double grip;        /* part of that speed that the wheel turns at: 1, or less when something holds the robot */
  double path;        /* m that the rim turned since power-on, with a random start within a tick */
  double driven;      /* m that the servo would have turned a free wheel */
  uint32_t count;     /* encoder edges */
  uint32_t edge_us;
  uint16_t pulse_us;  /* 0: no pulses */
  uint64_t pulse_written_us;
};

struct hero_sim {
  struct hero_robot robot;
  struct hero_hal hal;
  struct hero_settings settings;
  struct hero_sim_wheel wheel[2];
  struct hero_mailbox inbox, outbox;
  double distance_m;    /* to what stands before the sensor; 0: nothing */
  uint64_t reading_us;  /* time of the sensor's next reading */
  uint64_t now_us;
  uint64_t random;      /* state of the nonce source; 0: the source is broken */
  uint32_t sequence;    /* of the last command sealed by hero_sim_command */
  uint16_t battery_mv;
  bool sensor_dead, led;
};

#include "hero_sim_api.h"

#endif
