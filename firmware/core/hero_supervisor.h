/* The one place that decides whether the robot may move.
 *
 *            self-test passed            START, then its time, with a lease
 *     BOOT ------------------> HOLD ------------------------------------------> RUN
 *                               ^ ^ <----------- STOP, or the lease ends ------- |
 *                          REARM | | REARM, and the fault is gone                |
 *                           ESTOP  FAULT <------ a fault, from BOOT, HOLD, RUN --+
 *
 * ESTOP is reached from every state by an ESTOP command and left by REARM alone. Motion needs RUN and a lease that has
 * not ended; the lease is looked at in every control period, whatever the radio does. */
#ifndef HERO_SUPERVISOR_H
#define HERO_SUPERVISOR_H

#include "hero_link.h"

enum hero_state { HERO_STATE_BOOT = 0, HERO_STATE_HOLD, HERO_STATE_RUN, HERO_STATE_ESTOP, HERO_STATE_FAULT };

enum hero_fault { /* bits */
  HERO_FAULT_SETTINGS = 1, /* no robot number, key or random source */
  HERO_FAULT_BATTERY = 2,
  HERO_FAULT_SENSOR = 4,
  HERO_FAULT_STALL = 8 /* full pulse, and no encoder edge */
};

enum hero_reason { /* why the state was last changed */
  HERO_BECAUSE_BOOT = 0,
  HERO_BECAUSE_SELF_TEST,
  HERO_BECAUSE_START,
  HERO_BECAUSE_STOP,
  HERO_BECAUSE_LEASE, /* the lease ended */
  HERO_BECAUSE_ESTOP,
  HERO_BECAUSE_REARM,
  HERO_BECAUSE_FAULT
};

enum hero_result { /* what became of a command */
  HERO_DONE = 0,
  HERO_WRONG_STATE,
  HERO_OUT_OF_RANGE,
  HERO_OLD_VERSION,   /* the controller that is loaded is as new or newer */
  HERO_WRONG_VERSION, /* the controller that is loaded is not the one to be started */
  HERO_TOO_LATE,      /* the time that it carries has passed */
  HERO_TOO_FAR,       /* the time that it carries lies beyond the horizon */
  HERO_NO_LEASE,      /* a start needs a running lease */
  HERO_FAULT_STAYS    /* rearmed, but the cause is still there */
};

struct hero_supervisor {
  uint8_t state, reason;
  uint8_t faults; /* bits that led to FAULT, or that are present */
  bool start_pending;
  uint64_t start_us;
  uint64_t lease_us; /* motion is granted until then; 0: no lease */
  uint32_t version;  /* of the controller; 0: none yet */
  struct hero_controller controller;
};

void hero_supervisor_start(struct hero_supervisor *supervisor);

/* Acts on an authentic command (not HELLO); returns what became of it. */
enum hero_result hero_supervisor_command(struct hero_supervisor *supervisor, const struct hero_command *command, uint64_t now_us);

/* To be called in every control period: ends leases, starts on time, falls into FAULT. `ready`: the self-test passed. */
void hero_supervisor_tick(struct hero_supervisor *supervisor, uint8_t faults, bool ready, uint64_t now_us);

/* Whether the servos may be driven at this time. */
bool hero_supervisor_may_move(const struct hero_supervisor *supervisor, uint64_t now_us);

#endif
