/* Battery guard: warns, and stops the robot before the cell is harmed. */
#ifndef HERO_BATTERY_H
#define HERO_BATTERY_H

#include <stdbool.h>
#include <stdint.h>

struct hero_battery {
  uint16_t millivolts;
  uint64_t above_us; /* when it was last above the cutoff */
};

void hero_battery_start(struct hero_battery *battery, uint64_t now_us);

/* Takes a measurement; false once the cell has stayed below the cutoff for longer than a servo's start can explain. */
bool hero_battery_take(struct hero_battery *battery, uint16_t millivolts, uint64_t now_us);

bool hero_battery_low(const struct hero_battery *battery); /* time to charge */

#endif
