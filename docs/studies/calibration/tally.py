"""Counts of what was hidden against what was named."""

from __future__ import annotations

import csv
import io
from collections import Counter
from collections.abc import Callable, Iterable, Sequence

from docs.studies.calibration.draws import DEPENDS_ON, Outcome
from docs.studies.calibration.generator import EFFECTS
from docs.studies.intervals import wilson

SAME_NUMBER = {("clock_offset", "dead_time"): ("offset", "delay"), ("dead_time", "clock_offset"): ("delay", "offset")}
"""Confounded effects whose parameters are one number: poses stamped late look like commands that act late."""
NOTHING = "nothing"
SEEN = 3
"""Runs that have to drive on either side of an edge: without one of them, others still show where it is."""
HALF = 0.5
"""Share of the held-out error that a correction for an unlisted effect must remove."""


def confounded_with(outcome: Outcome, effect: str) -> str | None:
    """The named effect that the calibration calls indistinguishable from a hidden one that it did not name."""
    for group in outcome.groups:
        if effect in group and effect not in outcome.named:
            for other in group:
                if other in outcome.named and other not in outcome.hidden:
                    return other
    return None


def found(outcome: Outcome, effect: str) -> bool:
    """Whether a hidden effect was named, or said to be indistinguishable from one that was."""
    return effect in outcome.named or confounded_with(outcome, effect) is not None


def intervals(outcome: Outcome, effect: str) -> dict[str, tuple[float, float, float]]:
    """(estimate, low, high) of a found effect's parameters, or those of the confounded effect that was named instead."""
    if effect in outcome.named:
        return outcome.named[effect]
    other = confounded_with(outcome, effect)
    if other is not None and (effect, other) in SAME_NUMBER:
        mine, its = SAME_NUMBER[effect, other]
        return {mine: outcome.named[other][its]}
    return {}


def covered(outcome: Outcome, effect: str) -> bool:
    """Whether the intervals of all parameters of an effect hold the truth."""
    given = intervals(outcome, effect)
    return all(name in given and given[name][1] <= truth <= given[name][2] for name, truth in outcome.hidden[effect].items())


def explained(outcome: Outcome) -> bool:
    """Whether an unlisted effect was called unexplained with the right dependence."""
    return outcome.extra is not None and outcome.unexplained == DEPENDS_ON[outcome.extra]


def halved(outcome: Outcome) -> bool:
    """Whether the correction removes half of the held-out error at every horizon, of what listed effects leave at best."""
    return min(outcome.cut, default=0.0) >= HALF


def world_halved(outcome: Outcome) -> bool:
    """Whether the correction removes half of the held-out error at every horizon, of the world without any effect."""
    return min(outcome.cut_world, default=0.0) >= HALF


def both_sides_seen(outcome: Outcome) -> bool:
    """Whether held-out runs can be predicted at all: enough others drive on either side of the edges, if there are any."""
    return min(outcome.sides, default=SEEN) >= SEEN


def as_demanded(outcome: Outcome) -> bool:
    """Whether a draw came out as the demands of its kind have it, intervals aside."""
    if outcome.kind == "unlisted":
        return explained(outcome) and world_halved(outcome) and halved(outcome)
    return all(found(outcome, name) for name in outcome.hidden) and (outcome.kind != "nulls" or not (outcome.named or outcome.unexplained))


def _rate(label: str, outcomes: Sequence[Outcome], hit: Callable[[Outcome], bool], demand: str) -> str:
    hits, trials = sum(map(hit, outcomes)), len(outcomes)
    low, high = wilson(hits, trials)
    return f"| {label} | {hits} of {trials} | {100 * low:.1f} to {100 * high:.1f} % | {demand} |"


def report(outcomes: Sequence[Outcome]) -> str:
    """The study as Markdown."""
    of = {kind: [outcome for outcome in outcomes if outcome.kind == kind] for kind in ("singles", "pairs", "nulls", "unlisted")}
    # an effect that stays unnamed has no interval and counts as not covered
    lines = [
        "# Effects hidden against effects named",
        "",
        "| what | draws | Wilson 95 % | demanded |",
        "| --- | --- | --- | --- |",
        _rate("one effect, named", of["singles"], lambda o: all(found(o, name) for name in o.hidden), "at least 95 of 100"),
        _rate("one effect, named by its own name", of["singles"], lambda o: o.hidden.keys() <= o.named.keys(), ""),
        _rate("one effect, named and nothing else", of["singles"], lambda o: all(found(o, n) for n in o.hidden) and len(o.named) == 1, ""),
        _rate(
            "one effect, truth in the interval", of["singles"], lambda o: all(covered(o, name) for name in o.hidden), "at least 90 of 100"
        ),
        _rate("two effects, both named", of["pairs"], lambda o: all(found(o, name) for name in o.hidden), "at least 85 of 100"),
        _rate("two effects, both truths in their intervals", of["pairs"], lambda o: all(covered(o, name) for name in o.hidden), ""),
        _rate("no effect, something named", of["nulls"], lambda o: bool(o.named), "at most 5 of 100"),
        _rate("no effect, something called unexplained", of["nulls"], lambda o: o.unexplained is not None, "at most 5 of 100"),
        _rate("listed effects, something called unexplained", [*of["singles"], *of["pairs"]], lambda o: o.unexplained is not None, ""),
        _rate("unlisted effect, unexplained with the right dependence", of["unlisted"], explained, "all"),
        _rate("unlisted effect, the world's held-out error at least halved at every horizon", of["unlisted"], world_halved, "all"),
        _rate("unlisted effect, even what listed effects leave of it at least halved", of["unlisted"], halved, "all"),
        _rate(
            "the same, where three runs or more drive on either side of its edges",
            [o for o in of["unlisted"] if both_sides_seen(o)],
            halved,
            "",
        ),
        _rate("unlisted effect, some listed effect named too", of["unlisted"], lambda o: bool(o.named), ""),
        _rate("calibration failed", outcomes, lambda o: o.error is not None, "0"),
        "",
    ]
    if outcomes:
        seconds = sorted(outcome.seconds for outcome in outcomes)
        lines += [f"One log took {seconds[len(seconds) // 2]:.1f} s (median), {seconds[-1]:.1f} s at most.", ""]
    lines += _confusion("One effect or none hidden", [*of["singles"], *of["nulls"], *of["unlisted"]])
    lines += _by_effect([*of["singles"], *of["pairs"]])
    lines += _unlisted(of["unlisted"])
    lines += _failures(outcomes)
    return "\n".join(lines)


