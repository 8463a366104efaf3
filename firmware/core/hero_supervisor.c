#include "hero_supervisor.h"

#include <string.h>

#include "hero_config.h"

void hero_supervisor_start(struct hero_supervisor *supervisor) { memset(supervisor, 0, sizeof *supervisor); }

/* Every change of state drops a pending start; none but RUN and HOLD keep a lease. */
static void enter(struct hero_supervisor *supervisor, enum hero_state state, enum hero_reason reason) {
  supervisor->state = (uint8_t)state;
  supervisor->reason = (uint8_t)reason;
  supervisor->start_pending = false;
  if (state != HERO_STATE_RUN && state != HERO_STATE_HOLD) supervisor->lease_us = 0;
}

static bool leased(const struct hero_supervisor *supervisor, uint64_t now_us) { return supervisor->lease_us > now_us; }

static enum hero_result take_lease(struct hero_supervisor *supervisor, uint64_t until_us, uint64_t now_us) {
  if (supervisor->state != HERO_STATE_HOLD && supervisor->state != HERO_STATE_RUN) return HERO_WRONG_STATE;
  if (until_us <= now_us) return HERO_TOO_LATE; /* it was long on its way: it neither grants nor takes */
  uint64_t most = now_us + HERO_LEASE_MAX_US;
  supervisor->lease_us = until_us < most ? until_us : most;
  return HERO_DONE;
}

static enum hero_result take_start(struct hero_supervisor *supervisor, const struct hero_command *command, uint64_t now_us) {
  if (supervisor->state != HERO_STATE_HOLD) return HERO_WRONG_STATE;
  if (supervisor->version == 0 || command->version != supervisor->version) return HERO_WRONG_VERSION;
  if (!leased(supervisor, now_us)) return HERO_NO_LEASE;
  if (command->time_us <= now_us) return HERO_TOO_LATE;
  if (command->time_us - now_us > HERO_START_HORIZON_US) return HERO_TOO_FAR;
  supervisor->start_pending = true;
  supervisor->start_us = command->time_us;
  return HERO_DONE;
}

static enum hero_result take_controller(struct hero_supervisor *supervisor, const struct hero_command *command) {
  if (supervisor->state != HERO_STATE_HOLD || supervisor->start_pending) return HERO_WRONG_STATE;
  if (command->version <= supervisor->version) return HERO_OLD_VERSION;
  if (!hero_controller_in_range(&command->controller)) return HERO_OUT_OF_RANGE;
  supervisor->version = command->version;
  supervisor->controller = command->controller;
  return HERO_DONE;
}

static enum hero_result take_stop(struct hero_supervisor *supervisor) {
  if (supervisor->state != HERO_STATE_HOLD && supervisor->state != HERO_STATE_RUN) return HERO_WRONG_STATE;
  enter(supervisor, HERO_STATE_HOLD, HERO_BECAUSE_STOP);
  return HERO_DONE;
}

static enum hero_result rearm(struct hero_supervisor *supervisor) {
  if (supervisor->state != HERO_STATE_ESTOP && supervisor->state != HERO_STATE_FAULT) return HERO_WRONG_STATE;
  if (supervisor->faults != 0) return HERO_FAULT_STAYS;
  enter(supervisor, HERO_STATE_HOLD, HERO_BECAUSE_REARM);
  return HERO_DONE;
}

enum hero_result hero_supervisor_command(struct hero_supervisor *supervisor, const struct hero_command *command, uint64_t now_us) {
  switch (command->type) {
    case HERO_HEARTBEAT: return take_lease(supervisor, command->time_us, now_us);
    case HERO_START: return take_start(supervisor, command, now_us);
    case HERO_STOP: return take_stop(supervisor);
    case HERO_CONTROLLER: return take_controller(supervisor, command);
    case HERO_REARM: return rearm(supervisor);
    default: /* HERO_ESTOP; and whatever should not be here stops as well */
      enter(supervisor, HERO_STATE_ESTOP, HERO_BECAUSE_ESTOP);
      return HERO_DONE;
  }
}

static void look_at_lease(struct hero_supervisor *supervisor, uint64_t now_us) {
  if (leased(supervisor, now_us)) return;
  supervisor->lease_us = 0; /* for good: no clock can bring it back */
  if (supervisor->state == HERO_STATE_RUN || supervisor->start_pending) enter(supervisor, HERO_STATE_HOLD, HERO_BECAUSE_LEASE);
}

void hero_supervisor_tick(struct hero_supervisor *supervisor, uint8_t faults, bool ready, uint64_t now_us) {
  supervisor->faults = faults;
  look_at_lease(supervisor, now_us);
  if (faults != 0 && supervisor->state != HERO_STATE_ESTOP && supervisor->state != HERO_STATE_FAULT) {
    enter(supervisor, HERO_STATE_FAULT, HERO_BECAUSE_FAULT);
  }
  if (supervisor->state == HERO_STATE_BOOT && ready) enter(supervisor, HERO_STATE_HOLD, HERO_BECAUSE_SELF_TEST);
  if (supervisor->start_pending && now_us >= supervisor->start_us) enter(supervisor, HERO_STATE_RUN, HERO_BECAUSE_START);
}

bool hero_supervisor_may_move(const struct hero_supervisor *supervisor, uint64_t now_us) {
  return supervisor->state == HERO_STATE_RUN && leased(supervisor, now_us);
}
