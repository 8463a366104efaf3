"""``swarm-calibrate``: what a world gets wrong about a measured log."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Sequence

from swarm_envs.calibration.errors import LogError
from swarm_envs.calibration.prediction import evaluate
from swarm_envs.worlds import WorldError


def parser() -> argparse.ArgumentParser:
    """Return the command's arguments."""
    arguments = argparse.ArgumentParser(prog="swarm-calibrate", description=__doc__)
    arguments.add_argument(
        "--evaluate", nargs=2, metavar=("WORLD", "LOG"), required=True, help="predict a log with a world, nothing fitted"
    )
    arguments.add_argument("--json", action="store_true", help="print JSON instead of a table")
    return arguments


def main(given: Sequence[str] | None = None) -> int:
    """Run the command; returns its exit status."""
    arguments = parser().parse_args(given)
    try:
        result = evaluate(*arguments.evaluate)
    except (LogError, WorldError) as error:
        print(f"swarm-calibrate: {error}", file=sys.stderr)
        return 2
    if arguments.json:
        print(json.dumps(result))
    else:
        print("horizon  position rms  heading rms  windows")
        for horizon, row in result.items():
            print(f"{horizon:>5} s  {1e3 * row['position_m']:9.1f} mm  {row['heading_rad']:7.3f} rad  {row['windows']:7.0f}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
