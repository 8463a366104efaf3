/* Frames of the link: layout, seal and check.
 *
 *   offset  size  field (little-endian)
 *        0     2  magic "HF"
 *        2     1  protocol version
 *        3     1  type; from 0x80 on it is a report of the robot, so a report sent back is no command
 *        4     2  robot
 *        6     2  payload size n
 *        8     8  boot nonce of the robot: drawn afresh at each boot
 *       16     4  sequence: strictly increasing within a boot, one count for each direction
 *       20     n  payload
 *     20+n    32  HMAC-SHA256 of all before it under the robot's own key */
#ifndef HERO_FRAME_H
#define HERO_FRAME_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "hero_sha256.h"

#define HERO_PROTOCOL 1u
#define HERO_HEADER_SIZE 20u
#define HERO_PAYLOAD_MAX 96u
#define HERO_FRAME_MAX (HERO_HEADER_SIZE + HERO_PAYLOAD_MAX + HERO_DIGEST_SIZE)

enum hero_type {
  HERO_HELLO = 0x01,      /* challenge u64: who is there? Answered, and without any other effect */
  HERO_HEARTBEAT = 0x02,  /* until u64: motion is granted until this robot time, us */
  HERO_START = 0x03,      /* at u64: robot time of the start, us; version u32: of the controller that must be loaded */
  HERO_STOP = 0x04,       /* to HOLD */
  HERO_ESTOP = 0x05,      /* to ESTOP, latched */
  HERO_REARM = 0x06,      /* from ESTOP or FAULT to HOLD */
  HERO_CONTROLLER = 0x07, /* version u32, v0, w0, v1, w1 as Q16.16 */
  HERO_WELCOME = 0x81,    /* challenge u64, status */
  HERO_STATUS = 0x82      /* status */
};

struct hero_frame {
  uint8_t type;
  uint16_t robot;
  uint64_t nonce;
  uint32_t sequence;
  const uint8_t *payload; /* points into the buffer that was parsed */
  uint16_t payload_size;
};

/* Reads a frame's fields without believing them; false when it is not a whole frame of this protocol. */
bool hero_frame_parse(const uint8_t *data, size_t size, struct hero_frame *frame);

/* Whether a parsed frame's tag is that of the key. */
bool hero_frame_authentic(const uint8_t key[HERO_KEY_SIZE], const uint8_t *data, size_t size);

/* Writes header, payload and tag; returns the size, or 0 when the payload or the buffer does not fit. */
size_t hero_frame_seal(const uint8_t key[HERO_KEY_SIZE], const struct hero_frame *frame, uint8_t *out, size_t room);

uint16_t hero_read16(const uint8_t *p);
uint32_t hero_read32(const uint8_t *p);
uint64_t hero_read64(const uint8_t *p);
uint8_t *hero_write16(uint8_t *p, uint16_t value); /* each returns the place behind what it wrote */
uint8_t *hero_write32(uint8_t *p, uint32_t value);
uint8_t *hero_write64(uint8_t *p, uint64_t value);

#endif
