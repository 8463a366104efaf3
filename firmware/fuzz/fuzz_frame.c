/* libFuzzer target: any bytes through the parser, the link and the supervisor of a whole robot.
 *
 * The first byte chooses what happens to the rest: 0 to 127 it goes in as it is; above, it is cut into header fields and a
 * payload and sealed with the right key, so that what lies behind the tag is reached as well. */
#include <stdlib.h>
#include <string.h>

#include "../core/hero_config.h"
#include "../hal/sim/hero_sim.h"

static const uint8_t KEY[HERO_KEY_SIZE] = "the fuzzed robot's key";

unsigned long fuzz_runs; /* frames after which the robot was in RUN: shows that the fuzzer gets that far */

/* Makes a time in the payload one that lies ahead, and the version that of the loaded controller. */
static void make_timely(const struct hero_sim *sim, uint8_t *payload, uint16_t size) {
  if (size < 8) return;
  uint32_t ahead = size == 12 ? hero_read16(payload) % 4096u : hero_read16(payload) * 8u; /* us: soon, before the next ESTOP */
  hero_write64(payload, sim->now_us + ahead);
  if (size == 12) hero_write32(payload + 8, sim->robot.supervisor.version);
}

/* Seals the input as an authentic command with mostly sensible fields. */
static void deliver_sealed(struct hero_sim *sim, const uint8_t *data, size_t size) {
  uint8_t sealed[HERO_FRAME_MAX], payload[HERO_PAYLOAD_MAX];
  struct hero_frame frame = {.type = data[0], .robot = 7, .nonce = data[0] == HERO_HELLO ? 0 : sim->robot.link.nonce};
  frame.sequence = sim->robot.link.last_sequence + (data[1] % 8u);
  frame.payload = payload;
  frame.payload_size = (uint16_t)(size - 2 > HERO_PAYLOAD_MAX ? HERO_PAYLOAD_MAX : size - 2);
  memcpy(payload, data + 2, frame.payload_size);
  if (data[1] & 8u && data[0] != HERO_CONTROLLER) make_timely(sim, payload, frame.payload_size);
  size_t sealed_size = hero_frame_seal(KEY, &frame, sealed, sizeof sealed);
  if (sealed_size > 0) hero_sim_deliver(sim, sealed, sealed_size);
}

/* What no input may ever bring about. */
static void check(const struct hero_sim *sim) {
  const struct hero_supervisor *supervisor = &sim->robot.supervisor;
  bool driven = sim->wheel[0].pulse_us != 0 || sim->wheel[1].pulse_us != 0;
  if (driven && supervisor->state != HERO_STATE_RUN) abort();
  if (supervisor->state == HERO_STATE_RUN && (supervisor->version == 0 || supervisor->lease_us == 0)) abort();
  if (supervisor->lease_us > sim->now_us + HERO_LEASE_MAX_US) abort();
  if (!hero_controller_in_range(&supervisor->controller)) abort();
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  static struct hero_sim sim;
  static unsigned frames;
  if (frames++ % 4096 == 0) {
    hero_sim_init(&sim, 7, KEY, frames);
    hero_sim_boot(&sim);
    hero_sim_run(&sim, 100000);
  }
  if (size < 3) return 0;
  if (data[0] < 128) {
    hero_sim_deliver(&sim, data + 1, size - 1);
  } else {
    deliver_sealed(&sim, data + 1, size - 1);
  }
  hero_sim_run(&sim, sim.now_us + 1000);
  check(&sim);
  fuzz_runs += sim.robot.supervisor.state == HERO_STATE_RUN;
  return 0;
}
