#include "hero_robot.h"

#include <string.h>

#include "hero_config.h"
#include "hero_report.h"

#define BLINK_SHIFT 18 /* the LED changes every 2^18 us, a quarter of a second, or a fraction of that */

static void release_servos(struct hero_robot *robot) {
  for (int side = 0; side < 2; side++) {
    robot->hal->servo_write(robot->hal->context, side, 0);
    hero_velocity_reset(&robot->velocity[side]);
    robot->stalled_since_us[side] = 0;
  }
  robot->command = (struct hero_unicycle){0, 0};
}

static void read_encoder(struct hero_robot *robot, int side, uint32_t *count, uint32_t *edge_us) {
  robot->hal->encoder_read(robot->hal->context, side, count, edge_us);
}

/* Settings and boot nonce; without either nothing is ever accepted and the robot stays in FAULT. */
static void draw_identity(struct hero_robot *robot) {
  const struct hero_hal *hal = robot->hal;
  bool known = hal->load_settings(hal->context, &robot->settings);
  uint64_t nonce = known ? hal->random64(hal->context) : 0;
  hero_link_start(&robot->link, robot->settings.robot, robot->settings.key, nonce);
  if (nonce == 0) robot->faults |= HERO_FAULT_SETTINGS;
}

void hero_robot_boot(struct hero_robot *robot, const struct hero_hal *hal, uint64_t now_us) {
  memset(robot, 0, sizeof *robot);
  robot->hal = hal;
  draw_identity(robot);
  hero_supervisor_start(&robot->supervisor);
  hero_detection_start(&robot->detection, now_us);
  hero_battery_start(&robot->battery, now_us);
  for (int side = 0; side < 2; side++) {
    uint32_t count, edge_us;
    read_encoder(robot, side, &count, &edge_us);
    hero_encoder_start(&robot->encoder[side], count, (uint32_t)now_us);
    if (robot->settings.halt_us[side] == 0) robot->settings.halt_us[side] = HERO_SERVO_HALT_US;
  }
  robot->control_us = now_us;
  release_servos(robot);
  hal->range_restart(hal->context);
}

static void execute(struct hero_robot *robot, const struct hero_command *command, struct hero_peer from, uint64_t now_us) {
  if (command->type == HERO_HELLO) {
    hero_report_welcome(robot, command->challenge, from, now_us);
    return;
  }
  robot->server = from;
  enum hero_result result = hero_supervisor_command(&robot->supervisor, command, now_us);
  if (!hero_supervisor_may_move(&robot->supervisor, now_us)) release_servos(robot); /* at once, not in the next period */
  if (command->type == HERO_HEARTBEAT) return;
  robot->result = (uint8_t)result;
  robot->result_sequence = command->sequence;
  hero_report_status(robot, now_us);
}

/* A few frames a call, so that a flood cannot hold up the control loop. */
static void listen(struct hero_robot *robot, uint64_t now_us) {
  uint8_t data[HERO_FRAME_MAX];
  struct hero_command command;
  struct hero_peer from = {0, 0};
  for (int frame = 0; frame < HERO_FRAMES_PER_POLL; frame++) {
    size_t size = robot->hal->receive(robot->hal->context, data, sizeof data, &from);
    if (size == 0) return;
    if (hero_link_open(&robot->link, data, size, &command) == HERO_ACCEPTED) execute(robot, &command, from, now_us);
  }
}

static void sense(struct hero_robot *robot, uint64_t now_us) {
  struct hero_range reading;
  if (robot->hal->range_poll(robot->hal->context, &reading)) hero_detection_take(&robot->detection, reading, now_us);
}

static void set_fault(struct hero_robot *robot, uint8_t fault, bool present) {
  robot->faults = (uint8_t)(present ? robot->faults | fault : robot->faults & ~fault);
}

static void check_sensor(struct hero_robot *robot, uint64_t now_us) {
  bool alive = hero_detection_alive(&robot->detection, now_us);
  if (!alive && !(robot->faults & HERO_FAULT_SENSOR)) robot->sensor_fell_silent = true;
  set_fault(robot, HERO_FAULT_SENSOR, !alive);
}

/* A sensor that has fallen silent is given another chance; this may take some milliseconds, so the servos are released first. */
static void restart_silent_sensor(struct hero_robot *robot) {
  if (!robot->sensor_fell_silent) return;
  robot->sensor_fell_silent = false;
  robot->hal->range_restart(robot->hal->context);
}

static void check_health(struct hero_robot *robot, uint64_t now_us) {
  bool stalled = false;
  for (int side = 0; side < 2; side++) {
    uint64_t since = robot->stalled_since_us[side];
    stalled |= since != 0 && now_us - since > HERO_STALL_US;
  }
  check_sensor(robot, now_us);
  set_fault(robot, HERO_FAULT_BATTERY, !hero_battery_take(&robot->battery, robot->hal->battery_read(robot->hal->context), now_us));
  set_fault(robot, HERO_FAULT_STALL, stalled);
}

