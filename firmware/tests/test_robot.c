/* The whole robot on a board of integers, so that it runs on every CPU. */
#include <string.h>

#include "../core/hero_config.h"
#include "../core/hero_report.h"
#include "check.h"

static const uint8_t KEY[32] = "key of the robot under test";

static struct hero_robot robot;
static struct {
  uint64_t now_us, reading_us;
  uint16_t pulse_us[2], battery_mv, distance_mm;
  uint32_t count[2], edge_us[2];
  uint32_t sequence;
  uint8_t waiting[HERO_FRAME_MAX], sent[HERO_FRAME_MAX];
  size_t waiting_size, sent_size;
  unsigned reports, restarts, rubbish;
  bool sensor_dead, wheels_held, no_random, no_settings;
} board;

static bool load_settings(void *context, struct hero_settings *settings) {
  (void)context;
  memset(settings, 0, sizeof *settings);
  settings->robot = 7;
  memcpy(settings->key, KEY, sizeof KEY);
  settings->halt_us[HERO_LEFT] = 1493; /* a pair once calibrated */
  settings->halt_us[HERO_RIGHT] = 1448;
  return !board.no_settings;
}

static uint64_t random64(void *context) {
  (void)context;
  return board.no_random ? 0 : 0x0123456789abcdefu;
}

static void servo_write(void *context, int side, uint16_t pulse_us) {
  (void)context;
  board.pulse_us[side] = pulse_us;
}

static void encoder_read(void *context, int side, uint32_t *count, uint32_t *edge_us) {
  (void)context;
  *count = board.count[side];
  *edge_us = board.edge_us[side];
}

static bool range_poll(void *context, struct hero_range *reading) {
  (void)context;
  if (board.sensor_dead || board.now_us < board.reading_us) return false;
  board.reading_us = board.now_us + HERO_TOF_PERIOD_MS * 1000u;
  *reading = (struct hero_range){board.distance_mm, board.distance_mm > 0};
  return true;
}

static void range_restart(void *context) {
  (void)context;
  CHECK(board.pulse_us[0] == 0 && board.pulse_us[1] == 0); /* it may block: never while the wheels turn */
  board.restarts++;
}

static uint16_t battery_read(void *context) {
  (void)context;
  return board.battery_mv;
}

static void led_write(void *context, bool on) {
  (void)context;
  (void)on;
}

static size_t receive(void *context, uint8_t *data, size_t room, struct hero_peer *from) {
  (void)context;
  *from = (struct hero_peer){1, 1};
  if (board.waiting_size > 0) {
    size_t size = board.waiting_size;
    memcpy(data, board.waiting, size);
    board.waiting_size = 0;
    return size;
  }
  if (board.rubbish == 0) return 0;
  board.rubbish--;
  memset(data, (int)(check_random() & 255u), room);
  return room;
}

static void send(void *context, const uint8_t *data, size_t size, struct hero_peer to) {
  (void)context;
  (void)to;
  memcpy(board.sent, data, size);
  board.sent_size = size;
  board.reports++;
}

static const struct hero_hal HAL = {NULL, load_settings, random64, servo_write, encoder_read, range_poll,
                                    range_restart, battery_read, led_write, receive, send};

static bool released(void) { return board.pulse_us[0] == 0 && board.pulse_us[1] == 0; }

/* Wheels that follow their pulse at once, an edge at a time. */
static void turn_wheels(void) {
  static uint32_t path[2];
  for (int side = 0; side < 2; side++) {
    int32_t halt = side == HERO_LEFT ? 1493 : 1448;
    int32_t offset = board.pulse_us[side] == 0 || board.wheels_held ? 0 : (int32_t)board.pulse_us[side] - halt;
    path[side] += (uint32_t)(offset < 0 ? -offset : offset) * 1689u; /* m/s per us of pulse, as parts of a tick in 1 ms */
    if (path[side] < 2586000u) continue;
    path[side] -= 2586000u;
    board.count[side]++;
    board.edge_us[side] = (uint32_t)board.now_us;
  }
}

static void pass(uint32_t ms) {
  while (ms-- > 0) {
    board.now_us += 1000;
    turn_wheels();
    hero_robot_poll(&robot, board.now_us);
  }
}

