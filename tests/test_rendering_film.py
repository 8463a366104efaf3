"""GIF and MP4 of a run."""

from __future__ import annotations

import importlib.util
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest
from PIL import Image

from swarm_envs import Trajectories, rollouts
from swarm_envs.rendering import pictures, save_video
from swarm_envs.rendering.palette import robot_colours


@pytest.fixture(scope="module")
def runs() -> Trajectories:
    return rollouts("hero_plus", [[0.07, -1.3, 0.06, 1.1]] * 2, seed=0, steps=160)


def frames_of(path: Path) -> list[npt.NDArray[np.uint8]]:
    with Image.open(path) as image:
        found = []
        for index in range(getattr(image, "n_frames", 1)):
            image.seek(index)
            found.append(np.array(image.convert("RGB")))
        return found


def test_one_line_saves_a_looping_gif_of_the_run(runs: Trajectories, tmp_path: Path) -> None:
    path = save_video(runs, tmp_path / "circle.gif")
    with Image.open(path) as image:
        assert image.info["loop"] == 0
        assert image.info["duration"] == 80
        assert image.size[0] == 320
    assert len(frames_of(path)) == 26  # 16 s at 8 times the speed and 12.5 pictures per second, and the start
    assert path.stat().st_size < 500_000


def test_a_gif_shows_what_the_renderer_draws_with_the_robots_own_colours(runs: Trajectories, tmp_path: Path) -> None:
    drawn = list(pictures(runs, 1, beams=False))
    saved = frames_of(save_video(runs, tmp_path / "run.gif", world=1, beams=False))
    assert len(drawn) == len(saved)
    for a, b in zip(drawn, saved, strict=True):
        assert np.abs(a.astype(int) - b).mean() < 3
    for colour in robot_colours(8):
        assert np.abs(saved[-1].astype(int) - colour).max(axis=-1).min() < 12


def test_a_still_picture_does_not_shimmer(runs: Trajectories, tmp_path: Path) -> None:
    still = np.repeat(next(iter(pictures(runs)))[None], 5, axis=0)
    frames = frames_of(save_video(still, tmp_path / "still.gif"))
    assert all(np.array_equal(frame, frames[0]) for frame in frames)


def test_speed_and_fps_choose_the_moments(runs: Trajectories) -> None:
    assert len(list(pictures(runs, speed=1, fps=10))) == 161
    assert len(list(pictures(runs, speed=16, fps=1))) == 2
    assert len(list(pictures(runs, speed=1, fps=50))) == 161  # no more than were recorded


def test_worlds_of_a_batch_differ(runs: Trajectories) -> None:
    assert not np.array_equal(next(iter(pictures(runs, 0))), next(iter(pictures(runs, 1))))


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"path": "run.avi"}, "expected it to end in .gif or .mp4"),
        ({"path": "run.gif", "world": 2}, "world is 2, expected 0 to 1"),
        ({"path": "run.gif", "world": -1}, "world is -1"),
        ({"path": "run.gif", "fps": 0}, "fps is 0"),
        ({"path": "run.gif", "speed": 0}, "speed is 0"),
    ],
)
def test_bad_arguments_are_refused_by_name(runs: Trajectories, given: dict[str, object], message: str, tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=message):
        save_video(runs, **{**given, "path": tmp_path / str(given["path"])})  # type: ignore[arg-type]
    assert not list(tmp_path.iterdir())


def test_pictures_of_a_wrong_shape_are_refused(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=r"shape \(3, 4, 5\)"):
        save_video(np.zeros((3, 4, 5), np.uint8), tmp_path / "x.gif")


@pytest.mark.skipif(importlib.util.find_spec("imageio_ffmpeg") is not None, reason="imageio-ffmpeg is installed")
def test_without_the_video_package_an_mp4_says_how_to_get_it(runs: Trajectories, tmp_path: Path) -> None:
    with pytest.raises(ModuleNotFoundError, match=r"pip install 'swarm-envs\[video\]'"):
        save_video(runs, tmp_path / "run.mp4")


@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")  # imageio-ffmpeg leaves a pipe to the garbage collector
@pytest.mark.skipif(importlib.util.find_spec("imageio_ffmpeg") is None, reason="needs imageio-ffmpeg (extra: video)")
def test_an_mp4_has_every_picture_at_even_size(runs: Trajectories, tmp_path: Path) -> None:
    import imageio_ffmpeg

    path = save_video(runs, tmp_path / "run.mp4", width=321)
    reader = imageio_ffmpeg.read_frames(str(path))
    assert next(reader)["size"][0] == 322
    assert len(list(reader)) == 26
