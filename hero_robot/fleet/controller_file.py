"""The controller update file: what ``python -m hero_robot.fleet load FLEET FILE`` loads on robots."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path

import yaml

from hero_robot.fleet.errors import FleetError

KEY = "controller"


def controller_document(genes: Sequence[float], about: Mapping[str, str | int | float]) -> str:
    """Return the file's text.

    Args:
        genes: [v0, w0, v1, w1] in m/s and rad/s.
        about: Where the controller comes from, for people.
    """
    lines = ["# Load it on robots: python -m hero_robot.fleet load FLEET THIS_FILE"]
    lines.append("# [v0, w0, v1, w1]: m/s and rad/s when the sensor sees nothing, m/s and rad/s when it sees a robot")
    return "\n".join(lines) + "\n" + yaml.safe_dump({KEY: [float(gene) for gene in genes], "about": dict(about)}, sort_keys=False)


def read_controller(path: Path) -> tuple[float, float, float, float]:
    """Read what :func:`controller_document` wrote.

    Raises:
        FleetError: When it is absent or wrong; one line. Whether the numbers suit them, robots decide.
    """
    try:
        document = yaml.safe_load(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise FleetError(f"{path}: cannot be read ({error.strerror}); write it: python -m discovery.export RUN --out FOLDER") from None
    except (yaml.YAMLError, UnicodeDecodeError) as error:
        raise FleetError(f"{path}: not valid YAML ({' '.join(str(error).split())})") from None
    genes = document.get(KEY) if isinstance(document, dict) else None
    if not isinstance(genes, list) or len(genes) != 4 or not all(_is_finite(gene) for gene in genes):
        raise FleetError(f"{path}: {KEY} is {genes!r}, expected four numbers [v0, w0, v1, w1] in m/s and rad/s")
    v0, w0, v1, w1 = map(float, genes)
    return v0, w0, v1, w1


def _is_finite(gene: object) -> bool:
    return isinstance(gene, int | float) and not isinstance(gene, bool) and math.isfinite(gene)
