"""A window that shows pictures as they come: ``render_mode="human"``."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt


class Window:
    """Shows pictures in a window, at most so many per second. Opens with the first picture.

    Args:
        title: What the window's frame says.
        rate: Pictures per second.

    Raises:
        ImportError: Without pygame; one line that says how to install it.
    """

    def __init__(self, title: str, rate: float) -> None:
        try:
            import pygame  # a window is all that needs it
        except ImportError:
            raise ImportError("render_mode is 'human', which needs pygame; pip install \"swarm-envs[window]\", or rgb_array") from None
        self._pygame, self._title, self._rate = pygame, title, rate
        self._screen: Any = None
        self._clock: Any = None

    def show(self, picture: npt.NDArray[np.uint8]) -> None:
        """Show a picture (H, W, 3), and wait until its time is over."""
        if self._screen is None:
            self._pygame.display.init()
            self._pygame.display.set_caption(self._title)
            self._screen = self._pygame.display.set_mode((picture.shape[1], picture.shape[0]))
            self._clock = self._pygame.time.Clock()
        self._screen.blit(self._pygame.surfarray.make_surface(np.ascontiguousarray(picture.transpose(1, 0, 2))), (0, 0))
        self._pygame.event.pump()
        self._clock.tick(self._rate)
        self._pygame.display.flip()

    def close(self) -> None:
        """Close the window; the next picture opens it again."""
        if self._screen is not None:
            self._pygame.display.quit()
            self._screen = None
