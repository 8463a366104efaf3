#include "check.h"

static long checks, failures;

static void write_number(long number) {
  char text[24];
  char *p = text + sizeof text - 1;
  unsigned long rest = number < 0 ? 0ul - (unsigned long)number : (unsigned long)number;
  *p = '\0';
  do {
    *--p = (char)('0' + rest % 10);
    rest /= 10;
  } while (rest > 0);
  if (number < 0) *--p = '-';
  port_write(p);
}

static void write_place(const char *what, const char *file, int line) {
  port_write(file);
  port_write(":");
  write_number(line);
  port_write(": ");
  port_write(what);
}

void check_true(bool holds, const char *what, const char *file, int line) {
  checks++;
  if (holds) return;
  failures++;
  write_place(what, file, line);
  port_write(" does not hold\n");
}

void check_near(long given, long expected, long tolerance, const char *what, const char *file, int line) {
  checks++;
  if (given >= expected - tolerance && given <= expected + tolerance) return;
  failures++;
  write_place(what, file, line);
  port_write(" is ");
  write_number(given);
  port_write(", expected ");
  write_number(expected);
  port_write(" within ");
  write_number(tolerance);
  port_write("\n");
}

void check_equal(long given, long expected, const char *what, const char *file, int line) {
  check_near(given, expected, 0, what, file, line);
}

uint32_t check_random(void) {
  static uint32_t state = 2463534242u;
  state ^= state << 13;
  state ^= state >> 17;
  state ^= state << 5;
  return state;
}

int main(void) {
  test_fixed();
  test_sha256();
  test_frame();
  test_link();
  test_controller();
  test_encoder();
  test_velocity();
  test_odometry();
  test_detection();
  test_battery();
  test_supervisor();
  test_robot();
  write_number(checks);
  port_write(" checks, ");
  write_number(failures);
  port_write(" failures\n");
  return failures > 0;
}
