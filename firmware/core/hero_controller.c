#include "hero_controller.h"

#include "hero_config.h"

bool hero_controller_in_range(const struct hero_controller *controller) {
  for (unsigned i = 0; i < 4; i++) {
    fix_t limit = i % 2 ? HERO_MAX_TURN : HERO_MAX_SPEED;
    if (fix_abs(controller->gene[i]) > limit) return false;
  }
  return true;
}

struct hero_unicycle hero_controller_act(const struct hero_controller *controller, bool detected) {
  const fix_t *pair = controller->gene + (detected ? 2 : 0);
  return (struct hero_unicycle){.v = pair[0], .omega = pair[1]};
}
