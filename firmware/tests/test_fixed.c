#include "../core/hero_fixed.h"
#include "check.h"

static void products_round_to_nearest_and_saturate(void) {
  CHECK_EQUAL(fix_mul(FIX_ONE, FIX_ONE), FIX_ONE);
  CHECK_EQUAL(fix_mul(FIX_ONE / 2, -FIX_ONE / 2), -FIX_ONE / 4);
  CHECK_EQUAL(fix_mul(3, FIX_ONE / 2), 2); /* 1.5 to the nearest, away from zero */
  CHECK_EQUAL(fix_mul(-3, FIX_ONE / 2), -2);
  CHECK_EQUAL(fix_mul(FIX_MAX, FIX_MAX), FIX_MAX);
  CHECK_EQUAL(fix_mul(FIX_MAX, -FIX_MAX), -FIX_MAX);
  CHECK_EQUAL(fix_mul(INT32_MIN, FIX_ONE), -FIX_MAX);
  CHECK_EQUAL(fix_mul(FIX_MAX, FIX_ONE), FIX_MAX);
  CHECK_EQUAL(fix_mul(-1234567, FIX_ONE), -1234567);
}

#ifdef HERO_WIDE /* a machine with 64-bit products: the independent answer */
static void products_equal_the_wide_ones(void) {
  for (int i = 0; i < 200000; i++) {
    fix_t a = (fix_t)check_random() >> (check_random() % 31), b = (fix_t)check_random() >> (check_random() % 31);
    int64_t exact = (int64_t)a * b, size = exact < 0 ? -exact : exact, rounded = (size + 32768) / 65536;
    if (rounded > FIX_MAX) rounded = FIX_MAX;
    CHECK_EQUAL(fix_mul(a, b), exact < 0 ? -rounded : rounded);
  }
}
#endif

static void ratios_are_exact_to_the_last_place(void) {
  CHECK_EQUAL(fix_ratio(1, 2), FIX_ONE / 2);
  CHECK_EQUAL(fix_ratio(2, 3), 43690);
  CHECK_EQUAL(fix_ratio(5, 5), FIX_ONE);
  CHECK_EQUAL(fix_ratio(7, 0), FIX_ONE);
  CHECK_EQUAL(fix_ratio(FIX_MAX - 1, FIX_MAX), FIX_ONE - 1);
}

static void sines_lie_on_the_circle(void) {
  CHECK_EQUAL(fix_sin(0), 0);
  CHECK_NEAR(fix_sin(0x40000000u), FIX_ONE, 1);
  CHECK_NEAR(fix_sin(0xc0000000u), -FIX_ONE, 1);
  CHECK_NEAR(fix_sin(0x15555555u), FIX_ONE / 2, 3); /* 30 degrees */
  CHECK_NEAR(fix_cos(0x20000000u), 46341, 3);       /* 45 degrees */
  for (uint32_t turn = 0; turn < 0xff000000u; turn += 0x00812345u) {
    fix_t sine = fix_sin(turn), cosine = fix_cos(turn);
    CHECK_NEAR(fix_mul(sine, sine) + fix_mul(cosine, cosine), FIX_ONE, 6);
    CHECK_NEAR(fix_sin(0u - turn), -sine, 2);
  }
}

static void clamps_hold(void) {
  CHECK_EQUAL(fix_clamp(12, 10), 10);
  CHECK_EQUAL(fix_clamp(-12, 10), -10);
  CHECK_EQUAL(fix_clamp(-3, 10), -3);
  CHECK_EQUAL(fix_abs(INT32_MIN), FIX_MAX);
}

void test_fixed(void) {
  products_round_to_nearest_and_saturate();
#ifdef HERO_WIDE
  products_equal_the_wide_ones();
#endif
  ratios_are_exact_to_the_last_place();
  sines_lie_on_the_circle();
  clamps_hold();
}
