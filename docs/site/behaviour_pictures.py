"""Draw the pictures of docs/guides/behaviours.md: what the rules name, and what lies on their borders.

Run from the repository root: python -m docs.site.behaviour_pictures
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw

from swarm_envs import Trajectories, behaviours, load_world, rollouts
from swarm_envs.rendering import Renderer
from swarm_envs.worlds import WorldSpec

FOLDER = Path(__file__).parents[1] / "images"
CONTROLLERS = 1200
TILES = 6
TILE_WIDTH = 170
TRAIL = 150
"""Frames of the trails: 15 s."""
CLEAR = 0.3
"""A margin above which an example counts as clear."""


def main() -> None:
    """Draw one strip of clear examples per label and one of borderline cases per rule."""
    runs = {name: _runs(load_world(name)) for name in ("hero_plus", "unrefined")}
    seen_in = {"milling": "unrefined", "wall following": "unrefined"}
    for label in behaviours.LABELS:
        run = runs[seen_in.get(label, "hero_plus")]
        scores = behaviours.scores(behaviours.features(run))
        names = np.array(behaviours.label(run))
        best = np.max(list(scores.values()), axis=0)
        clear = np.flatnonzero((names == label) & (best < -CLEAR if label == "random" else best > CLEAR))
        _strip(run, clear[:TILES], [""] * TILES, f"{_slug(label)}.png")
        if label != "random":
            margin = np.where((names == label) | (names == "random"), np.abs(scores[label]), np.inf)
            border = np.argsort(margin, kind="stable")[:TILES]
            border = border[np.argsort(-scores[label][border])]
            _strip(run, border, [f"{scores[label][i]:+.2f} {names[i]}" for i in border], f"{_slug(label)}-borderline.png")


def _runs(world: WorldSpec) -> Trajectories:
    limits = np.array([world.limits.linear_speed, world.limits.angular_speed] * 2)
    controllers = np.random.default_rng(0).uniform(-limits, limits, size=(CONTROLLERS, 4))
    return rollouts(world, controllers, seed=0)


def _strip(run: Trajectories, worlds: np.ndarray, captions: list[str], name: str) -> None:
    renderer = Renderer(run.world, TILE_WIDTH)
    top = 14 if any(captions) else 0
    height, width = renderer.shape[0] + top, renderer.shape[1] + 4
    strip = Image.new("RGB", (width * len(worlds) - 4, height), "white")
    for column, world in enumerate(worlds):
        poses = run.poses[world]
        strip.paste(Image.fromarray(renderer(poses[-1], trail=poses[-TRAIL:])), (column * width, top))
        ImageDraw.Draw(strip).text((column * width, 0), captions[column], fill="black")
    strip.quantize(256, dither=Image.Dither.NONE).save(FOLDER / name, optimize=True)


def _slug(label: str) -> str:
    return "behaviour-" + label.replace(" ", "-")


if __name__ == "__main__":
    main()
