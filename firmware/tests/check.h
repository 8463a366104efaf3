/* The smallest test harness that runs on a bare CPU: no printf, no heap. */
#ifndef HERO_CHECK_H
#define HERO_CHECK_H

#include <stdbool.h>
#include <stdint.h>

/* What each machine provides (port_*.c). */
void port_write(const char *text);

/* Counts a check and reports one that fails with its place and both numbers. */
void check_true(bool holds, const char *what, const char *file, int line);
void check_equal(long given, long expected, const char *what, const char *file, int line);
void check_near(long given, long expected, long tolerance, const char *what, const char *file, int line);

#define CHECK(condition) check_true((condition), #condition, __FILE__, __LINE__)
#define CHECK_EQUAL(given, expected) check_equal((long)(given), (long)(expected), #given, __FILE__, __LINE__)
#define CHECK_NEAR(given, expected, tolerance) \
  check_near((long)(given), (long)(expected), (long)(tolerance), #given, __FILE__, __LINE__)

/* Repeatable pseudo-random numbers (xorshift). */
uint32_t check_random(void);

/* Each file of tests has one entry. */
void test_fixed(void);
void test_sha256(void);
void test_frame(void);
void test_link(void);
void test_controller(void);
void test_encoder(void);
void test_velocity(void);
void test_odometry(void);
void test_detection(void);
void test_battery(void);
void test_supervisor(void);
void test_robot(void);

#endif
