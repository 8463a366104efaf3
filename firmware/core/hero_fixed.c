#include "hero_fixed.h"

static uint32_t magnitude(fix_t a) { return a < 0 ? 0u - (uint32_t)a : (uint32_t)a; }

/* |a| * |b| / 65536 rounded to nearest, saturated to FIX_MAX, from four 16-bit products. */
static uint32_t multiply(uint32_t a, uint32_t b) {
  uint32_t high = (a >> 16) * (b >> 16);
  uint32_t middle = (a >> 16) * (b & 0xffffu) + (a & 0xffffu) * (b >> 16);
  uint32_t low = ((a & 0xffffu) * (b & 0xffffu) + 0x8000u) >> 16;
  if (high > 0x7fffu || middle > (uint32_t)FIX_MAX) return (uint32_t)FIX_MAX;
  uint32_t sum = middle + low; /* below 2^31 + 2^16 */
  if (sum > (uint32_t)FIX_MAX - (high << 16)) return (uint32_t)FIX_MAX;
  return (high << 16) + sum;
}

fix_t fix_mul(fix_t a, fix_t b) {
  uint32_t product = multiply(magnitude(a), magnitude(b));
  return (a < 0) != (b < 0) ? -(fix_t)product : (fix_t)product;
}

fix_t fix_ratio(fix_t part, fix_t whole) {
  if (part >= whole) return FIX_ONE;
  if (part <= 0) return 0;
  uint32_t rest = (uint32_t)part, quotient = 0;
  for (int bit = 0; bit < 16; bit++) { /* one binary digit of the quotient at a time */
    rest <<= 1;
    quotient <<= 1;
    if (rest >= (uint32_t)whole) {
      rest -= (uint32_t)whole;
      quotient |= 1u;
    }
  }
  return (fix_t)quotient;
}

fix_t fix_abs(fix_t a) { return a == INT32_MIN ? FIX_MAX : (a < 0 ? -a : a); }

fix_t fix_clamp(fix_t a, fix_t limit) { return a > limit ? limit : (a < -limit ? -limit : a); }

/* sin(pi/2 x) for x in [0, 1]: odd polynomial, least squares on Chebyshev nodes, error 1e-6 before rounding. */
static fix_t quarter_sine(fix_t x) {
  fix_t square = fix_mul(x, x);
  fix_t sum = -284;
  sum = 5207 + fix_mul(sum, square);
  sum = fix_mul(sum, square) - 42330;
  sum = 102943 + fix_mul(sum, square);
  fix_t sine = fix_mul(sum, x);
  return sine > FIX_ONE ? FIX_ONE : sine;
}

fix_t fix_sin(uint32_t turn) {
  uint32_t quarter = turn >> 30;
  fix_t x = (fix_t)(((turn & 0x3fffffffu) + 0x2000u) >> 14); /* place within the quarter, Q16.16 */
  if (quarter & 1u) x = FIX_ONE - x;
  fix_t sine = quarter_sine(x);
  return quarter & 2u ? -sine : sine;
}

fix_t fix_cos(uint32_t turn) { return fix_sin(turn + 0x40000000u); }
