#include "hero_report.h"

#include "hero_config.h"

static uint8_t flags(const struct hero_robot *robot, uint64_t now_us) {
  uint8_t bits = 0;
  if (robot->detection.seen) bits |= HERO_FLAG_SEEN;
  if (robot->supervisor.lease_us > now_us) bits |= HERO_FLAG_LEASED;
  if (robot->supervisor.start_pending) bits |= HERO_FLAG_START_PENDING;
  if (hero_battery_low(&robot->battery)) bits |= HERO_FLAG_BATTERY_LOW;
  return bits;
}

static uint8_t *write_motion(const struct hero_robot *robot, uint8_t *p) {
  p = hero_write32(p, (uint32_t)robot->command.v);
  p = hero_write32(p, (uint32_t)robot->command.omega);
  p = hero_write32(p, (uint32_t)robot->odometry.x);
  p = hero_write32(p, (uint32_t)robot->odometry.y);
  p = hero_write32(p, robot->odometry.heading);
  p = hero_write32(p, (uint32_t)robot->measured.rim[HERO_LEFT]);
  return hero_write32(p, (uint32_t)robot->measured.rim[HERO_RIGHT]);
}

static uint8_t *write_status(const struct hero_robot *robot, uint8_t *p, uint64_t now_us) {
  const struct hero_supervisor *supervisor = &robot->supervisor;
  p = hero_write64(p, now_us);
  *p++ = supervisor->state;
  *p++ = supervisor->reason;
  *p++ = supervisor->faults;
  *p++ = flags(robot, now_us);
  p = hero_write32(p, robot->link.last_sequence);
  p = hero_write32(p, robot->result_sequence);
  *p++ = robot->result;
  p = hero_write16(p, robot->battery.millivolts);
  p = hero_write16(p, robot->detection.range_mm);
  p = hero_write32(p, supervisor->version);
  p = write_motion(robot, p);
  p = hero_write32(p, supervisor->lease_us > now_us ? (uint32_t)(supervisor->lease_us - now_us) : 0);
  return hero_write16(p, robot->link.refused);
}

static void send(struct hero_robot *robot, uint8_t type, const uint8_t *payload, const uint8_t *end, struct hero_peer to) {
  uint8_t frame[HERO_FRAME_MAX];
  size_t size = hero_link_report(&robot->link, type, payload, (uint16_t)(end - payload), frame, sizeof frame);
  if (size > 0) robot->hal->send(robot->hal->context, frame, size, to);
}

void hero_report_status(struct hero_robot *robot, uint64_t now_us) {
  uint8_t payload[HERO_STATUS_SIZE];
  robot->status_us = now_us + HERO_STATUS_PERIOD_US;
  if (robot->server.port == 0) return;
  send(robot, HERO_STATUS, payload, write_status(robot, payload, now_us), robot->server);
}

void hero_report_welcome(struct hero_robot *robot, uint64_t challenge, struct hero_peer to, uint64_t now_us) {
  uint8_t payload[8 + HERO_STATUS_SIZE];
  send(robot, HERO_WELCOME, payload, write_status(robot, hero_write64(payload, challenge), now_us), to);
}
