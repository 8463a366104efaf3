#include "hero_sim.h"

#include <math.h>
#include <string.h>

#include "../../core/hero_config.h"

#define SUBSTEP_US 1000u
#define SERVER_PORT 1u /* the mailbox's stand-in for the server's address */

static const double TICK_M = (double)HERO_TICK_SPEED / 65536e6;
static const double FULL_SPEED = (double)HERO_MAX_RIM_SPEED / 65536.0;

/* --- mailboxes -------------------------------------------------------------------------------------------------- */

static bool post(struct hero_mailbox *box, const uint8_t *data, size_t size) {
  if (box->waiting == HERO_MAILBOX) return false;
  struct hero_datagram *slot = &box->datagram[(box->first + box->waiting) % HERO_MAILBOX];
  slot->size = size < sizeof slot->data ? size : sizeof slot->data;
  memcpy(slot->data, data, slot->size);
  box->waiting++;
  return true;
}

static size_t take(struct hero_mailbox *box, uint8_t *data, size_t room) {
  if (box->waiting == 0) return 0;
  const struct hero_datagram *slot = &box->datagram[box->first];
  size_t size = slot->size < room ? slot->size : room;
  memcpy(data, slot->data, size);
  box->first = (box->first + 1) % HERO_MAILBOX;
  box->waiting--;
  return size;
}

/* --- the ten functions ------------------------------------------------------------------------------------------- */

static bool load_settings(void *context, struct hero_settings *settings) {
  *settings = ((struct hero_sim *)context)->settings;
  return true;
}

/* splitmix64: a simulated robot's nonces have to differ and to repeat with the seed, not to be secret. */
static uint64_t random64(void *context) {
  struct hero_sim *sim = context;
  if (sim->random == 0) return 0;
  uint64_t z = sim->random += 0x9e3779b97f4a7c15u;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
  return (z ^ (z >> 31)) | 1u;
}

static void servo_write(void *context, int side, uint16_t pulse_us) {
  struct hero_sim *sim = context;
  sim->wheel[side].pulse_us = pulse_us;
  sim->wheel[side].pulse_written_us = sim->now_us;
}

static void encoder_read(void *context, int side, uint32_t *count, uint32_t *edge_us) {
  const struct hero_sim_wheel *wheel = &((struct hero_sim *)context)->wheel[side];
  *count = wheel->count;
  *edge_us = wheel->edge_us;
}

static bool range_poll(void *context, struct hero_range *reading) {
  struct hero_sim *sim = context;
  if (sim->sensor_dead || sim->now_us < sim->reading_us) return false;
  sim->reading_us += HERO_TOF_PERIOD_MS * 1000u;
  if (sim->reading_us <= sim->now_us) sim->reading_us = sim->now_us + HERO_TOF_PERIOD_MS * 1000u;
  reading->valid = sim->distance_m > 0.0;
  reading->distance_mm = (uint16_t)(sim->distance_m * 1000.0 + 0.5);
  return true;
}

static void range_restart(void *context) {
  struct hero_sim *sim = context;
  sim->reading_us = sim->now_us + HERO_TOF_BUDGET_MS * 1000u;
}

static uint16_t battery_read(void *context) { return ((struct hero_sim *)context)->battery_mv; }

static void led_write(void *context, bool on) { ((struct hero_sim *)context)->led = on; }

static size_t receive(void *context, uint8_t *data, size_t room, struct hero_peer *from) {
  *from = (struct hero_peer){.address = 0, .port = SERVER_PORT};
  return take(&((struct hero_sim *)context)->inbox, data, room);
}

static void send(void *context, const uint8_t *data, size_t size, struct hero_peer to) {
  struct hero_mailbox *box = &((struct hero_sim *)context)->outbox;
  (void)to;
  if (box->waiting == HERO_MAILBOX) { /* nobody collects: the oldest report goes */
    box->first = (box->first + 1) % HERO_MAILBOX;
    box->waiting--;
  }
  post(box, data, size);
}

/* --- the bench --------------------------------------------------------------------------------------------------- */

size_t hero_sim_size(void) { return sizeof(struct hero_sim); }

void hero_sim_init(struct hero_sim *sim, uint16_t robot, const uint8_t key[HERO_KEY_SIZE], uint64_t seed) {
  memset(sim, 0, sizeof *sim);
  sim->settings.robot = robot;
  memcpy(sim->settings.key, key, HERO_KEY_SIZE);
  sim->random = seed * 2u + 1u;
  sim->battery_mv = HERO_BATTERY_NOMINAL_MV;
  sim->hal = (struct hero_hal){.context = sim,
                               .load_settings = load_settings,
                               .random64 = random64,
                               .servo_write = servo_write,
                               .encoder_read = encoder_read,
                               .range_poll = range_poll,
                               .range_restart = range_restart,
                               .battery_read = battery_read,
                               .led_write = led_write,
                               .receive = receive,
                               .send = send};
  for (int side = 0; side < 2; side++) sim->wheel[side].path = TICK_M * (double)(random64(sim) >> 11) / 9007199254740992.0;
}

