"""The page of a study: written from the numbers, but for one section, which a person writes and which is kept."""

from __future__ import annotations

import json
import math
import re
import shutil
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from jinja2 import Environment, FileSystemLoader, StrictUndefined

from discovery.errors import DiscoveryError
from discovery.evaluation import published
from discovery.files.atomic import write_atomically
from discovery.rollouts.labels import BEHAVIOURS
from discovery.runs.run_folder import METRICS, read_manifest
from docs.studies.discovery_of_behaviours.evaluating import Evaluations
from docs.studies.discovery_of_behaviours.plan import Plan

BY_HAND = re.compile(r"(?<=<!-- by hand: kept when the page is written again -->\n).*?(?=<!-- end of what is by hand -->)", re.DOTALL)
"""The person's section."""
EMPTY = "Nobody has written anything here yet.\n"
FIGURES = ("representations", "tsne", "behaviours", "transfer", "variants")
"""Evaluations whose PNG stands in the page."""


def write_page(path: Path, plan: Plan, evaluations: Evaluations, left_out: dict[str, str], seeds: int) -> None:
    """Write the page and put its figures beside it.

    Raises:
        DiscoveryError: When nothing has been evaluated, or a page that is there lacks the marks of the person's section.
    """
    found = {name: _read(evaluations.out / name / f"{name}.json") for name in FIGURES}
    if not any(found.values()):
        raise DiscoveryError(f"{evaluations.out}: nothing has been evaluated, so there is no page to write; run something first")
    kept = by_hand(path)
    prefix = "" if path.stem == "index" else f"{path.stem}_"  # pages that are no folder's own share it with others
    for name in FIGURES:
        if found[name]:
            shutil.copyfile(evaluations.out / name / f"{name}.png", path.with_name(f"{prefix}{name}.png"))
    environment = Environment(
        loader=FileSystemLoader(Path(__file__).parent), undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    environment.filters |= {"pm": _plus_minus, "signed": _signed, "percent": _percent}
    text = environment.get_template("page.md.j2").render(
        **found, plan=plan, prefix=prefix, seeds=seeds, left_out=left_out, by_hand=kept, labels=BEHAVIOURS, published=published,
        cells=_cells(found["behaviours"]), setup=_setup(evaluations, plan), runs=_unfinished(evaluations, plan, left_out, seeds),
        cost=_cost(evaluations), verdicts=_verdicts(found),
    )  # fmt: skip
    tidy = re.sub(r"\n{3,}", "\n\n", re.sub(r" +\n", "\n", text))
    write_atomically(path, tidy.rstrip() + "\n")


def by_hand(path: Path) -> str:
    """Return the person's section of a page.

    Raises:
        DiscoveryError: When the page has not exactly one.
    """
    if not path.exists():
        return EMPTY
    sections = BY_HAND.findall(path.read_text(encoding="utf-8"))
    if len(sections) != 1:
        raise DiscoveryError(
            f"{path}: has {len(sections)} sections marked as written by hand, expected one; put its marks back or move it away"
        )
    return str(sections[0])


def _setup(evaluations: Evaluations, plan: Plan) -> dict[str, Any]:
    """Return what the encoder of the study was trained with, None where no such run is finished."""
    runs = [each for each in evaluations.of("representations") if each.entry.name == plan.worlds_with]
    if not runs:
        return {}
    settings, metrics = runs[0].settings, _read(runs[0].path / METRICS)
    return {
        "settings": settings, "representation": settings.representation, "origin": metrics["representation"]["origin"],
        "evaluations": settings.search.population * settings.search.generations,
    }  # fmt: skip


def _cells(behaviours: Any) -> dict[str, dict[str, tuple[float, float]]]:
    """Return mean and standard error by way and behaviour."""
    cells: dict[str, dict[str, tuple[float, float]]] = {}
    for row in behaviours["rows"] if behaviours else []:
        cells.setdefault(row["way"], {})[row["behaviour"]] = row["mean"], row["standard_error"]
    return cells


def _unfinished(evaluations: Evaluations, plan: Plan, left_out: dict[str, str], seeds: int) -> list[str]:
    """Return what is not finished and not left out, in words."""
    counts = Counter(each.entry.name for each in evaluations.done)
    names = [entry.name for entry in plan.entries if entry.name not in left_out]
    return [f"`{name}` ({counts[name]} of {seeds})" for name in names if counts[name] < seeds]


def _cost(evaluations: Evaluations) -> dict[str, Any]:
    """Return what the runs took, by stage in s, on which machines and from which code."""
    seconds: Counter[str] = Counter()
    machines, commits = Counter[str](), Counter[str]()
    for each in evaluations.done:
        manifest = read_manifest(each.path) or {}
        seconds.update(manifest["seconds"])
        machine = manifest["machine"]
        machines[f"{machine['processor']}, {manifest['threads']} threads" + (f", {machine['gpu']}" if machine["gpu"] else "")] += 1
        commits[((manifest["git"] or {}).get("commit") or "unknown")[:10]] += 1
    return {"seconds": dict(seconds), "runs": len(evaluations.done), "machines": machines, "commits": commits}


def _verdicts(found: dict[str, Any]) -> list[str]:
    """Say, number by number, how ours compare with the paper's."""
    told = []
    if found["representations"]:
        gains = found["representations"]["gain_over_hand_crafted"].get(published.SIMCLR, {})
        errors = _errors(found["representations"])
        for name, theirs in published.GAIN.items():
            if name in gains:
                told.append(
                    f"Triplets, {name}: the paper's encoder has {_signed(100 * theirs, 0)} points over the hand-crafted metrics, "
                    f"ours {_signed(100 * gains[name], 1)}: {_compare(gains[name], theirs, max(0.005, 2 * errors[name]))}."
                )
    ways = found["behaviours"]["ways"] if found["behaviours"] else {}
    for name, way in ways.items():
        counterpart = published.counterpart(name)
        if counterpart is not None:
            for key, paper in (("unique", published.UNIQUE[counterpart]), ("random", published.FREQUENCY[counterpart]["random"])):
                mean, error = way[key]
                spread = math.hypot(error or 0.0, paper[1])
                what = "different behaviours" if key == "unique" else "random medoids"
                told.append(
                    f"{name}, {what} of ten: paper {_plus_minus(paper)}, ours {_plus_minus((mean, error))}: "
                    f"{_compare(mean, paper[0], 2 * spread)}."
                )
    for entry in found["transfer"]["survival"] if found["transfer"] else []:
        if entry["world"] in published.SUCCESS:
            theirs = published.SUCCESS[entry["world"]][0]
            mean, low, high = entry["one_attempt"]["label"]
            if mean is not None:
                within = "the interval holds it" if low is not None and low <= theirs <= high else _compare(mean, theirs, 0.0)
                told.append(
                    f"Survival of what was found in `{entry['world']}`, one attempt, by label: paper's robots {_percent(theirs)}, "
                    f"our simulation {_percent(mean)}: {within}."
                )
    for entry in found["variants"]["variants"] if found["variants"] else []:
        met = entry["goals_met"]
        if entry["runs"] > 1 and met["unique"] and met["random"] and met["triplets"]:
            told.append(f"Better than the paper in all three measures: `{entry['name']}`, {entry['runs']} runs.")
    return told


def _errors(told: dict[str, Any]) -> dict[str, float]:
    """Return the standard error of SimCLR's triplet accuracy by class, 0 where one run has none; nothing without SimCLR."""
    spread = [each["confusion_standard_error"] for each in told["representations"] if each["name"] == published.SIMCLR]
    return {name: spread[0][k][k] or 0.0 for k, name in enumerate(told["classes"])} if spread else {}


def _compare(ours: float, theirs: float, margin: float) -> str:
    if abs(ours - theirs) <= margin:
        return "no difference that these runs could tell"
    return "more than the paper's" if ours > theirs else "less than the paper's"


def _plus_minus(pair: Sequence[float | None], digits: int = 2) -> str:
    """Return mean ± standard error; without the error where there is none."""
    mean, error = pair
    if mean is None:
        return ""
    return f"{mean:.{digits}f}" + ("" if error is None or not math.isfinite(error) else f" ± {error:.{digits}f}")


def _signed(value: float | None, digits: int = 2) -> str:
    return "" if value is None else f"{value:+.{digits}f}".replace("-", "\N{MINUS SIGN}")


def _percent(value: float | None) -> str:
    return "" if value is None or not math.isfinite(value) else f"{100 * value:.0f} %"


def _read(path: Path) -> Any:
    return json.loads(path.read_text(encoding="utf-8")) if path.exists() else None
