/* The robot's account of itself, as sent to the server.
 *
 *   offset size field                          offset size field
 *        0    8 robot time, us                     25    4 controller version
 *        8    1 state                              29    8 command v, omega, Q16.16
 *        9    1 reason of the last change          37    8 odometry x, y, Q8.24 m
 *       10    1 faults                             45    4 odometry heading, binary angle
 *       11    1 flags: see hero_flag               49    8 rim speed left, right, Q16.16
 *       12    4 last accepted sequence             57    4 time until the lease ends, us
 *       16    4 sequence of the last command       61    2 frames refused since boot
 *       20    1 result of that command
 *       21    2 battery, mV
 *       23    2 range, mm */
#ifndef HERO_REPORT_H
#define HERO_REPORT_H

#include "hero_robot.h"

#define HERO_STATUS_SIZE 63u

enum hero_flag { HERO_FLAG_SEEN = 1, HERO_FLAG_LEASED = 2, HERO_FLAG_START_PENDING = 4, HERO_FLAG_BATTERY_LOW = 8 };

/* Sends a status to the server, if there is one. */
void hero_report_status(struct hero_robot *robot, uint64_t now_us);

/* Answers a HELLO: challenge and status, to whoever asked. */
void hero_report_welcome(struct hero_robot *robot, uint64_t challenge, struct hero_peer to, uint64_t now_us);

#endif
