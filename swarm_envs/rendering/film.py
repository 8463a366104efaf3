"""Moving pictures: a run as a GIF or an MP4."""

from __future__ import annotations

import importlib
import math
from collections.abc import Iterator
from pathlib import Path
from typing import Protocol, cast

import numpy as np
import numpy.typing as npt
from PIL import Image

from swarm_envs.metrics import in_contact
from swarm_envs.rendering.picture import Picture, Renderer
from swarm_envs.worlds.spec import WorldSpec

COMMON_COLOURS, SPREAD_COLOURS = 64, 64
"""A GIF's palette, one for all its frames so that nothing shimmers: the most frequent colours, and colours spread over the rest."""


class _Recording(Protocol):
    @property
    def poses(self) -> npt.NDArray[np.float64]: ...

    @property
    def detections(self) -> npt.NDArray[np.uint8]: ...

    @property
    def time(self) -> npt.NDArray[np.float64]: ...

    @property
    def world(self) -> WorldSpec: ...


def save_video(
    source: _Recording | npt.ArrayLike,
    path: str | Path,
    world: int = 0,
    *,
    fps: float = 12.5,
    speed: float = 8.0,
    width: int = 320,
    trail: float = 12.0,
    beams: bool = True,
) -> Path:
    """Save one run as a looping GIF or as an MP4, whichever the path's ending says.

    Args:
        source: Trajectories, or finished pictures (frames, height, width, 3) uint8, of which each is shown for ``1 / fps`` s.
        path: Where to write; must end in ``.gif`` or ``.mp4``. MP4 needs the optional package imageio-ffmpeg.
        world: Which world of the trajectories.
        fps: Pictures per second of the video, at most 50; a GIF rounds the time of a picture to 0.01 s.
        speed: How many times faster than the robots the video runs; not used for finished pictures.
        width: Picture width in pixels; not used for finished pictures.
        trail: Length of the trails in s of robot time, 0 for none; not used for finished pictures.
        beams: Whether to draw the detection beams; not used for finished pictures.

    Returns:
        The path written.

    Raises:
        ValueError: On another ending, no such world, or pictures of a wrong shape.
        ModuleNotFoundError: For MP4 without imageio-ffmpeg; the message says how to install it.
    """
    target = Path(path)
    if target.suffix.lower() not in (".gif", ".mp4"):
        raise ValueError(f"path is {str(path)!r}, expected it to end in .gif or .mp4")
    if not 0 < fps <= 50:
        raise ValueError(f"fps is {fps!r}, expected a number above 0 and at most 50")
    if hasattr(source, "poses"):
        images = np.stack(list(pictures(cast(_Recording, source), world, fps=fps, speed=speed, width=width, trail=trail, beams=beams)))
    else:
        images = np.asarray(source)
        if images.ndim != 4 or images.shape[-1] != 3 or images.dtype != np.uint8 or not len(images):
            raise ValueError(f"pictures have shape {images.shape} and type {images.dtype}, expected (frames, height, width, 3) of uint8")
    (_save_gif if target.suffix.lower() == ".gif" else _save_mp4)(images, target, fps)
    return target


def pictures(
    trajectories: _Recording,
    world: int = 0,
    *,
    fps: float = 12.5,
    speed: float = 8.0,
    width: int = 320,
    trail: float = 12.0,
    beams: bool = True,
) -> Iterator[Picture]:
    """Yield the pictures (height, width, 3) uint8 of one run; the arguments are those of :func:`save_video`."""
    if not 0 <= world < len(trajectories.poses):
        raise ValueError(f"world is {world}, expected 0 to {len(trajectories.poses) - 1}: the trajectories hold {len(trajectories.poses)}")
    if not (speed > 0 and trail >= 0):
        raise ValueError(f"speed is {speed!r} and trail {trail!r}, expected speed above 0 and trail of at least 0")
    poses, time = trajectories.poses[world], trajectories.time
    objects = getattr(trajectories, "object_poses", None)
    renderer = Renderer(trajectories.world, width)
    for now in _shown_frames(time, speed / fps):
        first = int(np.searchsorted(time, time[now] - trail - 1e-9))
        yield renderer(
            poses[now],
            detections=trajectories.detections[world, now] if beams else None,
            trail=poses[first : now + 1] if trail else None,
            contacts=in_contact(trajectories.world, poses[now]),
            object_poses=None if objects is None else objects[world, now],
        )


def _shown_frames(time: npt.NDArray[np.float64], every: float) -> list[int]:
    """Indices of the recorded frames nearest to multiples of ``every`` seconds, each at most once."""
    count = math.floor((time[-1] - time[0]) / every + 1e-9) + 1
    wanted = time[0] + every * np.arange(count)
    after = np.clip(np.searchsorted(time, wanted), 1, max(1, len(time) - 1)) if len(time) > 1 else np.zeros(count, dtype=np.intp)
    nearest = np.where(wanted - time[after - 1] < time[after] - wanted, after - 1, after)
    return [int(i) for i in np.unique(nearest)]


def _save_gif(images: npt.NDArray[np.uint8], path: Path, fps: float) -> None:
    """Write a GIF that loops, undithered in one palette taken from frames spread over the run."""
    palette = _palette(images[np.unique(np.linspace(0, len(images) - 1, 12).astype(int))])
    frames = [Image.fromarray(image).quantize(palette=palette, dither=Image.Dither.NONE) for image in images]
    duration = max(20, 10 * round(100 / fps))
    frames[0].save(path, save_all=True, append_images=frames[1:], duration=duration, loop=0, optimize=False, disposal=1)


def _palette(images: npt.NDArray[np.uint8]) -> Image.Image:
    """Choose colours: the many small things, such as bodies, keep their exact ones, gradients share the others."""
    red, green, blue = np.moveaxis(images.astype(np.uint32), -1, 0)
    colours, counts = np.unique(red << 16 | green << 8 | blue, return_counts=True)  # one number for each: rows sort ten times as slowly
    chosen = colours[np.argsort(-counts, kind="stable")[:COMMON_COLOURS]]
    common = np.stack([chosen >> 16, chosen >> 8 & 255, chosen & 255], axis=1)
    spread = Image.fromarray(np.concatenate(list(images))).quantize(SPREAD_COLOURS, method=Image.Quantize.MAXCOVERAGE).getpalette()
    palette = Image.new("P", (1, 1))
    palette.putpalette([*common.ravel().tolist(), *(spread or [])[: 3 * SPREAD_COLOURS]])
    return palette


def _save_mp4(images: npt.NDArray[np.uint8], path: Path, fps: float) -> None:
    """Write an MP4 that browsers play (H.264, 4:2:0, so that sides must be even: the last row or column is doubled)."""
    try:
        ffmpeg = importlib.import_module("imageio_ffmpeg")
    except ModuleNotFoundError:
        raise ModuleNotFoundError(
            "an .mp4 needs the package imageio-ffmpeg: pip install 'swarm-envs[video]', or save a .gif instead"
        ) from None
    height, width = images.shape[1:3]
    even = np.pad(images, ((0, 0), (0, height % 2), (0, width % 2), (0, 0)), mode="edge")
    size = (even.shape[2], even.shape[1])
    writer = ffmpeg.write_frames(str(path), size, fps=fps, codec="libx264", quality=8, macro_block_size=2, ffmpeg_log_level="error")
    writer.send(None)
    for image in even:
        writer.send(np.ascontiguousarray(image))
    writer.close()
