#include "../core/hero_link.h"

#include <string.h>

#include "check.h"

static const uint8_t KEY[32] = "a key", OTHER[32] = "another key";
static uint8_t data[HERO_FRAME_MAX];
static struct hero_link robot;
static struct hero_command command;

#define NONCE 0xfeedfacecafebeefu

static enum hero_verdict open_frame(const uint8_t *key, uint16_t number, uint64_t nonce, uint32_t sequence, uint8_t type,
                                    uint16_t payload_size) {
  static const uint8_t zeros[HERO_PAYLOAD_MAX];
  struct hero_frame frame = {.type = type, .robot = number, .nonce = nonce, .sequence = sequence, .payload = zeros,
                             .payload_size = payload_size};
  size_t size = hero_frame_seal(key, &frame, data, sizeof data);
  return hero_link_open(&robot, data, size, &command);
}

static void begin(void) { hero_link_start(&robot, 7, KEY, NONCE); }

static void an_authentic_command_is_taken_once(void) {
  begin();
  CHECK_EQUAL(open_frame(KEY, 7, NONCE, 1, HERO_ESTOP, 0), HERO_ACCEPTED);
  CHECK_EQUAL(command.type, HERO_ESTOP);
  CHECK_EQUAL(open_frame(KEY, 7, NONCE, 1, HERO_ESTOP, 0), HERO_REPLAYED);
  CHECK_EQUAL(open_frame(KEY, 7, NONCE, 5, HERO_REARM, 0), HERO_ACCEPTED);
  CHECK_EQUAL(open_frame(KEY, 7, NONCE, 4, HERO_ESTOP, 0), HERO_REPLAYED); /* overtaken on the way */
  CHECK_EQUAL(robot.refused, 2);
}

static void others_are_refused_and_leave_no_trace(void) {
  begin();
  CHECK_EQUAL(open_frame(KEY, 8, NONCE, 9, HERO_ESTOP, 0), HERO_OTHER_ROBOT);
  CHECK_EQUAL(open_frame(KEY, 7, NONCE + 1, 9, HERO_ESTOP, 0), HERO_OTHER_BOOT);
  CHECK_EQUAL(open_frame(KEY, 7, 0, 9, HERO_ESTOP, 0), HERO_OTHER_BOOT);
  CHECK_EQUAL(open_frame(OTHER, 7, NONCE, 9, HERO_ESTOP, 0), HERO_FORGED);
  CHECK_EQUAL(open_frame(KEY, 7, NONCE, 9, HERO_ESTOP, 1), HERO_MALFORMED);
  CHECK_EQUAL(open_frame(KEY, 7, NONCE, 9, HERO_STATUS, 0), HERO_MALFORMED); /* a report sent back */
  CHECK_EQUAL(open_frame(KEY, 7, NONCE, 9, 0x55, 0), HERO_MALFORMED);
  CHECK_EQUAL(robot.last_sequence, 0);
}

static void a_hello_needs_no_session_and_gives_none(void) {
  begin();
  CHECK_EQUAL(open_frame(KEY, 7, 0, 0, HERO_HELLO, 8), HERO_ACCEPTED);
  CHECK_EQUAL(open_frame(OTHER, 7, 0, 0, HERO_HELLO, 8), HERO_FORGED);
  CHECK_EQUAL(robot.last_sequence, 0);
}

static void nothing_is_taken_before_the_nonce_is_drawn(void) {
  hero_link_start(&robot, 7, KEY, 0);
  CHECK_EQUAL(open_frame(KEY, 7, 0, 1, HERO_HEARTBEAT, 8), HERO_OTHER_BOOT);
  CHECK_EQUAL(open_frame(KEY, 7, 0, 0, HERO_HELLO, 8), HERO_OTHER_BOOT);
}

static void reports_count_up(void) {
  struct hero_frame frame;
  begin();
  for (uint32_t i = 1; i < 4; i++) {
    size_t size = hero_link_report(&robot, HERO_STATUS, (const uint8_t *)"xyz", 3, data, sizeof data);
    CHECK(hero_frame_parse(data, size, &frame) && hero_frame_authentic(KEY, data, size));
    CHECK_EQUAL(frame.sequence, i);
    CHECK_EQUAL(hero_link_open(&robot, data, size, &command), HERO_MALFORMED);
  }
}

void test_link(void) {
  an_authentic_command_is_taken_once();
  others_are_refused_and_leave_no_trace();
  a_hello_needs_no_session_and_gives_none();
  nothing_is_taken_before_the_nonce_is_drawn();
  reports_count_up();
}
