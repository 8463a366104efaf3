/* Fixed-point numbers: Q16.16 in 32 bits, and nothing wider.
 *
 * The ESP8266 has no floating-point unit and Debian's libgcc for it lacks the 64-bit multiply and divide helpers,
 * so every product here is put together from 32-bit halves. One unit in the last place is 1/65536: 15 um/s as a
 * speed, 15 urad/s as a turn rate. */
#ifndef HERO_FIXED_H
#define HERO_FIXED_H

#include <stdint.h>

typedef int32_t fix_t; /* Q16.16 */

#define FIX_ONE ((fix_t)65536)
#define FIX_MAX INT32_MAX

/* a * b, rounded to nearest, saturating at +-FIX_MAX. */
fix_t fix_mul(fix_t a, fix_t b);

/* part / whole for 0 <= part <= whole, rounded down; 1 when whole is 0. */
fix_t fix_ratio(fix_t part, fix_t whole);

/* |a|; INT32_MIN gives FIX_MAX. */
fix_t fix_abs(fix_t a);

/* a held between -limit and +limit. */
fix_t fix_clamp(fix_t a, fix_t limit);

/* Sine and cosine of a binary angle (2^32 is one turn), error below 4e-5. */
fix_t fix_sin(uint32_t turn);
fix_t fix_cos(uint32_t turn);

#endif
