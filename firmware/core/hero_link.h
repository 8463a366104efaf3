/* From received bytes to a command that may be believed: robot, boot nonce, sequence, tag and payload checked. */
#ifndef HERO_LINK_H
#define HERO_LINK_H

#include "hero_controller.h"
#include "hero_frame.h"

struct hero_link {
  uint8_t key[HERO_KEY_SIZE];
  uint16_t robot;
  uint64_t nonce;         /* of this boot; 0 until drawn, and then nothing is accepted */
  uint32_t last_sequence; /* of the last accepted command */
  uint32_t sent_sequence; /* of the last report */
  uint16_t refused;       /* frames refused since boot, stops at 65535 */
};

struct hero_command {
  uint8_t type;
  uint32_t sequence;
  uint64_t challenge; /* HELLO */
  uint64_t time_us;   /* HEARTBEAT: until; START: at; robot time */
  uint32_t version;   /* START, CONTROLLER */
  struct hero_controller controller;
};

enum hero_verdict {
  HERO_ACCEPTED = 0,
  HERO_NOT_A_FRAME,
  HERO_OTHER_ROBOT,
  HERO_OTHER_BOOT, /* sealed for another boot of this robot */
  HERO_REPLAYED,   /* its sequence is not above the last accepted one */
  HERO_FORGED,     /* the tag is not that of this robot's key */
  HERO_MALFORMED   /* authentic, but not a command of this protocol */
};

void hero_link_start(struct hero_link *link, uint16_t robot, const uint8_t key[HERO_KEY_SIZE], uint64_t nonce);

/* Checks a datagram; fills `command` and remembers its sequence only when it is accepted. */
enum hero_verdict hero_link_open(struct hero_link *link, const uint8_t *data, size_t size, struct hero_command *command);

/* Seals a report with the next sequence; returns its size. */
size_t hero_link_report(struct hero_link *link, uint8_t type, const uint8_t *payload, uint16_t payload_size, uint8_t *out,
                        size_t room);

#endif