void hero_sim_boot(struct hero_sim *sim) {
  for (int side = 0; side < 2; side++) {
    double phase = fmod(fabs(sim->wheel[side].path), TICK_M);
    sim->wheel[side] = (struct hero_sim_wheel){.path = phase, .grip = 1.0};
  }
  sim->inbox.waiting = sim->outbox.waiting = 0;
  sim->now_us = 0;
  sim->sequence = 0;
  hero_robot_boot(&sim->robot, &sim->hal, sim->now_us);
}

/* Steady rim speed of the servo: linear between dead band and span, to the speed without load; mirrored on the right. */
static double servo_speed(const struct hero_sim *sim, int side) {
  const struct hero_sim_wheel *wheel = &sim->wheel[side];
  if (wheel->pulse_us == 0 || sim->now_us - wheel->pulse_written_us > HERO_SERVO_REFRESH_US) return 0.0;
  uint16_t halt = sim->settings.halt_us[side] ? sim->settings.halt_us[side] : HERO_SERVO_HALT_US;
  double offset = (double)wheel->pulse_us - (double)halt;
  if (side == HERO_RIGHT) offset = -offset;
  double dead = HERO_SERVO_DEADBAND_US / 2.0, beyond = fabs(offset) - dead;
  if (beyond <= 0.0) return 0.0;
  double share = beyond / (HERO_SERVO_SPAN_US - dead);
  return copysign(share < 1.0 ? share * FULL_SPEED : FULL_SPEED, offset);
}

/* Turns the wheel on and stamps each edge with the time at which it was crossed. */
static void turn_wheel(struct hero_sim_wheel *wheel, uint64_t from_us, uint32_t step_us) {
  double start = wheel->path, end = start + wheel->speed * wheel->grip * step_us * 1e-6;
  double first = floor((start < end ? start : end) / TICK_M), last = floor((start < end ? end : start) / TICK_M);
  wheel->path = end;
  if (last <= first) return;
  double crossed = (end > start ? last : first + 1.0) * TICK_M; /* the edge that was crossed last */
  wheel->count += (uint32_t)(last - first);
  wheel->edge_us = (uint32_t)(from_us + (uint64_t)(step_us * (crossed - start) / (end - start)));
}

static void substep(struct hero_sim *sim, uint32_t step_us) {
  double follow = 1.0 - exp(-(double)step_us / HERO_SERVO_LAG_US);
  for (int side = 0; side < 2; side++) {
    struct hero_sim_wheel *wheel = &sim->wheel[side];
    wheel->speed += follow * (servo_speed(sim, side) - wheel->speed);
    wheel->driven += wheel->speed * step_us * 1e-6;
    turn_wheel(wheel, sim->now_us, step_us);
  }
  sim->now_us += step_us;
  hero_robot_poll(&sim->robot, sim->now_us);
}

void hero_sim_run(struct hero_sim *sim, uint64_t until_us) {
  while (sim->now_us < until_us) {
    uint64_t rest = until_us - sim->now_us;
    substep(sim, rest < SUBSTEP_US ? (uint32_t)rest : SUBSTEP_US);
  }
}

/* What a bystander would notice: the state, and whether the servos get pulses. */
static unsigned seen_from_outside(const struct hero_sim *sim) {
  bool driven = sim->wheel[HERO_LEFT].pulse_us != 0 || sim->wheel[HERO_RIGHT].pulse_us != 0;
  return sim->robot.supervisor.state * 2u + driven;
}

uint32_t hero_sim_run_together(struct hero_sim *const *sims, size_t robots, uint32_t most_us) {
  uint32_t elapsed_us = 0;
  bool news = false;
  while (elapsed_us < most_us && !news) {
    uint32_t step_us = most_us - elapsed_us < SUBSTEP_US ? most_us - elapsed_us : SUBSTEP_US;
    for (size_t i = 0; i < robots; i++) {
      unsigned before = seen_from_outside(sims[i]);
      substep(sims[i], step_us);
      news |= sims[i]->outbox.waiting > 0 || seen_from_outside(sims[i]) != before;
    }
    elapsed_us += step_us;
  }
  return elapsed_us;
}

bool hero_sim_deliver(struct hero_sim *sim, const uint8_t *data, size_t size) { return post(&sim->inbox, data, size); }

size_t hero_sim_collect(struct hero_sim *sim, uint8_t *data, size_t room) { return take(&sim->outbox, data, room); }

bool hero_sim_command(struct hero_sim *sim, uint8_t type, const uint8_t *payload, uint16_t payload_size) {
  uint8_t data[HERO_FRAME_MAX];
  struct hero_frame frame = {.type = type, .robot = sim->settings.robot, .payload = payload, .payload_size = payload_size};
  if (type != HERO_HELLO) {
    frame.nonce = sim->robot.link.nonce;
    frame.sequence = ++sim->sequence;
  }
  size_t size = hero_frame_seal(sim->settings.key, &frame, data, sizeof data);
  return size > 0 && hero_sim_deliver(sim, data, size);
}

