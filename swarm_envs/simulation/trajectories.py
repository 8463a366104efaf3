"""What a batch of runs left behind."""

from __future__ import annotations

import json
import zipfile
from dataclasses import dataclass
from pathlib import Path
from typing import Self

import numpy as np
import numpy.typing as npt

from swarm_envs.worlds import WorldError, WorldSpec
from swarm_envs.worlds.dump import world_from_text, world_to_text

FORMAT = "swarm_envs.trajectories.1"


@dataclass(frozen=True)
class Trajectories:
    """Recorded runs of W worlds: F frames of R robots. Frame 0 is the start.

    The arena frame has its origin at the inner lower left corner, x to the right, y up; headings are counter-clockwise and not
    wrapped.
    """

    world: WorldSpec
    """The world that they ran in."""
    engine: str
    """The engine that solved contacts."""
    time: npt.NDArray[np.float64]
    """(F,) s since the start."""
    poses: npt.NDArray[np.float64]
    """(W, F, R, 3) x and y in m, heading in rad."""
    detections: npt.NDArray[np.uint8]
    """(W, F, R) readings, or (W, F, R, S) where robots have S > 1: one per sensor, and with a broadcast whether they hear another."""
    commands: npt.NDArray[np.float64]
    """(W, F, R, 2) v in m/s and omega in rad/s, given at that frame."""
    object_poses: npt.NDArray[np.float64] | None = None
    """(W, F, B, 3) poses of the pushable objects in m, m, rad; None in worlds without."""

    def __len__(self) -> int:
        return len(self.poses)

    def __getitem__(self, which: slice | npt.NDArray[np.int64]) -> Self:
        """Return some of the worlds, by slice or array of indices."""
        objects = None if self.object_poses is None else self.object_poses[which]
        return type(self)(self.world, self.engine, self.time, self.poses[which], self.detections[which], self.commands[which], objects)

    def save(self, path: str | Path) -> Path:
        """Write one compressed ``.npz`` file without pickled objects; return its path.

        Raises:
            OSError: When the file cannot be written; a file of that name stays as it was.
        """
        path = Path(path).with_suffix(".npz")
        header = json.dumps({"format": FORMAT, "engine": self.engine, "world": world_to_text(self.world)})
        arrays = {"time": self.time, "poses": self.poses, "detections": self.detections, "commands": self.commands}
        if self.object_poses is not None:
            arrays["object_poses"] = self.object_poses
        partial = path.with_name(path.name + ".partial")
        try:
            with partial.open("wb") as file:
                np.savez_compressed(file, header=np.array(header), **arrays)  # type: ignore[arg-type]  # allow_pickle is no array
            partial.replace(path)
        finally:
            partial.unlink(missing_ok=True)
        return path

    @classmethod
    def load(cls, path: str | Path) -> Self:
        """Read a file that :meth:`save` wrote.

        Raises:
            WorldError: When the file is missing, damaged or something else.
        """
        try:
            # opened here: numpy leaves a file open that turns out to be damaged
            with open(path, "rb") as opened, np.load(opened, allow_pickle=False) as file:
                header = json.loads(str(file["header"]))
                if header.get("format") != FORMAT:
                    raise WorldError(f"{path}: format is {header.get('format')!r}, expected {FORMAT!r}; save it again with this version")
                world = world_from_text(header["world"])
                objects = file.get("object_poses")
                return cls(world, header["engine"], file["time"], file["poses"], file["detections"], file["commands"], objects)
        except (OSError, KeyError, ValueError, EOFError, zipfile.BadZipFile) as error:
            if isinstance(error, WorldError):
                raise
            raise WorldError(f"{path}: not readable as trajectories ({error}); give a file written by Trajectories.save") from None
