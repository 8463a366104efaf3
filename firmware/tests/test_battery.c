#include "../core/hero_battery.h"
#include "../core/hero_config.h"
#include "check.h"

static struct hero_battery battery;

static void a_dip_is_forgiven_a_flat_cell_is_not(void) {
  uint64_t now = 0;
  hero_battery_start(&battery, now);
  CHECK(hero_battery_take(&battery, HERO_BATTERY_NOMINAL_MV, now));
  CHECK(hero_battery_take(&battery, HERO_BATTERY_CUTOFF_MV - 1, now += HERO_BATTERY_HOLD_OFF_US - 1));
  CHECK(hero_battery_take(&battery, HERO_BATTERY_CUTOFF_MV, now));
  CHECK(hero_battery_take(&battery, 0, now += HERO_BATTERY_HOLD_OFF_US - 1));
  CHECK(!hero_battery_take(&battery, 0, now + 1));
}

static void it_warns_before_it_stops(void) {
  hero_battery_start(&battery, 0);
  CHECK(hero_battery_take(&battery, HERO_BATTERY_WARNING_MV - 1, HERO_BATTERY_HOLD_OFF_US * 2));
  CHECK(hero_battery_low(&battery));
  hero_battery_take(&battery, HERO_BATTERY_WARNING_MV, 0);
  CHECK(!hero_battery_low(&battery));
}

void test_battery(void) {
  a_dip_is_forgiven_a_flat_cell_is_not();
  it_warns_before_it_stops();
}
