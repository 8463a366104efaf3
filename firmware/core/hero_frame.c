#include "hero_frame.h"

#include <string.h>

uint16_t hero_read16(const uint8_t *p) { return (uint16_t)(p[0] | (p[1] << 8)); }

uint32_t hero_read32(const uint8_t *p) { return hero_read16(p) | ((uint32_t)hero_read16(p + 2) << 16); }

uint64_t hero_read64(const uint8_t *p) { return hero_read32(p) | ((uint64_t)hero_read32(p + 4) << 32); }

uint8_t *hero_write16(uint8_t *p, uint16_t value) {
  p[0] = (uint8_t)value;
  p[1] = (uint8_t)(value >> 8);
  return p + 2;
}

uint8_t *hero_write32(uint8_t *p, uint32_t value) {
  return hero_write16(hero_write16(p, (uint16_t)value), (uint16_t)(value >> 16));
}

uint8_t *hero_write64(uint8_t *p, uint64_t value) {
  return hero_write32(hero_write32(p, (uint32_t)value), (uint32_t)(value >> 32));
}

bool hero_frame_parse(const uint8_t *data, size_t size, struct hero_frame *frame) {
  if (size < HERO_HEADER_SIZE + HERO_DIGEST_SIZE || size > HERO_FRAME_MAX) return false;
  if (data[0] != 'H' || data[1] != 'F' || data[2] != HERO_PROTOCOL) return false;
  frame->type = data[3];
  frame->robot = hero_read16(data + 4);
  frame->payload_size = hero_read16(data + 6);
  frame->nonce = hero_read64(data + 8);
  frame->sequence = hero_read32(data + 16);
  frame->payload = data + HERO_HEADER_SIZE;
  return frame->payload_size == size - HERO_HEADER_SIZE - HERO_DIGEST_SIZE;
}

bool hero_frame_authentic(const uint8_t key[HERO_KEY_SIZE], const uint8_t *data, size_t size) {
  uint8_t tag[HERO_DIGEST_SIZE];
  if (size < HERO_HEADER_SIZE + HERO_DIGEST_SIZE || size > HERO_FRAME_MAX) return false;
  hero_hmac(key, data, size - HERO_DIGEST_SIZE, tag);
  return hero_same_tag(tag, data + size - HERO_DIGEST_SIZE);
}

size_t hero_frame_seal(const uint8_t key[HERO_KEY_SIZE], const struct hero_frame *frame, uint8_t *out, size_t room) {
  size_t body = HERO_HEADER_SIZE + frame->payload_size;
  if (frame->payload_size > HERO_PAYLOAD_MAX || room < body + HERO_DIGEST_SIZE) return 0;
  out[0] = 'H';
  out[1] = 'F';
  out[2] = HERO_PROTOCOL;
  out[3] = frame->type;
  uint8_t *p = hero_write16(out + 4, frame->robot);
  p = hero_write16(p, frame->payload_size);
  p = hero_write64(p, frame->nonce);
  p = hero_write32(p, frame->sequence);
  if (frame->payload_size > 0) memcpy(p, frame->payload, frame->payload_size);
  hero_hmac(key, out, body, out + body);
  return body + HERO_DIGEST_SIZE;
}
