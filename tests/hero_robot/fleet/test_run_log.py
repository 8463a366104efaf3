"""What the server logs is what calibration reads."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest
import yaml

from swarm_envs.calibration import read_log
from tests.hero_robot.fleet.lab import CONTROLLER, Lab


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two runs of two seconds on simulated time, with a tracker's poses in the second."""
    folder = tmp_path_factory.mktemp("log") / "lab"
    lab = Lab(0, log=folder)
    assert lab.server is not None
    for run in range(2):
        lab.start_all()
        for step in range(20):
            lab.run(0.1)
            if run == 1:
                lab.server.pose("hero_3", 0.1 * step, 0.5, 1.0, lab.now_us - 20_000)
        assert lab.all_drive()
        lab.hold()
        lab.run(1.2)
    lab.close()
    return folder


def rows(log: Path, table: str) -> list[dict[str, str]]:
    with (log / f"{table}.csv").open() as stream:
        return list(csv.DictReader(stream))


def test_it_has_the_tables_and_columns_of_a_log_folder(log: Path) -> None:
    heads = {path.stem: path.read_text().splitlines()[0] for path in log.glob("*.csv")}
    assert heads == {
        "poses": "run,robot,t,x,y,theta",
        "commands": "run,robot,t,v,omega",
        "detections": "run,robot,t,detected",
        "odometry": "run,robot,t,x,y,theta",
    }
    description = yaml.safe_load((log / "log.yaml").read_text())
    assert {"name", "robot", "units", "source"} <= set(description)


def test_every_report_of_every_robot_is_there(log: Path) -> None:
    found = rows(log, "detections")
    runs = sorted({row["run"] for row in found})
    assert len(runs) == 2
    for run in runs:
        for robot in range(1, 9):
            times = np.array([float(row["t"]) for row in found if (row["run"], row["robot"]) == (run, f"hero_{robot}")])
            assert times[0] >= 0
            assert 2.5 < times[-1] < 4.5, "the run and how it came to rest"
            assert len(times) > 20 * times[-1] * 0.8
            assert np.median(np.diff(times)) < 0.06


def test_commands_follow_detections_and_end_in_rest(log: Path) -> None:
    commands, detections = rows(log, "commands"), rows(log, "detections")
    assert len(commands) == len(detections)
    driving = [
        (int(d["detected"]), float(c["v"]), float(c["omega"])) for c, d in zip(commands, detections, strict=True) if float(c["omega"])
    ]
    assert {seen for seen, _, _ in driving} == {0, 1}
    agree = np.mean([np.allclose((v, omega), CONTROLLER[2:] if seen else CONTROLLER[:2], atol=1e-4) for seen, v, omega in driving])
    assert agree > 0.9  # a detection may be one control period older than its command
    last = {(row["run"], row["robot"]): row for row in commands}
    assert {(row["v"], row["omega"]) for row in last.values()} == {("0.000000", "0.000000")}


def test_a_trackers_poses_are_on_the_same_clock(log: Path) -> None:
    poses = rows(log, "poses")
    assert {row["robot"] for row in poses} == {"hero_3"}
    assert len({row["run"] for row in poses}) == 1
    assert np.all(np.diff([float(row["t"]) for row in poses]) > 0.05)


def test_calibration_reads_it(log: Path) -> None:
    assert read_log(log) is not None
