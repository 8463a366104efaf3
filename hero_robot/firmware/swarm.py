"""Every simulated robot driven by the robot's own code."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hero_robot.firmware.board import SimulatedBoard
from hero_robot.firmware.errors import FirmwareError
from swarm_envs.worlds import load_robot_file

STILL = 1e-3
"""Rim speed, m/s, below which a wheel is too slow to say what holds it."""


class FirmwareSwarm:
    """R robots, each the firmware on a simulated board: detections in, motion out.

    In the loop are the firmware's debounce, its 50 Hz control loop, fixed point, velocity control, and a servo with dead
    band, lag and 1 us pulses, an encoder of 96 ticks and a range sensor of 20 Hz. The same calls give the same bits.

    >>> swarm = FirmwareSwarm("hero_plus", 8, (0.08, 0.4, 0.06, -1.2))
    >>> swarm.reset()
    >>> swarm.step(np.zeros(8, dtype=np.uint8), 0.1).shape
    (8, 2)

    Args:
        robot_file: Name or path of the robot file whose constants are compiled in.
        num_robots: R.
        controllers: [v0, w0, v1, w1] in m/s and rad/s, for all robots (4,) or each (R, 4).
        seed: Of where the wheels stand within an encoder tick at the start.

    Raises:
        FirmwareError: Without a C compiler or cffi, or for controllers of another shape or beyond the robot's limits.
    """

    def __init__(self, robot_file: str | Path, num_robots: int, controllers: ArrayLike, seed: int = 0) -> None:
        robot = load_robot_file(robot_file)
        self._range = float(robot["sensors"][0]["range"])
        self._base = float(robot["drive"]["wheel_base"])
        genes = np.asarray(controllers, dtype=np.float64)
        if genes.shape not in {(4,), (num_robots, 4)}:
            raise FirmwareError(f"controllers have the shape {genes.shape}; expected (4,) or ({num_robots}, 4): v0, w0, v1, w1")
        self._genes = np.broadcast_to(genes, (num_robots, 4))
        self._check_range(robot["drive"])
        keys = [bytes([index % 256]) * 32 for index in range(num_robots)]  # nobody listens in a simulation
        self.boards = [SimulatedBoard(index + 1, key, seed * num_robots + index, robot_file) for index, key in enumerate(keys)]
        self._pointers = self.boards[0].ffi.new("struct hero_sim *[]", [board.pointer for board in self.boards])
        self._rims: NDArray[np.float64] = np.zeros((num_robots, 2))

    def _check_range(self, drive: dict[str, float]) -> None:
        limits = np.array([drive["max_linear_speed"], drive["max_angular_speed"]] * 2)
        if not (np.abs(self._genes) <= limits).all():
            worst = int(np.argmax((np.abs(self._genes) / limits).max(axis=1)))
            raise FirmwareError(f"controller {self._genes[worst].tolist()} is beyond +-{limits[:2].tolist()} m/s, rad/s: robots refuse it")

    def reset(self) -> None:
        """Switch every robot off and on, load its controller and start it: RUN at time zero, wheels at rest.

        Raises:
            FirmwareError: When a robot does not reach RUN.
        """
        self._rims = np.zeros_like(self._rims)
        for board, genes in zip(self.boards, self._genes, strict=True):
            board.library.hero_sim_init(board.pointer, board.robot, board.key, board.seed)
            v0, w0, v1, w1 = (float(gene) for gene in genes)
            if not board.start((v0, w0, v1, w1)):
                raise FirmwareError(
                    f"robot {board.robot} stays in {board.view().state.name} and did not start; this is a fault of the firmware"
                )

    def step(
        self, detections: ArrayLike, dt: float, *, distances: ArrayLike | None = None, motion: ArrayLike | None = None
    ) -> NDArray[np.float64]:
        """Let ``dt`` seconds pass on every robot.

        Args:
            detections: (R,), whether a robot stands in view; the range sensor then reads half its threshold.
            dt: Simulated time, s, whole microseconds.
            distances: (R,) m to what stands in view instead, 0 or infinite for nothing; ``detections`` is then not read.
            motion: (R, 2) m/s and rad/s, how the robots really moved in the last step, for wheels that do not slip: a robot
                that was held turns its wheels, and counts ticks, only as far as it moved. Without it the wheels slip freely.

        Returns:
            (R, 2): the mean forward speed, m/s, and turn rate, rad/s, that the servos drove at in this step: what the simulation
            takes as the robot's desired velocity, which contact may refuse.
        """
        ffi, library = self.boards[0].ffi, self.boards[0].library
        before = self._distances(detections, distances)
        grip = None if motion is None else self._grip(np.asarray(motion, dtype=np.float64))
        rims = np.empty_like(self._rims)
        library.hero_sim_step(
            self._pointers,
            len(self.boards),
            ffi.cast("double *", before.ctypes.data),
            ffi.NULL if grip is None else ffi.cast("double *", grip.ctypes.data),
            round(dt * 1e6),
            ffi.cast("double *", rims.ctypes.data),
        )
        self._rims = rims
        return np.stack([rims.mean(axis=1), (rims[:, 1] - rims[:, 0]) / self._base], axis=1)

    def _distances(self, detections: ArrayLike, distances: ArrayLike | None) -> NDArray[np.float64]:
        if distances is None:
            return np.ascontiguousarray(np.where(np.asarray(detections) != 0, self._range / 2, 0.0), dtype=np.float64)
        given = np.asarray(distances, dtype=np.float64)
        return np.ascontiguousarray(np.where((given > 0) & (given < 60.0), given, 0.0))  # the part's register ends at 65 m

    def _grip(self, motion: NDArray[np.float64]) -> NDArray[np.float64]:
        """Part (R, 2) of its speed that each wheel really turned at in the last step."""
        half = motion[:, 1:] * self._base / 2
        actual = motion[:, :1] + half * np.array([[-1.0, 1.0]])
        moving = np.abs(self._rims) > STILL
        ratio = np.divide(actual, self._rims, out=np.ones_like(actual), where=moving)
        return np.ascontiguousarray(np.clip(ratio, 0.0, 1.0))
