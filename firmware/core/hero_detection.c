#include "hero_detection.h"

#include "hero_config.h"

void hero_detection_start(struct hero_detection *detection, uint64_t now_us) {
  *detection = (struct hero_detection){.reading_us = now_us};
}

void hero_detection_take(struct hero_detection *detection, struct hero_range reading, uint64_t now_us) {
  bool usable = reading.valid && reading.distance_mm >= HERO_TOF_MIN_MM;
  bool near = usable && reading.distance_mm <= HERO_TOF_THRESHOLD_MM;
  detection->heard = true;
  detection->reading_us = now_us;
  detection->range_mm = usable ? reading.distance_mm : 0;
  detection->opposite_count = near == detection->seen ? 0 : (uint8_t)(detection->opposite_count + 1);
  if (detection->opposite_count >= HERO_TOF_DEBOUNCE) {
    detection->seen = near;
    detection->opposite_count = 0;
  }
}

bool hero_detection_alive(struct hero_detection *detection, uint64_t now_us) {
  if (now_us - detection->reading_us <= HERO_TOF_TIMEOUT_US) return true;
  detection->seen = false;
  detection->opposite_count = 0;
  detection->range_mm = 0;
  return false;
}