static void renew_lease(struct hero_sim *sim) {
  uint8_t until[8];
  hero_write64(until, sim->now_us + HERO_LEASE_MAX_US);
  hero_sim_command(sim, HERO_HEARTBEAT, until, sizeof until);
}

bool hero_sim_start(struct hero_sim *sim, const int32_t gene[4]) {
  uint8_t controller[20], start[12], *p = hero_write32(controller, 1);
  hero_sim_boot(sim);
  while (sim->robot.supervisor.state == HERO_STATE_BOOT && sim->now_us < 1000000u) hero_sim_run(sim, sim->now_us + SUBSTEP_US);
  for (int i = 0; i < 4; i++) p = hero_write32(p, (uint32_t)gene[i]);
  hero_sim_command(sim, HERO_CONTROLLER, controller, sizeof controller);
  renew_lease(sim);
  hero_sim_run(sim, sim->now_us + 2 * SUBSTEP_US);
  hero_write32(hero_write64(start, sim->now_us + HERO_CONTROL_PERIOD_US), 1);
  hero_sim_command(sim, HERO_START, start, sizeof start);
  for (int i = 0; i < 100 && sim->robot.supervisor.state == HERO_STATE_HOLD; i++) hero_sim_run(sim, sim->now_us + SUBSTEP_US);
  return sim->robot.supervisor.state == HERO_STATE_RUN;
}

void hero_sim_step(struct hero_sim *const *sims, size_t robots, const double *distance_m, const double *grip, uint32_t dt_us,
                   double *rim_speed) {
  for (size_t i = 0; i < robots; i++) {
    struct hero_sim *sim = sims[i];
    double before[2] = {sim->wheel[0].driven, sim->wheel[1].driven};
    sim->distance_m = distance_m[i];
    for (int side = 0; side < 2; side++) sim->wheel[side].grip = grip ? grip[2 * i + (size_t)side] : 1.0;
    uint64_t end_us = sim->now_us + dt_us;
    while (sim->now_us < end_us) { /* a lease is shorter than a long tick may be */
      uint64_t slice = sim->now_us + HERO_LEASE_MAX_US / 2;
      renew_lease(sim);
      hero_sim_run(sim, slice < end_us ? slice : end_us);
    }
    for (int side = 0; side < 2; side++) rim_speed[2 * i + (size_t)side] = (sim->wheel[side].driven - before[side]) / (dt_us * 1e-6);
  }
}

static void look_at_motion(const struct hero_sim *sim, struct hero_sim_view *view) {
  view->command[0] = sim->robot.command.v;
  view->command[1] = sim->robot.command.omega;
  view->x = sim->robot.odometry.x;
  view->y = sim->robot.odometry.y;
  view->heading = sim->robot.odometry.heading;
  for (int side = 0; side < 2; side++) {
    view->edges[side] = sim->wheel[side].count;
    view->measured[side] = sim->robot.measured.rim[side];
    view->rim_speed[side] = sim->wheel[side].speed;
    view->path[side] = sim->wheel[side].path;
    view->pulse_us[side] = sim->wheel[side].pulse_us;
  }
}

void hero_sim_look(const struct hero_sim *sim, struct hero_sim_view *view) {
  const struct hero_supervisor *supervisor = &sim->robot.supervisor;
  *view = (struct hero_sim_view){.now_us = sim->now_us,
                                 .nonce = sim->robot.link.nonce,
                                 .lease_us = supervisor->lease_us,
                                 .last_sequence = sim->robot.link.last_sequence,
                                 .version = supervisor->version,
                                 .result_sequence = sim->robot.result_sequence,
                                 .range_mm = sim->robot.detection.range_mm,
                                 .refused = sim->robot.link.refused,
                                 .state = supervisor->state,
                                 .reason = supervisor->reason,
                                 .faults = supervisor->faults,
                                 .result = sim->robot.result,
                                 .seen = sim->robot.detection.seen,
                                 .start_pending = supervisor->start_pending,
                                 .may_move = hero_supervisor_may_move(supervisor, sim->now_us),
                                 .led = sim->led};
  look_at_motion(sim, view);
}

void hero_sim_set(struct hero_sim *sim, double distance_m, uint16_t battery_mv, bool sensor_dead) {
  sim->distance_m = distance_m;
  sim->battery_mv = battery_mv;
  sim->sensor_dead = sensor_dead;
}

void hero_sim_set_halts(struct hero_sim *sim, uint16_t left_us, uint16_t right_us) {
  sim->settings.halt_us[HERO_LEFT] = left_us;
  sim->settings.halt_us[HERO_RIGHT] = right_us;
}
