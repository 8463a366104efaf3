/* From time-of-flight readings to the one bit that the controller sees: range, threshold, debounce, time-out. */
#ifndef HERO_DETECTION_H
#define HERO_DETECTION_H

#include <stdbool.h>
#include <stdint.h>

struct hero_range {
  uint16_t distance_mm;
  bool valid; /* the part's own verdict: a target, and a signal good enough */
};

struct hero_detection {
  bool seen;          /* what the controller sees */
  bool heard;         /* a reading has come since boot */
  uint8_t opposite_count; /* readings in a row that say the opposite */
  uint16_t range_mm;  /* last valid distance; 0 when the last reading had no target */
  uint64_t reading_us; /* when the last reading came */
};

void hero_detection_start(struct hero_detection *detection, uint64_t now_us);

/* Takes a new reading. */
void hero_detection_take(struct hero_detection *detection, struct hero_range reading, uint64_t now_us);

/* Whether readings still come; when not, nothing is seen any longer. */
bool hero_detection_alive(struct hero_detection *detection, uint64_t now_us);

#endif
