"""Every evaluation of a study's finished runs; one whose runs have not changed is left as it is."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Sequence
from functools import cached_property
from pathlib import Path
from typing import Any

from discovery.annotation.answers import read_labels
from discovery.evaluation.frequency import count_behaviours, write_frequency
from discovery.evaluation.groups import representation_name
from discovery.evaluation.maps import lay_out_maps, write_maps
from discovery.evaluation.representations import score_representations, write_representations
from discovery.evaluation.tables import write_json
from discovery.evaluation.transfer import transfer
from discovery.evaluation.transfer_tables import write_transfer
from discovery.progress import stage
from discovery.rollouts.simulator import Simulator
from discovery.rollouts.test_set import LabelledTestSet, draw_test_set
from discovery.runs.run_folder import read_manifest
from discovery.saved_run import Run, load_run
from docs.studies.discovery_of_behaviours.plan import Plan, Planned
from docs.studies.discovery_of_behaviours.running import finished
from docs.studies.discovery_of_behaviours.variants import judge_variants, write_variants
from swarm_envs.worlds import load_world

MADE_FROM = "made_from.json"
"""File beside an evaluation that says which runs it is of."""
ITERATIONS = 1000
"""Of t-SNE."""


class Evaluations:
    """The evaluations of a study, in folders of their own under ``out``.

    Args:
        plan: The study.
        planned: Its runs, finished or not.
        out: Where evaluations go.
        threads: Cores to use.
        labels: A person's labels of the test set, instead of the rules'.
    """

    def __init__(self, plan: Plan, planned: Sequence[Planned], out: Path, threads: int, labels: Path | None = None) -> None:
        self.plan, self.out, self.threads, self.labels = plan, out, threads, labels
        self.done = [each for each in planned if finished(each.path)]

    def make(self) -> None:
        """Make every evaluation that is not there, or whose runs have changed."""
        plan = self.plan
        seconds: dict[str, float] = {}
        answers = None if self.labels is None else hashlib.sha256(self.labels.read_bytes()).hexdigest()[:16]
        tested = {"per_class": plan.per_class, "most_draws": plan.most_draws, "labels": answers}
        compared = self.of("representations")
        moved = [*self.of("worlds"), *(each for each in compared if each.entry.name == plan.worlds_with)]
        varied = [*compared, *self.of("variants")]
        steps: tuple[tuple[str, list[Planned], dict[str, Any], Callable[[Path, Sequence[Planned]], None]], ...] = (
            ("representations", compared, tested, self._representations),
            ("tsne", compared, {**tested, "iterations": ITERATIONS}, self._maps),
            ("behaviours", compared, {}, self._behaviours),
            ("transfer", moved, {"target": plan.target, "starts": plan.starts}, self._transfer),
            ("variants", varied, tested, self._variants),
        )
        for name, runs, parameters, make in steps:
            source = {"parameters": parameters, "runs": {self._name(each): _identity(each.path) for each in runs}}
            folder = self.out / name
            if not runs:
                print(f"{name:<15} no finished run", flush=True)
            elif _read(folder / MADE_FROM) == source:
                print(f"{name:<15} is there", flush=True)
            else:
                with stage(f"{name:<15}", seconds) as line:
                    make(folder, runs)
                    write_json(folder / MADE_FROM, source)  # last: an evaluation that was stopped is made again
                    line.done = f"of {len(runs)} runs"

    def of(self, kind: str) -> list[Planned]:
        """Return the finished runs of a kind."""
        return [each for each in self.done if each.entry.kind == kind]

    @cached_property
    def _simulator(self) -> Simulator:
        settings = self.done[0].settings
        return Simulator(load_world(self.plan.target), settings.engine, settings.steps, self.threads)

    @cached_property
    def test(self) -> LabelledTestSet:
        """The test set, drawn when first asked for."""
        test = draw_test_set(self._simulator, self.plan.per_class, self.plan.most_draws, 0)
        return test if self.labels is None else test.relabelled(*read_labels(self.labels, test.fingerprint))

    def _groups(self, runs: Sequence[Planned]) -> dict[str, list[Run]]:
        groups: dict[str, list[Run]] = {}
        for each in runs:
            run = load_run(each.path)
            groups.setdefault(representation_name(run), []).append(run)
        return groups

    def _representations(self, folder: Path, runs: Sequence[Planned]) -> None:
        write_representations(folder, score_representations(self._groups(runs), self.test), self.test)

    def _maps(self, folder: Path, runs: Sequence[Planned]) -> None:
        write_maps(folder, lay_out_maps(self._groups(runs), self.test, ITERATIONS, 0), self.test)

    def _behaviours(self, folder: Path, runs: Sequence[Planned]) -> None:
        write_frequency(folder, count_behaviours(self._groups(runs), self._simulator))

    def _transfer(self, folder: Path, runs: Sequence[Planned]) -> None:
        found = transfer([load_run(each.path) for each in runs], self.plan.target, self.plan.starts, self.threads)
        write_transfer(folder, found, self.plan.target)

    def _variants(self, folder: Path, runs: Sequence[Planned]) -> None:
        rows = {entry.name: entry for entry in self.plan.entries}
        groups = {name: [each for each in runs if each.entry.name == name] for name in rows}
        judged = judge_variants({rows[name]: each for name, each in groups.items() if each}, self.test)
        write_variants(folder, judged, self.test)

    def _name(self, each: Planned) -> str:
        return f"{each.entry.kind}/{each.entry.name}/{each.path.name}"


def _identity(path: Path) -> list[Any]:
    manifest = read_manifest(path)
    assert manifest is not None, f"{path} is finished"
    return [manifest["run"], manifest["finished"]]


def _read(path: Path) -> Any:
    return json.loads(path.read_text(encoding="utf-8")) if path.exists() else None