static void measure(struct hero_robot *robot, struct hero_wheels target, uint64_t now_us) {
  int32_t edges[2];
  for (int side = 0; side < 2; side++) {
    uint32_t count, edge_us;
    read_encoder(robot, side, &count, &edge_us);
    edges[side] = hero_encoder_take(&robot->encoder[side], count, edge_us, (uint32_t)now_us);
    robot->measured.rim[side] = hero_encoder_speed(&robot->encoder[side], target.rim[side], (uint32_t)now_us);
    if (edges[side] != 0) robot->stalled_since_us[side] = 0;
  }
  hero_odometry_add(&robot->odometry, edges[HERO_LEFT], edges[HERO_RIGHT]);
}

/* The wheels face opposite ways: forward is a longer pulse on the left and a shorter one on the right. */
static void drive_wheel(struct hero_robot *robot, int side, fix_t target, uint64_t now_us) {
  int32_t offset = hero_velocity_step(&robot->velocity[side], target, robot->measured.rim[side]);
  int32_t pulse = (int32_t)robot->settings.halt_us[side] + (side == HERO_LEFT ? offset : -offset);
  if (pulse < HERO_SERVO_MIN_US) pulse = HERO_SERVO_MIN_US;
  if (pulse > HERO_SERVO_MAX_US) pulse = HERO_SERVO_MAX_US;
  bool full = offset >= HERO_SERVO_SPAN_US || offset <= -HERO_SERVO_SPAN_US;
  if (!full) robot->stalled_since_us[side] = 0;
  if (full && robot->stalled_since_us[side] == 0) robot->stalled_since_us[side] = now_us;
  hero_encoder_drive(&robot->encoder[side], (offset > 0) - (offset < 0), (uint32_t)now_us);
  robot->hal->servo_write(robot->hal->context, side, (uint16_t)pulse);
}

static void coast(struct hero_robot *robot, uint64_t now_us) {
  release_servos(robot);
  for (int side = 0; side < 2; side++) hero_encoder_drive(&robot->encoder[side], 0, (uint32_t)now_us);
}

static void control(struct hero_robot *robot, uint64_t now_us) {
  bool may_move = hero_supervisor_may_move(&robot->supervisor, now_us);
  if (may_move) robot->command = hero_controller_act(&robot->supervisor.controller, robot->detection.seen);
  struct hero_wheels target = hero_wheels_from(robot->command);
  measure(robot, target, now_us);
  if (!may_move) {
    coast(robot, now_us);
    return;
  }
  for (int side = 0; side < 2; side++) drive_wheel(robot, side, target.rim[side], now_us);
}

/* Steady in RUN, slow in HOLD, fast in ESTOP, a short flash in FAULT and BOOT. */
static void show(struct hero_robot *robot, uint64_t now_us) {
  uint32_t phase = (uint32_t)(now_us >> (BLINK_SHIFT - 2));
  uint8_t state = robot->supervisor.state;
  bool on = phase % 16 == 0;
  if (state == HERO_STATE_RUN) on = true;
  if (state == HERO_STATE_HOLD) on = phase / 4 % 2 == 0;
  if (state == HERO_STATE_ESTOP) on = phase % 2 == 0;
  robot->hal->led_write(robot->hal->context, on);
}

/* Ready once every part has been heard of: the sensor has given a reading and the cell a voltage. */
static bool self_test(const struct hero_robot *robot) {
  return robot->detection.heard && robot->battery.millivolts >= HERO_BATTERY_CUTOFF_MV;
}

/* What the server should hear of without waiting for the next report. */
static bool changed(const struct hero_robot *robot, uint8_t state, struct hero_unicycle command) {
  return robot->supervisor.state != state || robot->command.v != command.v || robot->command.omega != command.omega;
}

/* A start begins a control period of its own: robots that start together keep step. */
static bool starts(const struct hero_robot *robot, uint8_t before) {
  return robot->supervisor.state == HERO_STATE_RUN && before != HERO_STATE_RUN;
}

void hero_robot_poll(struct hero_robot *robot, uint64_t now_us) {
  uint8_t state = robot->supervisor.state;
  struct hero_unicycle command = robot->command;
  listen(robot, now_us);
  sense(robot, now_us);
  bool due = now_us >= robot->control_us;
  if (due) check_health(robot, now_us);
  hero_supervisor_tick(&robot->supervisor, robot->faults, self_test(robot), now_us);
  if (due || starts(robot, state)) {
    control(robot, now_us);
    show(robot, now_us);
    restart_silent_sensor(robot);
    if (starts(robot, state)) robot->control_us = now_us;
    robot->control_us += HERO_CONTROL_PERIOD_US;
    if (robot->control_us <= now_us) robot->control_us = now_us + HERO_CONTROL_PERIOD_US; /* late: no burst to catch up */
  } else if (!hero_supervisor_may_move(&robot->supervisor, now_us)) {
    release_servos(robot);
  }
  if (now_us >= robot->status_us || changed(robot, state, command)) hero_report_status(robot, now_us);
}
