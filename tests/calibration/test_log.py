"""Reading measured logs: what is repaired, and what is refused in one line."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from swarm_envs.calibration import LogError, read_log

POSES = "run,robot,t,x,y,theta\n"
COMMANDS = "run,robot,t,v,omega\n"


def write(folder: Path, poses: str = "a,r,0,0,0,0\na,r,0.1,0,0,0\n", commands: str = "a,r,0,0.1,0\n", about: str = "name: it\n") -> Path:
    (folder / "log.yaml").write_text(about)
    (folder / "poses.csv").write_text(POSES + poses)
    (folder / "commands.csv").write_text(COMMANDS + commands)
    return folder


def test_rows_are_sorted_and_of_two_of_one_time_the_last_counts(tmp_path: Path) -> None:
    log = read_log(write(tmp_path, "a,r,0.2,2,0,0\na,r,0.1,1,0,0\na,r,0.1,1.5,0,0\n"))
    assert log.tracks[0].times.tolist() == [0.1, 0.2]
    assert log.tracks[0].poses[:, 0].tolist() == [1.5, 2.0]
    assert len(log.notes) == 2


def test_wrapped_headings_are_unwrapped(tmp_path: Path) -> None:
    log = read_log(write(tmp_path, "a,r,0,0,0,3.1\na,r,0.1,0,0,-3.1\n"))
    assert np.diff(log.tracks[0].poses[:, 2]) == pytest.approx(2 * math.pi - 6.2)


def test_lost_poses_are_gaps(tmp_path: Path) -> None:
    log = read_log(write(tmp_path, "a,r,0,0,0,0\na,r,0.1,nan,,0\na,r,0.2,0,0,0\n"))
    assert log.tracks[0].times.tolist() == [0.0, 0.2]
    assert "lost" in log.notes[0]


def test_a_tracker_that_jumps_and_comes_back_is_not_believed(tmp_path: Path) -> None:
    poses = "".join(f"a,r,{0.02 * k},{0.002 * k if k != 7 else 3.0},0,0\n" for k in range(20))
    assert 3.0 not in read_log(write(tmp_path, poses)).tracks[0].poses[:, 0]


def test_units_are_converted(tmp_path: Path) -> None:
    log = read_log(write(tmp_path, "a,r,0,1000,0,90\n", about="units: {x: mm, theta: deg, v: as sent to the robot}\n"))
    assert log.tracks[0].poses[0] == pytest.approx([1.0, 0.0, math.pi / 2])
    assert log.driver_units


def test_several_robots_and_runs_are_tracks_of_their_own(tmp_path: Path) -> None:
    log = read_log(write(tmp_path, "a,r,0,0,0,0\na,s,0,0,0,0\nb,r,0,0,0,0\n"))
    assert [(t.run, t.robot) for t in log.tracks] == [("a", "r"), ("a", "s"), ("b", "r")]
    assert log.runs == ("a", "b")
    assert log.robots == ("r", "s")


def test_parquet_is_read_like_csv(tmp_path: Path) -> None:
    pyarrow = pytest.importorskip("pyarrow")
    parquet = pytest.importorskip("pyarrow.parquet")
    write(tmp_path)
    (tmp_path / "poses.csv").unlink()
    columns = {"run": ["a"], "robot": ["r"], "t": [0.5], "x": [1.0], "y": [2.0], "theta": [3.0]}
    parquet.write_table(pyarrow.table(columns), tmp_path / "poses.parquet")
    assert read_log(tmp_path).tracks[0].poses.tolist() == [[1.0, 2.0, 3.0]]


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        ({"poses": "a,r,0,0,zero,0\n"}, r"poses.csv: row 2: y is 'zero', expected a number"),
        ({"poses": "a,r,0,0,0\n"}, r"poses.csv: row 2: 5 cells, expected 6"),
        ({"poses": "a,r,0,0,0,0\na,r,inf,0,0,0\n"}, r"poses.csv: row 3: t is inf"),
        ({"commands": "a,r,0,nan,0\n"}, r"commands.csv: row 2: v is nan"),
        ({"commands": ""}, r"commands: no rows"),
        ({"about": "units: {x: furlong}\n"}, r"log.yaml: units.x is 'furlong', expected one of m, cm, mm"),
        ({"about": "- a\n"}, r"log.yaml: expected a mapping"),
        ({"about": "outline: [[0, 0]]\n"}, r"log.yaml: outline has 1 corners"),
    ],
)
def test_what_cannot_be_used_is_refused_with_file_row_and_reason(tmp_path: Path, change: dict[str, str], reason: str) -> None:
    with pytest.raises(LogError, match=reason):
        read_log(write(tmp_path, **change))


def test_a_detection_is_yes_or_no(tmp_path: Path) -> None:
    write(tmp_path)
    (tmp_path / "detections.csv").write_text("run,robot,t,detected\na,r,0,1\na,r,0.1,2\n")
    with pytest.raises(LogError, match=r"detections.csv: row 3: detected is 2, expected 0 or 1"):
        read_log(tmp_path)


def test_a_folder_that_is_not_there_is_refused(tmp_path: Path) -> None:
    with pytest.raises(LogError, match="no such folder"):
        read_log(tmp_path / "nowhere")
