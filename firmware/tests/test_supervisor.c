#include "../core/hero_config.h"
#include "../core/hero_supervisor.h"
#include "check.h"

static struct hero_supervisor supervisor;
static uint64_t now_us;

static enum hero_result send(uint8_t type, uint64_t time_us, uint32_t version) {
  struct hero_command command = {.type = type, .time_us = time_us, .version = version};
  return hero_supervisor_command(&supervisor, &command, now_us);
}

static void tick(uint64_t us) {
  now_us += us;
  hero_supervisor_tick(&supervisor, 0, true, now_us);
}

static void hold(void) {
  now_us = 1000;
  hero_supervisor_start(&supervisor);
  tick(1);
}

static enum hero_result lease(uint64_t us) { return send(HERO_HEARTBEAT, now_us + us, 0); }

static void run(void) {
  hold();
  send(HERO_CONTROLLER, 0, 1);
  lease(400000);
  send(HERO_START, now_us + 20000, 1);
  tick(20000);
  CHECK_EQUAL(supervisor.state, HERO_STATE_RUN);
}

static void it_holds_after_the_self_test_alone(void) {
  hero_supervisor_start(&supervisor);
  hero_supervisor_tick(&supervisor, 0, false, 5);
  CHECK_EQUAL(supervisor.state, HERO_STATE_BOOT);
  hero_supervisor_tick(&supervisor, 0, true, 6);
  CHECK_EQUAL(supervisor.state, HERO_STATE_HOLD);
}

static void a_start_waits_for_its_time(void) {
  hold();
  send(HERO_CONTROLLER, 0, 3);
  CHECK_EQUAL(lease(500000), HERO_DONE);
  CHECK_EQUAL(send(HERO_START, now_us + 300000, 3), HERO_DONE);
  tick(299999);
  CHECK_EQUAL(supervisor.state, HERO_STATE_HOLD);
  CHECK(!hero_supervisor_may_move(&supervisor, now_us));
  tick(1);
  CHECK_EQUAL(supervisor.state, HERO_STATE_RUN);
  CHECK(hero_supervisor_may_move(&supervisor, now_us));
}

static void a_start_is_refused_without_lease_controller_or_time(void) {
  hold();
  lease(100000);
  CHECK_EQUAL(send(HERO_START, now_us + 10, 0), HERO_WRONG_VERSION);
  CHECK_EQUAL(send(HERO_START, now_us + 10, 1), HERO_WRONG_VERSION);
  send(HERO_CONTROLLER, 0, 2);
  CHECK_EQUAL(send(HERO_START, now_us + 10, 1), HERO_WRONG_VERSION);
  CHECK_EQUAL(send(HERO_START, now_us, 2), HERO_TOO_LATE);
  CHECK_EQUAL(send(HERO_START, now_us + HERO_START_HORIZON_US + 1, 2), HERO_TOO_FAR);
  tick(100000);
  CHECK_EQUAL(send(HERO_START, now_us + 10, 2), HERO_NO_LEASE);
  CHECK_EQUAL(supervisor.state, HERO_STATE_HOLD);
}

static void a_heartbeat_grants_half_a_second_at_most(void) {
  run();
  lease(60000000);
  tick(HERO_LEASE_MAX_US - 1);
  CHECK(hero_supervisor_may_move(&supervisor, now_us));
  CHECK(!hero_supervisor_may_move(&supervisor, now_us + 1)); /* even before the next tick */
  tick(1);
  CHECK_EQUAL(supervisor.state, HERO_STATE_HOLD);
  CHECK_EQUAL(supervisor.reason, HERO_BECAUSE_LEASE);
  CHECK_EQUAL(lease(100000), HERO_DONE);
  tick(1);
  CHECK_EQUAL(supervisor.state, HERO_STATE_HOLD); /* a new lease alone starts nothing */
}

static void a_heartbeat_from_long_ago_grants_nothing(void) {
  run();
  CHECK_EQUAL(send(HERO_HEARTBEAT, now_us, 0), HERO_TOO_LATE);
  tick(380000);
  CHECK_EQUAL(supervisor.state, HERO_STATE_HOLD);
}

static void the_lease_must_last_until_the_start(void) {
  hold();
  send(HERO_CONTROLLER, 0, 1);
  lease(100000);
  CHECK_EQUAL(send(HERO_START, now_us + 200000, 1), HERO_DONE);
  tick(150000);
  CHECK(!supervisor.start_pending);
  lease(400000);
  tick(60000);
  CHECK_EQUAL(supervisor.state, HERO_STATE_HOLD);
}

