/* What a simulated board offers to its callers, in C and, read as it stands, in Python: no macros below the includes. */
#ifndef HERO_SIM_API_H
#define HERO_SIM_API_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct hero_sim;

/* The inside of a board, for tests and displays. */
struct hero_sim_view {
  uint64_t now_us, nonce;
  uint64_t lease_us;        /* robot time at which the lease ends; 0: none */
  uint32_t last_sequence;   /* of the last accepted command */
  uint32_t version;         /* of the controller */
  uint32_t result_sequence; /* of the last command that was no heartbeat */
  uint32_t edges[2];        /* encoder edges, left and right */
  int32_t command[2];       /* v, omega asked for by the controller, Q16.16 */
  int32_t x, y;             /* odometry, Q8.24 m */
  uint32_t heading;         /* odometry, binary angle */
  int32_t measured[2];      /* rim speeds that the firmware believes in, Q16.16 m/s */
  double rim_speed[2];      /* rim speeds of the simulated servos, m/s */
  double path[2];           /* rim paths, m */
  uint16_t pulse_us[2];     /* 0: released */
  uint16_t range_mm, refused;
  uint8_t state, reason, faults, result;
  bool seen, start_pending, may_move, led;
};

size_t hero_sim_size(void); /* bytes of a struct hero_sim, for callers that only keep a pointer */

/* A board with this number, key and nonce seed, switched off. */
void hero_sim_init(struct hero_sim *sim, uint16_t robot, const uint8_t key[32], uint64_t seed);

/* Switches it on (again): the firmware boots, the wheels and the mailboxes are at rest. */
void hero_sim_boot(struct hero_sim *sim);

/* Lets time pass up to `until_us`, the firmware polled each millisecond. */
void hero_sim_run(struct hero_sim *sim, uint64_t until_us);

/* Lets the same time pass on `robots` boards: `most_us`, or less, up to the millisecond in which one of them has sent
 * something, changed its state or begun or ceased to drive its servos; the time that passed, us. */
uint32_t hero_sim_run_together(struct hero_sim *const *sims, size_t robots, uint32_t most_us);

/* Puts a datagram into the robot's inbox; false when it is full. */
bool hero_sim_deliver(struct hero_sim *sim, const uint8_t *data, size_t size);

/* Takes the oldest datagram that the robot sent; its size, or 0. */
size_t hero_sim_collect(struct hero_sim *sim, uint8_t *data, size_t room);

/* Seals an authentic command for this robot, as its server would, and delivers it. */
bool hero_sim_command(struct hero_sim *sim, uint8_t type, const uint8_t *payload, uint16_t payload_size);

/* Boots, loads a controller, starts and returns as the robot enters RUN with its wheels at rest; false when it refused. */
bool hero_sim_start(struct hero_sim *sim, const int32_t gene[4]);

/* `robots` boards for dt_us: what each range sensor has before it (m, 0: nothing) and the grip of the wheels on the way in
 * (robots x 2, left and right; NULL: full), the mean rim speeds that free wheels would have had on the way out (robots x 2,
 * m/s). Leases are renewed. */
void hero_sim_step(struct hero_sim *const *sims, size_t robots, const double *distance_m, const double *grip, uint32_t dt_us,
                   double *rim_speed);

void hero_sim_look(const struct hero_sim *sim, struct hero_sim_view *view);

/* What stands before the sensor (m, 0: nothing), the cell's voltage, and whether the sensor answers. */
void hero_sim_set(struct hero_sim *sim, double distance_m, uint16_t battery_mv, bool sensor_dead);

/* Halt pulses of the servos, us, as the board has them and as its settings say. */
void hero_sim_set_halts(struct hero_sim *sim, uint16_t left_us, uint16_t right_us);

/* The core's own, for comparison with other implementations. */
void hero_hmac(const uint8_t key[32], const uint8_t *data, size_t size, uint8_t tag[32]);

#endif