static void command(uint8_t type, const uint8_t *payload, uint16_t size) {
  struct hero_frame frame = {.type = type, .robot = 7, .nonce = robot.link.nonce, .sequence = ++board.sequence,
                             .payload = payload, .payload_size = size};
  board.waiting_size = hero_frame_seal(KEY, &frame, board.waiting, sizeof board.waiting);
  hero_robot_poll(&robot, board.now_us);
}

static void lease(uint32_t ms) {
  uint8_t until[8];
  hero_write64(until, board.now_us + ms * 1000u);
  command(HERO_HEARTBEAT, until, sizeof until);
}

static void boot(void) {
  uint32_t sequence = 0;
  memset(&board, 0, sizeof board);
  board.battery_mv = HERO_BATTERY_NOMINAL_MV;
  board.sequence = sequence;
  hero_robot_boot(&robot, &HAL, 0);
  pass(60);
}

static void load(uint32_t version, fix_t v0, fix_t w0, fix_t v1, fix_t w1) {
  uint8_t payload[20], *p = hero_write32(payload, version);
  p = hero_write32(p, (uint32_t)v0);
  p = hero_write32(p, (uint32_t)w0);
  p = hero_write32(p, (uint32_t)v1);
  hero_write32(p, (uint32_t)w1);
  command(HERO_CONTROLLER, payload, sizeof payload);
}

static void start(uint32_t version) {
  uint8_t payload[12];
  lease(500);
  hero_write32(hero_write64(payload, board.now_us + 5000), version);
  command(HERO_START, payload, sizeof payload);
  pass(6);
}

static void run(void) {
  boot();
  load(1, FIX_ONE / 20, 0, -FIX_ONE / 20, FIX_ONE);
  start(1);
  CHECK_EQUAL(robot.supervisor.state, HERO_STATE_RUN);
}

static void pass_leased(uint32_t ms) {
  for (uint32_t i = 0; i < ms; i += 100) {
    lease(500);
    pass(100);
  }
}

static void it_boots_into_hold_with_released_servos(void) {
  boot();
  CHECK_EQUAL(robot.supervisor.state, HERO_STATE_HOLD);
  CHECK(released());
  CHECK_EQUAL(board.reports, 0); /* nobody has asked */
}

static void it_drives_at_the_speed_that_its_controller_says(void) {
  run();
  pass_leased(3000);
  CHECK_NEAR(robot.measured.rim[HERO_LEFT], FIX_ONE / 20, 200);
  CHECK_NEAR(robot.measured.rim[HERO_RIGHT], FIX_ONE / 20, 200);
  CHECK(board.pulse_us[HERO_LEFT] > 1493 && board.pulse_us[HERO_RIGHT] < 1448); /* mirrored */
  CHECK_NEAR(robot.odometry.x, 3 * (1 << 24) / 20, (1 << 24) / 100);
  board.distance_mm = 300;
  pass_leased(1000);
  CHECK_EQUAL(robot.command.v, -FIX_ONE / 20);
  CHECK_EQUAL(robot.command.omega, FIX_ONE);
}

static void it_stops_when_the_lease_ends_whatever_the_radio_does(void) {
  run();
  pass_leased(1000);
  board.rubbish = 1000000; /* more than it can look at */
  pass(499);
  CHECK_EQUAL(robot.supervisor.state, HERO_STATE_RUN - (board.now_us >= robot.supervisor.lease_us));
  pass(2);
  CHECK_EQUAL(robot.supervisor.state, HERO_STATE_HOLD);
  CHECK(released());
}

static void a_stop_right_behind_another_command_is_obeyed(void) {
  run();
  pass_leased(200);
  lease(500);
  command(HERO_STOP, NULL, 0); /* at the same microsecond */
  CHECK_EQUAL(robot.supervisor.state, HERO_STATE_HOLD);
  CHECK(released());
}

static void an_estop_releases_in_the_same_call(void) {
  run();
  pass_leased(200);
  CHECK(!released());
  command(HERO_ESTOP, NULL, 0);
  CHECK(released());
  CHECK_EQUAL(robot.supervisor.state, HERO_STATE_ESTOP);
  CHECK_EQUAL(hero_read32(board.sent + HERO_HEADER_SIZE + 16), board.sequence); /* and says so at once */
  pass_leased(1000);
  CHECK_EQUAL(robot.supervisor.state, HERO_STATE_ESTOP);
}

