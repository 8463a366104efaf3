"""Films the named behaviours for cards and pages, as looping WebP pictures."""

from __future__ import annotations

from pathlib import Path

from PIL import Image

import swarm_envs
from docs.site.generate import PRESETS, clip_name
from swarm_envs import behaviours, rendering

LARGEST = 100_000
"""Bytes that a clip may have."""


def film(folder: Path) -> None:
    """Write the clip and the still of every preset into ``folder``; what is there already stays.

    Raises:
        RuntimeError: When a run no longer shows the behaviour that it is named after, or a clip is too large.
    """
    folder.mkdir(parents=True, exist_ok=True)
    for preset in PRESETS:
        path = folder / f"{clip_name(preset)}.webp"
        if path.exists():
            continue
        runs = swarm_envs.rollouts(preset["world"], [preset["controller"]], seed=preset["seed"], threads=1)
        (label,) = behaviours.label(runs)
        if label != preset["behaviour"]:
            raise RuntimeError(f"presets.json: {preset} shows {label!r}; choose another seed or controller")
        images = [Image.fromarray(picture) for picture in rendering.pictures(runs, fps=10, speed=10, width=240)]
        images[-1].save(path.with_name(f"{path.stem}-still.webp"), quality=70)
        for quality in (70, 50, 30, 15):
            images[0].save(path, save_all=True, append_images=images[1:], duration=100, loop=0, quality=quality, method=4)
            if path.stat().st_size < LARGEST:
                break
        else:
            size = path.stat().st_size
            path.unlink()
            raise RuntimeError(f"{path.name}: {size} bytes, expected less than {LARGEST}; film fewer pictures")
