"""Colours that survive colour blindness.

Robots take the eight colours of Okabe and Ito, "Color Universal Design" (2008), the black one lightened so that its heading mark shows.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

Colour = tuple[int, int, int]

ROBOTS: tuple[Colour, ...] = (
    (0, 114, 178),  # blue
    (230, 159, 0),  # orange
    (0, 158, 115),  # bluish green
    (204, 121, 167),  # reddish purple
    (86, 180, 233),  # sky blue
    (213, 94, 0),  # vermilion
    (240, 228, 66),  # yellow
    (90, 90, 90),  # black
)
FLOOR: Colour = (250, 249, 246)
WALL: Colour = (74, 80, 90)
OBSTACLE: Colour = (122, 130, 142)
OBJECT: Colour = (196, 178, 150)
INK: Colour = (34, 36, 40)
"""Edges and heading marks."""
BEAM: Colour = (120, 130, 145)
"""A sensor that sees nothing."""
FLASH: Colour = (213, 60, 0)
"""A robot that touches something."""


def robot_colours(count: int) -> npt.NDArray[np.uint8]:
    """Return one colour per robot, (count, 3) uint8; robot ``i`` always has the same, repeating after eight."""
    return np.array([ROBOTS[i % len(ROBOTS)] for i in range(count)], dtype=np.uint8).reshape(count, 3)
