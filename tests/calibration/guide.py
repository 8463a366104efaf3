"""The snippets of docs/guides/calibration.md."""

from __future__ import annotations

import re
import shlex
from pathlib import Path
from typing import Any

from swarm_envs.calibration.command import main

GUIDE = (Path(__file__).parents[2] / "docs" / "guides" / "calibration.md").read_text(encoding="utf-8")
SNIPPETS = re.findall(r"```(python|bash|yaml)\n(.*?)```", GUIDE, flags=re.DOTALL)


def snippet(kind: str, number: int) -> str:
    return [text for name, text in SNIPPETS if name == kind][number]


def python(number: int) -> dict[str, Any]:
    names: dict[str, Any] = {}
    exec(compile(snippet("python", number), f"snippet {number}", "exec"), names)
    return names


def bash(number: int) -> None:
    for line in snippet("bash", number).splitlines():
        command, *arguments = shlex.split(line)
        assert command == "swarm-calibrate"
        assert main(arguments) == 0
