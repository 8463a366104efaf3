"""The wiring of one robot, wire by wire, read from ``wiring.csv``."""

from __future__ import annotations

import csv
from dataclasses import dataclass
from pathlib import Path

WIRING = Path(__file__).parent / "wiring.csv"
BOARD_LABELS = {16: "D0", 5: "D1", 4: "D2", 0: "D3", 2: "D4", 14: "D5", 12: "D6", 13: "D7", 15: "D8"}
"""What the NodeMCU prints beside each GPIO of its ESP-12E."""


@dataclass(frozen=True)
class Wire:
    """One wire. ``signal`` and ``gpio`` stand where it ends at a pin that the robot file names."""

    net: str
    signal: str
    gpio: int | None
    board_label: str
    start: str
    start_pin: str
    end: str
    end_pin: str
    colour: str
    note: str


def load_wiring(path: Path = WIRING) -> list[Wire]:
    """Return the wires in the order in which they are soldered."""
    with path.open(newline="", encoding="utf-8") as file:
        return [
            Wire(
                row["net"], row["signal"], int(row["gpio"]) if row["gpio"] else None, row["board_label"],
                row["from"], row["from_pin"], row["to"], row["to_pin"], row["colour"], row["note"],
            )
            for row in csv.DictReader(file)
        ]  # fmt: skip


def as_table(wires: list[Wire]) -> str:
    """Return the wires as the Markdown table of ``docs/wiring.md``."""
    lines = ["| # | net | from | to | GPIO | colour | note |", "|---|---|---|---|---|---|---|"]
    for number, wire in enumerate(wires, start=1):
        pin = f"{wire.gpio} ({wire.board_label})" if wire.gpio is not None else wire.board_label
        cells = (str(number), wire.net, f"{wire.start}: {wire.start_pin}", f"{wire.end}: {wire.end_pin}", pin, wire.colour, wire.note)
        lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines)
