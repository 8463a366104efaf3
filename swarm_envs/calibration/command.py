"""``swarm-calibrate``: what a world gets wrong about a measured log, why, and the world with that added."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Sequence
from pathlib import Path

from swarm_envs.calibration.errors import LogError
from swarm_envs.calibration.logs.log import Log
from swarm_envs.calibration.logs.reading import read_log
from swarm_envs.calibration.prediction.evaluation import evaluate
from swarm_envs.worlds import WorldError


def parser() -> argparse.ArgumentParser:
    """Return the command's arguments."""
    arguments = argparse.ArgumentParser(prog="swarm-calibrate", description=__doc__)
    arguments.add_argument("log", nargs="*", help="folder with log.yaml, poses, commands and, if any, detections; or ROS bags")
    arguments.add_argument("--topics", metavar="MAP", help="YAML file that says which topics of the bags are what (default: guessed)")
    arguments.add_argument("--world", default="hero_plus", help="world to calibrate: a name or a YAML file (default: %(default)s)")
    arguments.add_argument("--out", type=Path, help="folder for findings.json, extended.yaml and report.html")
    arguments.add_argument("--evaluate", nargs="+", metavar=("WORLD", "LOG"), help="predict a log with a world, nothing fitted")
    arguments.add_argument("--leave-one-out", action="store_true", help="calibrate again without each run; see how the findings move")
    arguments.add_argument("--json", action="store_true", help="print JSON instead of text")
    return arguments


def main(given: Sequence[str] | None = None) -> int:
    """Run the command; returns its exit status."""
    arguments = parser().parse_args(given)
    try:
        if arguments.evaluate:
            world, *logs = arguments.evaluate
            if not logs or arguments.log:
                raise LogError("give --evaluate WORLD LOG, or LOG --world WORLD --out FOLDER")
            _evaluate(world, read_log(*logs, topics=arguments.topics), as_json=arguments.json)
        elif not arguments.log or arguments.out is None:
            raise LogError("give LOG --world WORLD --out FOLDER, or --evaluate WORLD LOG")
        else:
            _calibrate(arguments)
    except (LogError, WorldError, OSError) as error:
        print(f"swarm-calibrate: {error}", file=sys.stderr)
        return 2
    return 0


def _evaluate(world: str, log: Log, *, as_json: bool) -> None:
    for note in log.notes:
        print(f"  {note}", file=sys.stderr)
    result = evaluate(world, log)
    if as_json:
        print(json.dumps(result))
        return
    print("horizon  position rms  heading rms  windows")
    for horizon, row in result.items():
        print(f"{horizon:>5} s  {1e3 * row['position_m']:9.1f} mm  {row['heading_rad']:7.3f} rad  {row['windows']:7.0f}")


def _calibrate(arguments: argparse.Namespace) -> None:
    try:
        from swarm_envs.calibration.findings import calibrate
        from swarm_envs.calibration.progress import Progress
        from swarm_envs.calibration.report.page import write_folder
        from swarm_envs.calibration.validation.leave_one_out import leave_one_out
    except ImportError as error:
        raise LogError(f"{error}; install swarm-envs[calibration]") from None
    log = read_log(*arguments.log, topics=arguments.topics)
    with Progress() as progress:
        for note in log.notes:
            progress(note)
        findings = calibrate(log, arguments.world, progress)
        stability = leave_one_out(log, findings.spec, findings.causes, progress) if arguments.leave_one_out else None
        progress("writing the report")
        write_folder(findings, arguments.out, stability)
    if arguments.json:
        print(findings.to_json(), end="")
        return
    for cause in findings.causes:
        print(f"{cause.effect}: {cause.explanation}")
    for group in findings.indistinguishable:
        print(f"cannot be told apart: {', '.join(group)}")
    if findings.unexplained is not None:
        print(f"unexplained: {findings.unexplained.channel} depends on {findings.unexplained.depends_on}")
    for gain in findings.gain:
        after = "" if gain.horizon_s is None else f" after {gain.horizon_s:g} s"
        print(f"{gain.metric}{after}: {gain.before:.4g} -> {gain.after:.4g} {gain.unit}, held out")
    if stability is not None:
        for effect, times in stability.named.items():
            print(f"{effect}: named {times} times of {stability.runs} with a run left out")
    print(f"written: {arguments.out}/findings.json, {arguments.out}/extended.yaml, {arguments.out}/report.html")


if __name__ == "__main__":
    sys.exit(main())
