#include "hero_link.h"

#include <string.h>

void hero_link_start(struct hero_link *link, uint16_t robot, const uint8_t key[HERO_KEY_SIZE], uint64_t nonce) {
  memset(link, 0, sizeof *link);
  memcpy(link->key, key, HERO_KEY_SIZE);
  link->robot = robot;
  link->nonce = nonce;
}

/* Payload size that a command must have, or -1 when there is no such command. */
static int expected_size(uint8_t type) {
  switch (type) {
    case HERO_HELLO:
    case HERO_HEARTBEAT: return 8;
    case HERO_START: return 12;
    case HERO_STOP:
    case HERO_ESTOP:
    case HERO_REARM: return 0;
    case HERO_CONTROLLER: return 20;
    default: return -1;
  }
}

static void decode(const struct hero_frame *frame, struct hero_command *command) {
  const uint8_t *p = frame->payload;
  memset(command, 0, sizeof *command);
  command->type = frame->type;
  command->sequence = frame->sequence;
  if (frame->type == HERO_HELLO) command->challenge = hero_read64(p);
  if (frame->type == HERO_HEARTBEAT || frame->type == HERO_START) command->time_us = hero_read64(p);
  if (frame->type == HERO_START) command->version = hero_read32(p + 8);
  if (frame->type == HERO_CONTROLLER) {
    command->version = hero_read32(p);
    for (unsigned i = 0; i < 4; i++) command->controller.gene[i] = (fix_t)hero_read32(p + 4 + 4 * i);
  }
}

/* Cheap checks come first, so that a flood of rubbish costs no hashing; nothing is believed before the tag. */
static enum hero_verdict check(const struct hero_link *link, const struct hero_frame *frame, const uint8_t *data, size_t size) {
  bool session = frame->type != HERO_HELLO; /* a HELLO comes before the server knows nonce and sequence */
  if (frame->robot != link->robot) return HERO_OTHER_ROBOT;
  if (link->nonce == 0 || frame->nonce != (session ? link->nonce : 0)) return HERO_OTHER_BOOT;
  if (session && frame->sequence <= link->last_sequence) return HERO_REPLAYED;
  if (!hero_frame_authentic(link->key, data, size)) return HERO_FORGED;
  return expected_size(frame->type) == frame->payload_size ? HERO_ACCEPTED : HERO_MALFORMED;
}

enum hero_verdict hero_link_open(struct hero_link *link, const uint8_t *data, size_t size, struct hero_command *command) {
  struct hero_frame frame;
  enum hero_verdict verdict = HERO_NOT_A_FRAME;
  if (hero_frame_parse(data, size, &frame)) verdict = check(link, &frame, data, size);
  if (verdict != HERO_ACCEPTED) {
    if (link->refused < UINT16_MAX) link->refused++;
    return verdict;
  }
  decode(&frame, command);
  if (frame.type != HERO_HELLO) link->last_sequence = frame.sequence;
  return HERO_ACCEPTED;
}

size_t hero_link_report(struct hero_link *link, uint8_t type, const uint8_t *payload, uint16_t payload_size, uint8_t *out,
                        size_t room) {
  struct hero_frame frame = {.type = type, .robot = link->robot, .nonce = link->nonce, .payload = payload,
                             .payload_size = payload_size};
  frame.sequence = ++link->sent_sequence;
  return hero_frame_seal(link->key, &frame, out, room);
}
