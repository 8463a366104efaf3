"""The bill of materials of one robot: read, summed, compared with the paper's figure.

``python -m hardware.bom`` prints the lines and the totals. Prices are estimates by hand, dated in the file; no shop was asked.
"""

from __future__ import annotations

import csv
import sys
from dataclasses import dataclass
from decimal import Decimal
from pathlib import Path

BOM = Path(__file__).parent / "bom.csv"
PAPER_COST = Decimal(80)
"""USD for one HeRo+ (paper, caption of the figure of the robots: approximately 80)."""


@dataclass(frozen=True)
class Line:
    """One line: what, how many, and what each costs at two kinds of supplier."""

    part: str
    specification: str
    quantity: int
    unit_price: Decimal
    currency: str
    date: str
    supplier_a: str
    unit_price_b: Decimal
    supplier_b: str
    replaces: str


def load_bom(path: Path = BOM) -> list[Line]:
    """Return the lines of a bill of materials.

    Raises:
        ValueError: When a line has an empty field or no number where one is due; names file and line.
    """
    lines = []
    with path.open(newline="", encoding="utf-8") as file:
        for number, row in enumerate(csv.DictReader(file), start=2):
            if None in row or not all(row.values()):
                raise ValueError(f"{path.name}, line {number}: empty or surplus field; fill in every column")
            try:
                prices = Decimal(row["unit_price"]), Decimal(row["unit_price_b"])
                quantity = int(row["quantity"])
            except ArithmeticError as error:
                raise ValueError(f"{path.name}, line {number}: price is not a number") from error
            lines.append(
                Line(
                    row["part"], row["specification"], quantity, prices[0], row["currency"], row["date"],
                    row["supplier_a"], prices[1], row["supplier_b"], row["replaces"],
                )
            )  # fmt: skip
    return lines


def totals(lines: list[Line]) -> tuple[Decimal, Decimal]:
    """Return the sums in USD at the cheaper suppliers and at the dearer ones."""
    return sum((line.quantity * line.unit_price for line in lines), Decimal(0)), sum(
        (line.quantity * line.unit_price_b for line in lines), Decimal(0)
    )


def main() -> int:
    """Print the bill and its totals."""
    lines = load_bom()
    for line in lines:
        costs = f"{line.quantity * line.unit_price:7.2f} {line.quantity * line.unit_price_b:7.2f}"
        print(f"{line.quantity:4d} x {line.part:18s} {costs}  {line.specification}")
    low, high = totals(lines)
    print(f"total {low:.2f} USD (marketplace), {high:.2f} USD (distributors); the paper says about {PAPER_COST} USD")
    return 0


if __name__ == "__main__":
    sys.exit(main())
