/* 32-bit division for the ESP8266's CPU, which has none: Debian's libgcc for it leaves these helpers out; a board's has them. */
#include <stdint.h>

uint32_t __udivsi3(uint32_t dividend, uint32_t divisor);
uint32_t __umodsi3(uint32_t dividend, uint32_t divisor);
int32_t __divsi3(int32_t dividend, int32_t divisor);

/* Long division, a bit at a time. */
static uint32_t divide(uint32_t dividend, uint32_t divisor, uint32_t *rest) {
  uint32_t quotient = 0, remainder = 0;
  for (int bit = 31; bit >= 0; bit--) {
    uint32_t carry = remainder >> 31;
    remainder = remainder << 1 | (dividend >> bit & 1u);
    if (carry || remainder >= divisor) {
      remainder -= divisor;
      quotient |= 1u << bit;
    }
  }
  *rest = remainder;
  return quotient;
}

uint32_t __udivsi3(uint32_t dividend, uint32_t divisor) {
  uint32_t rest;
  return divide(dividend, divisor, &rest);
}

uint32_t __umodsi3(uint32_t dividend, uint32_t divisor) {
  uint32_t rest;
  divide(dividend, divisor, &rest);
  return rest;
}

int32_t __divsi3(int32_t dividend, int32_t divisor) {
  uint32_t a = dividend < 0 ? 0u - (uint32_t)dividend : (uint32_t)dividend;
  uint32_t b = divisor < 0 ? 0u - (uint32_t)divisor : (uint32_t)divisor;
  uint32_t quotient = __udivsi3(a, b);
  return (int32_t)((dividend < 0) != (divisor < 0) ? 0u - quotient : quotient);
}