static void a_dead_sensor_a_flat_cell_and_a_held_wheel_are_faults(void) {
  run();
  board.sensor_dead = true;
  pass_leased(500);
  CHECK_EQUAL(robot.supervisor.state, HERO_STATE_FAULT);
  CHECK_EQUAL(robot.supervisor.faults, HERO_FAULT_SENSOR);
  CHECK_EQUAL(board.restarts, 2); /* at boot, and to give it another chance */
  run();
  board.battery_mv = HERO_BATTERY_CUTOFF_MV - 100;
  pass_leased(1500);
  CHECK_EQUAL(robot.supervisor.state, HERO_STATE_RUN);
  pass_leased(1000);
  CHECK_EQUAL(robot.supervisor.faults, HERO_FAULT_BATTERY);
  CHECK(released());
  run();
  board.wheels_held = true;
  pass_leased(8000);
  CHECK_EQUAL(robot.supervisor.state, HERO_STATE_FAULT);
  CHECK(released());
}

static void without_settings_or_chance_nothing_is_taken(void) {
  boot();
  board.no_random = true;
  hero_robot_boot(&robot, &HAL, 0);
  pass(100);
  CHECK_EQUAL(robot.supervisor.state, HERO_STATE_FAULT);
  CHECK_EQUAL(robot.supervisor.faults, HERO_FAULT_SETTINGS);
  command(HERO_REARM, NULL, 0);
  CHECK_EQUAL(robot.supervisor.state, HERO_STATE_FAULT);
  board.no_random = false;
  board.no_settings = true;
  hero_robot_boot(&robot, &HAL, 0);
  pass(100);
  CHECK_EQUAL(robot.supervisor.faults, HERO_FAULT_SETTINGS);
}

static void it_reports_to_whom_it_believes(void) {
  boot();
  lease(500);
  pass(1000);
  CHECK_NEAR(board.reports, 20, 2);
  CHECK_EQUAL(board.sent_size, HERO_HEADER_SIZE + HERO_STATUS_SIZE + HERO_DIGEST_SIZE);
  CHECK(hero_frame_authentic(KEY, board.sent, board.sent_size));
  CHECK_EQUAL(board.sent[3], HERO_STATUS);
  CHECK_EQUAL(board.sent[HERO_HEADER_SIZE + 8], HERO_STATE_HOLD);
}

static void it_answers_a_hello_with_the_challenge(void) {
  uint8_t challenge[8] = {1, 2, 3, 4, 5, 6, 7, 8};
  boot();
  struct hero_frame frame = {.type = HERO_HELLO, .robot = 7, .payload = challenge, .payload_size = 8};
  board.waiting_size = hero_frame_seal(KEY, &frame, board.waiting, sizeof board.waiting);
  pass(1);
  CHECK_EQUAL(board.sent[3], HERO_WELCOME);
  CHECK(memcmp(board.sent + HERO_HEADER_SIZE, challenge, 8) == 0);
  CHECK(hero_read64(board.sent + 8) == robot.link.nonce);
  unsigned reports = board.reports;
  pass(500);
  CHECK_EQUAL(board.reports, reports); /* a hello subscribes to nothing */
}

static void a_late_loop_does_not_hurry(void) {
  run();
  pass_leased(100);
  board.now_us += 300000; /* the radio kept the CPU for 0.3 s */
  hero_robot_poll(&robot, board.now_us);
  CHECK(robot.control_us > board.now_us);
}

void test_robot(void) {
  it_boots_into_hold_with_released_servos();
  it_drives_at_the_speed_that_its_controller_says();
  it_stops_when_the_lease_ends_whatever_the_radio_does();
  a_stop_right_behind_another_command_is_obeyed();
  an_estop_releases_in_the_same_call();
  a_dead_sensor_a_flat_cell_and_a_held_wheel_are_faults();
  without_settings_or_chance_nothing_is_taken();
  it_reports_to_whom_it_believes();
  it_answers_a_hello_with_the_challenge();
  a_late_loop_does_not_hurry();
}
