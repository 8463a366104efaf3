#include "hero_battery.h"

#include "hero_config.h"

void hero_battery_start(struct hero_battery *battery, uint64_t now_us) { *battery = (struct hero_battery){.above_us = now_us}; }

bool hero_battery_take(struct hero_battery *battery, uint16_t millivolts, uint64_t now_us) {
  battery->millivolts = millivolts;
  if (millivolts >= HERO_BATTERY_CUTOFF_MV) battery->above_us = now_us;
  return now_us - battery->above_us < HERO_BATTERY_HOLD_OFF_US;
}

bool hero_battery_low(const struct hero_battery *battery) { return battery->millivolts < HERO_BATTERY_WARNING_MV; }