def _ordered(names: Iterable[str]) -> list[str]:
    order = {name: place for place, name in enumerate(EFFECTS)}
    return sorted(set(names), key=lambda name: (order.get(name, len(order)), name))


def _confusion(title: str, outcomes: Sequence[Outcome]) -> list[str]:
    counts: Counter[tuple[str, str]] = Counter()
    totals: Counter[str] = Counter()
    for outcome in outcomes:
        row = outcome.extra or next(iter(outcome.hidden), NOTHING)
        totals[row] += 1
        counts.update((row, name) for name in outcome.named or [NOTHING])
    columns = _ordered(name for _, name in counts)
    lines = [f"## {title}: rows hidden, columns named", "", "| hidden | draws | " + " | ".join(columns) + " |"]
    lines.append("| --- " * (len(columns) + 2) + "|")
    cells = {row: " | ".join(str(counts[row, name] or "") for name in columns) for row in totals}
    return [*lines, *(f"| {row} | {totals[row]} | {cells[row]} |" for row in _ordered(totals)), ""]


def _by_effect(outcomes: Sequence[Outcome]) -> list[str]:
    lines = [
        "## Each effect, hidden alone or with another",
        "",
        "| effect | hidden | named | Wilson 95 % | truth in the interval, of those named |",
    ]
    lines.append("| --- | --- | --- | --- | --- |")
    for effect in _ordered(name for outcome in outcomes for name in outcome.hidden):
        having = [outcome for outcome in outcomes if effect in outcome.hidden]
        named = [outcome for outcome in having if found(outcome, effect)]
        low, high = wilson(len(named), len(having))
        right = sum(covered(outcome, effect) for outcome in named)
        lines.append(f"| {effect} | {len(having)} | {len(named)} | {100 * low:.0f} to {100 * high:.0f} % | {right} of {len(named)} |")
    return [*lines, ""]


def _unlisted(outcomes: Sequence[Outcome]) -> list[str]:
    lines = [
        "## Effects that are on no list",
        "",
        "| effect | seed | unexplained | depends on | error removed after 1, 5, 10 s | of what listed effects leave "
        "| runs beside, on it | named too |",
    ]
    lines.append("| --- " * 8 + "|")
    for o in sorted(outcomes, key=lambda o: (o.extra or "", o.key)):
        cuts = [", ".join(f"{100 * cut:.0f} %" for cut in given) for given in (o.cut_world, o.cut)]
        cells = (o.extra, _seed(o), o.channel or NOTHING, o.unexplained or "", *cuts, ", ".join(map(str, o.sides)), ", ".join(o.named))
        lines.append("| " + " | ".join(str(cell) for cell in cells) + " |")
    return [*lines, ""]


def _failures(outcomes: Sequence[Outcome]) -> list[str]:
    lines = ["## Draws that came out wrong", "", "| kind | seed | hidden | named | what |", "| --- | --- | --- | --- | --- |"]
    for o in sorted(outcomes, key=lambda o: o.key):
        what = "failed" if o.error else "" if as_demanded(o) else "not as demanded"
        if not what and not all(covered(o, name) for name in o.hidden):
            what = "truth outside the interval of " + ", ".join(name for name in o.hidden if not covered(o, name))
        if what:
            hidden, named = (", ".join(map(_with_numbers, given.items())) for given in (o.hidden, o.named))
            lines.append(f"| {o.kind} | {_seed(o)} | {o.extra or hidden or NOTHING} | {named or NOTHING} | {what} |")
    return [*lines, ""]


def _seed(outcome: Outcome) -> str:
    return outcome.key.split()[2] if len(outcome.key.split()) > 2 else outcome.key


def _with_numbers(entry: tuple[str, dict[str, float] | dict[str, tuple[float, float, float]]]) -> str:
    name, parameters = entry
    shown = [v if isinstance(v, float | int) else v[0] for key, v in parameters.items() if "." not in key]
    return f"{name} {' '.join(f'{value:.3g}' for value in shown)}"


def table(outcomes: Sequence[Outcome]) -> str:
    """One row for each parameter hidden, and for each named that was not, as CSV in SI units."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(["draw", "kind", "extra", "effect", "parameter", "hidden", "estimate", "low", "high", "found", "covered", "seconds"])
    for o in outcomes:
        for effect in [*o.hidden, *(name for name in o.named if name not in o.hidden)]:
            given, truth = intervals(o, effect), o.hidden.get(effect, {})
            for parameter in truth or given:
                value = given.get(parameter)
                inside = parameter in truth and value is not None and value[1] <= truth[parameter] <= value[2]
                flags = [int(effect in o.hidden and found(o, effect)), int(inside)]
                writer.writerow(
                    [o.key, o.kind, o.extra or "", effect, parameter, truth.get(parameter, ""), *(value or [""] * 3), *flags, o.seconds]
                )
        if not o.hidden and not o.named:
            writer.writerow([o.key, o.kind, o.extra or "", "", "", "", "", "", "", "", "", o.seconds])
    return text.getvalue()