static void estop_latches_until_rearmed(void) {
  run();
  CHECK_EQUAL(send(HERO_ESTOP, 0, 0), HERO_DONE);
  CHECK_EQUAL(supervisor.state, HERO_STATE_ESTOP);
  CHECK_EQUAL(lease(400000), HERO_WRONG_STATE);
  CHECK_EQUAL(send(HERO_START, now_us + 1000, 1), HERO_WRONG_STATE);
  CHECK_EQUAL(send(HERO_STOP, 0, 0), HERO_WRONG_STATE);
  CHECK_EQUAL(send(HERO_CONTROLLER, 0, 9), HERO_WRONG_STATE);
  tick(1000000);
  CHECK_EQUAL(supervisor.state, HERO_STATE_ESTOP);
  CHECK_EQUAL(send(HERO_REARM, 0, 0), HERO_DONE);
  CHECK_EQUAL(supervisor.state, HERO_STATE_HOLD);
  CHECK(!hero_supervisor_may_move(&supervisor, now_us));
}

static void controllers_come_in_order_in_range_and_in_hold(void) {
  struct hero_command command = {.type = HERO_CONTROLLER, .version = 5, .controller = {{HERO_MAX_SPEED + 1, 0, 0, 0}}};
  hold();
  CHECK_EQUAL(hero_supervisor_command(&supervisor, &command, now_us), HERO_OUT_OF_RANGE);
  CHECK_EQUAL(supervisor.version, 0);
  command.controller.gene[0] = HERO_MAX_SPEED;
  CHECK_EQUAL(hero_supervisor_command(&supervisor, &command, now_us), HERO_DONE);
  CHECK_EQUAL(hero_supervisor_command(&supervisor, &command, now_us), HERO_OLD_VERSION);
  CHECK_EQUAL(supervisor.version, 5);
  lease(300000);
  send(HERO_START, now_us + 100000, 5);
  CHECK_EQUAL(send(HERO_CONTROLLER, 0, 6), HERO_WRONG_STATE); /* not under a pending start */
  tick(100000);
  CHECK_EQUAL(send(HERO_CONTROLLER, 0, 6), HERO_WRONG_STATE); /* not while it runs */
}

static void a_fault_stops_and_stays_until_it_is_gone(void) {
  run();
  hero_supervisor_tick(&supervisor, HERO_FAULT_BATTERY, true, now_us);
  CHECK_EQUAL(supervisor.state, HERO_STATE_FAULT);
  CHECK(!hero_supervisor_may_move(&supervisor, now_us));
  CHECK_EQUAL(send(HERO_REARM, 0, 0), HERO_FAULT_STAYS);
  CHECK_EQUAL(lease(100000), HERO_WRONG_STATE);
  tick(1);
  CHECK_EQUAL(supervisor.state, HERO_STATE_FAULT);
  CHECK_EQUAL(send(HERO_REARM, 0, 0), HERO_DONE);
  CHECK_EQUAL(supervisor.state, HERO_STATE_HOLD);
}

static void stop_cancels_a_pending_start(void) {
  hold();
  send(HERO_CONTROLLER, 0, 1);
  lease(400000);
  send(HERO_START, now_us + 1000, 1);
  CHECK_EQUAL(send(HERO_STOP, 0, 0), HERO_DONE);
  tick(2000);
  CHECK_EQUAL(supervisor.state, HERO_STATE_HOLD);
}

static void what_is_unknown_stops(void) {
  run();
  send(0x7f, 0, 0);
  CHECK_EQUAL(supervisor.state, HERO_STATE_ESTOP);
}

void test_supervisor(void) {
  it_holds_after_the_self_test_alone();
  a_start_waits_for_its_time();
  a_start_is_refused_without_lease_controller_or_time();
  a_heartbeat_grants_half_a_second_at_most();
  a_heartbeat_from_long_ago_grants_nothing();
  the_lease_must_last_until_the_start();
  estop_latches_until_rearmed();
  controllers_come_in_order_in_range_and_in_hold();
  a_fault_stops_and_stays_until_it_is_gone();
  stop_cancels_a_pending_start();
  what_is_unknown_stops();
}
