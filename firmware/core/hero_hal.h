/* All that the core asks of a board: ten functions. None may block, but for range_restart, which is called only while the
 * servos are released.
 *
 * Time is not among them: it is passed in with each call of the core. `context` is the board's own. */
#ifndef HERO_HAL_H
#define HERO_HAL_H

#include "hero_detection.h"
#include "hero_link.h"

struct hero_settings {
  uint16_t robot;
  uint8_t key[HERO_KEY_SIZE];
  uint16_t halt_us[2]; /* measured halt pulse of the left and right servo; 0: the robot file's */
};

struct hero_peer { /* where a datagram came from, and where reports go */
  uint32_t address;
  uint16_t port;
};

struct hero_hal {
  void *context;
  /* Robot number, key and halts from permanent memory; false when there are none. */
  bool (*load_settings)(void *context, struct hero_settings *settings);
  /* 64 bits that nobody can predict (a hardware source); 0 when it failed. */
  uint64_t (*random64)(void *context);
  /* Pulse width of a servo, us, until the next call or HERO_SERVO_REFRESH_US; 0 releases it: no pulses. */
  void (*servo_write)(void *context, int side, uint16_t pulse_us);
  /* Edges counted by the interrupt since power-on and the time of the last, low 32 bits; read together. */
  void (*encoder_read)(void *context, int side, uint32_t *count, uint32_t *edge_us);
  /* True when the sensor has a new reading, which is then filled in. */
  bool (*range_poll)(void *context, struct hero_range *reading);
  /* Powers the sensor off and on again. */
  void (*range_restart)(void *context);
  /* Voltage of the cell, mV. */
  uint16_t (*battery_read)(void *context);
  void (*led_write)(void *context, bool on);
  /* Size of a waiting datagram, copied to `data`, or 0; longer ones are cut. */
  size_t (*receive)(void *context, uint8_t *data, size_t room, struct hero_peer *from);
  /* Sends a datagram and forgets it. */
  void (*send)(void *context, const uint8_t *data, size_t size, struct hero_peer to);
};

#endif
