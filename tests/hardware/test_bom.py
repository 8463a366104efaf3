"""The bill of materials: complete, summed, and set beside the paper's figure."""

from decimal import Decimal
from pathlib import Path

import pytest

from hardware.bom import PAPER_COST, load_bom, totals

DOCS = Path(__file__).parents[2] / "hardware" / "docs"
REQUIRED = {
    "servo", "controller", "tof_sensor", "optical_switch", "cell", "charger", "boost_converter", "power_switch", "o_ring", "filament",
}  # fmt: skip


def test_names_every_module_once() -> None:
    names = [line.part for line in load_bom()]
    assert len(names) == len(set(names))
    assert set(names) >= REQUIRED


def test_every_line_has_a_price_a_date_and_two_suppliers() -> None:
    for line in load_bom():
        assert line.quantity > 0, line.part
        assert Decimal(0) < line.unit_price <= line.unit_price_b, line.part
        assert (line.currency, line.date) == ("USD", "2026-11"), line.part
        assert line.supplier_a != line.supplier_b, line.part


def test_the_papers_figure_lies_between_the_cheap_and_the_dear_total() -> None:
    low, high = totals(load_bom())
    assert low < PAPER_COST < high
    assert abs(PAPER_COST - low) < 40
    assert abs(PAPER_COST - high) < 10


def test_the_docs_state_the_totals_of_the_file() -> None:
    text = (DOCS / "cost.md").read_text(encoding="utf-8")
    for total in totals(load_bom()):
        assert f"{total:.2f} USD" in text


def test_an_incomplete_line_is_refused_by_file_and_number(tmp_path: Path) -> None:
    path = tmp_path / "bom.csv"
    path.write_text(
        "part,specification,quantity,unit_price,currency,date,supplier_a,unit_price_b,supplier_b,replaces\nservo,,1,1,USD,2026-11,a,1,b,c\n"
    )
    with pytest.raises(ValueError, match=r"bom\.csv, line 2"):
        load_bom(path)
