"""Numbers and figures of the page, from measured logs that are no part of the project.

``make study-calibration_of_real_robots ARGS=FOLDER`` or ``python -m docs.studies.calibration_of_real_robots FOLDER`` calibrates the logs
``hero_2018``, ``epuck_2018`` and ``create_2009`` in a folder, each against the world ``hero`` with an ideal drive, and writes the tables
between the page's markers and the figures beside it. With ``--leave-one-out`` each is calibrated again without each of its runs.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Sequence
from pathlib import Path

from docs.studies.calibration_of_real_robots.figures import horizon_figure, step_figure
from docs.studies.calibration_of_real_robots.tables import ROBOTS, cause_table, gain_table, label_table, onset_table, rest_table
from docs.studies.marked_page import write_between_marks
from swarm_envs import load_world
from swarm_envs.calibration import calibrate
from swarm_envs.calibration.validation.leave_one_out import leave_one_out

PAGE = Path(__file__).with_name("index.md")
IDEAL = load_world("hero").with_effects(linear_gain=1.0, dead_time=0.0)


def main(arguments: Sequence[str] | None = None) -> None:
    """Calibrate, and write the page's tables and figures."""
    parser = argparse.ArgumentParser(
        prog="python -m docs.studies.calibration_of_real_robots", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("folder", type=Path, help="folder with the measured logs")
    parser.add_argument("--leave-one-out", action="store_true", help="calibrate again without each run")
    options = parser.parse_args(arguments)
    every, stability = [], {}
    for name in ROBOTS:
        begin = time.process_time()
        findings = calibrate(options.folder / name, IDEAL)
        print(
            f"{name}: {', '.join(cause.effect for cause in findings.causes)} ({time.process_time() - begin:.0f} s)",
            file=sys.stderr,
            flush=True,
        )
        every.append(findings)
        if options.leave_one_out:
            stability[name] = leave_one_out(findings.log, IDEAL, findings.causes, lambda text: print(text, file=sys.stderr, flush=True))
    tables = {
        "gain": gain_table(every), "causes": cause_table(every, stability), "rest": rest_table(every), "onset": onset_table(every[0]),
        "labels": label_table(),
    }  # fmt: skip
    write_between_marks(PAGE, tables)
    horizon_figure(every).savefig(PAGE.with_name("horizons.png"), dpi=90)
    step_figure(every[0]).savefig(PAGE.with_name("hero_steps.png"), dpi=90)
