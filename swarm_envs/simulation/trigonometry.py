"""Sine and cosine without branches, so that the compiler can take several robots at once.

The angle's multiple of a quarter turn is taken off in two parts (Cody and Waite), the rest, at most an eighth of a turn, goes through
Taylor series that are exact to the last digit or two. A heading is as exact as its own last digit allows, however far it has turned.
"""

from __future__ import annotations

import math

from swarm_envs.compiled import compiled

QUARTERS = 2.0 / math.pi
QUARTER_HIGH = 1.5707963267341256
"""A quarter turn in rad to 33 bits, so that its multiples are exact."""
QUARTER_LOW = 6.077100506506192e-11
"""What is missing from a quarter turn."""
ROUNDER = 6755399441055744.0
"""1.5 * 2^52: adding and subtracting it rounds to the nearest whole number."""


@compiled(forceinline=True, _nrt=False)
def cos_sin(angle: float) -> tuple[float, float]:
    """Return the cosine and the sine of an angle in rad."""
    quarters = (angle * QUARTERS + ROUNDER) - ROUNDER
    x = (angle - quarters * QUARTER_HIGH) - quarters * QUARTER_LOW
    z = x * x
    s = x + x * z * (
        -1 / 6 + z * (1 / 120 + z * (-1 / 5040 + z * (1 / 362880 + z * (-1 / 39916800 + z * (1 / 6227020800 - z / 1307674368000)))))
    )
    c = 1.0 - 0.5 * z + z * z * (1 / 24 + z * (-1 / 720 + z * (1 / 40320 + z * (-1 / 3628800 + z * (1 / 479001600 - z / 87178291200)))))
    # odd quarters exchange the two; which of the four it is, without leaving floating point
    half = 0.5 * quarters
    odd = half != (half + ROUNDER) - ROUNDER
    fourth = 0.25 * quarters
    within = quarters - 4.0 * ((fourth + ROUNDER) - ROUNDER)  # -2, -1, 0, 1 or 2
    cosine, sine = (s, c) if odd else (c, s)
    return -cosine if within == 1.0 or within == 2.0 or within == -2.0 else cosine, -sine if abs(within) == 2.0 or within == -1.0 else sine


@compiled(forceinline=True, _nrt=False)
def cos_sin_small(angle: float) -> tuple[float, float]:
    """Return the cosine and the sine of an angle in rad that is most likely small, sooner than :func:`cos_sin`."""
    z = angle * angle
    if z > 0.04:
        return cos_sin(angle)
    c = 1.0 - 0.5 * z + z * z * (1 / 24 + z * (-1 / 720 + z * (1 / 40320 - z / 3628800)))
    return c, angle + angle * z * (-1 / 6 + z * (1 / 120 + z * (-1 / 5040 + z / 362880)))


@compiled(forceinline=True, _nrt=False)
def sinc(x: float) -> float:
    """Return sin(x) / x, by its series where the quotient would lose digits."""
    z = x * x
    if z < 0.0625:
        return 1.0 - z / 6.0 * (1.0 - z / 20.0 * (1.0 - z / 42.0 * (1.0 - z / 72.0 * (1.0 - z / 110.0))))
    return math.sin(x) / x
