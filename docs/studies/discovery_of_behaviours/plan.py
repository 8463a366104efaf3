"""What a study runs, read from its YAML file."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml
from hydra import compose, initialize_config_dir
from hydra.errors import HydraException
from omegaconf.errors import OmegaConfBaseException

from discovery.command import CONFIGS, with_todays_names
from discovery.errors import DiscoveryError
from discovery.settings import Settings, read_settings

SIZES = ("quick", "paper")
"""How much training: ``quick`` takes minutes per run, ``paper`` every number of the paper."""
KEYS = {"all", "representations", "worlds", "worlds_with", "target", "starts", "test_set", "variants"}
"""What a plan file says."""
VARIANT_KEYS = {"name", "tries", "representation", "overrides"}
"""What it says of a variant."""


@dataclass(frozen=True)
class Entry:
    """Runs that differ in the seed alone."""

    name: str
    kind: str
    """``representations``, ``worlds`` or ``variants``."""
    overrides: tuple[str, ...]
    """Settings beside those that every run of the study has."""
    tries: str = ""
    """What a variant is to find out, in words."""


@dataclass(frozen=True)
class Planned:
    """One run."""

    entry: Entry
    seed: int
    path: Path
    words: tuple[str, ...]
    """The settings as one would write them on the command line."""
    settings: Settings


@dataclass(frozen=True)
class Plan:
    """A study."""

    size: str
    entries: tuple[Entry, ...]
    every: tuple[str, ...]
    """Settings of every run."""
    target: str
    """World that behaviours of the other worlds are tried in."""
    worlds_with: str
    """Representation whose runs in the target world stand beside those of the other worlds, and that they use."""
    starts: int
    """Attempts of each medoid in the target world."""
    per_class: int
    """Test rollouts of each behaviour."""
    most_draws: int
    """Rollouts simulated at most to find them."""

    def of(self, kind: str) -> list[Entry]:
        """Return the entries of one kind."""
        return [entry for entry in self.entries if entry.kind == kind]


def read_plan(path: Path, size: str) -> Plan:
    """Read a plan file.

    Raises:
        DiscoveryError: When it cannot be read, or does not say what a plan says.
    """
    try:
        content = yaml.safe_load(path.read_text(encoding="utf-8"))
    except (OSError, yaml.YAMLError) as error:
        raise DiscoveryError(f"{path}: not readable ({' '.join(str(error).split())[:200]})") from None
    if not isinstance(content, dict) or set(content) != KEYS:
        given = sorted(content) if isinstance(content, dict) else content
        raise DiscoveryError(f"{path}: given {given}, expected the keys {', '.join(sorted(KEYS))}")
    try:
        chosen = {name: _of_size(words, size) for name, words in content["representations"].items()}
        entries = [Entry(name, "representations", words) for name, words in chosen.items()]
        base = chosen[content["worlds_with"]]
        entries += [Entry(name, "worlds", (*base, f"world={name}")) for name in content["worlds"]]
        for each in content["variants"] or []:
            if unknown := sorted(map(str, set(each) - VARIANT_KEYS)):
                raise ValueError(f"variant {each.get('name')!r} says {unknown[0]!r}, expected {', '.join(sorted(VARIANT_KEYS))}")
            words = (*chosen[each.get("representation", content["worlds_with"])], *_of_size(each["overrides"], size))
            entries.append(Entry(each["name"], "variants", words, each.get("tries", "")))
        plan = Plan(
            size, tuple(entries), _of_size(content["all"], size), content["target"], content["worlds_with"], int(content["starts"]),
            int(content["test_set"]["per_class"]), int(content["test_set"]["most_draws"]),
        )  # fmt: skip
    except (KeyError, TypeError, AttributeError, ValueError) as error:
        raise DiscoveryError(f"{path}: not a plan ({type(error).__name__}: {error}); its comments say what stands where") from None
    names = [entry.name for entry in plan.entries]
    if twice := sorted({name for name in names if names.count(name) > 1}):
        raise DiscoveryError(f"{path}: {', '.join(twice)} named twice; every entry needs a name of its own")
    if odd := [name for name in names if not name.replace("_", "").replace("-", "").isalnum()]:
        raise DiscoveryError(f"{path}: name {odd[0]!r}, expected letters, digits, - and _: it names a folder")
    return plan


def _of_size(words: Any, size: str) -> tuple[str, ...]:
    """Return a list of settings, or that of a size where a mapping has one for each."""
    found = words[size] if isinstance(words, dict) else words
    if not isinstance(found, list) or not all(isinstance(word, str) for word in found):
        raise TypeError(f"expected a list of settings such as [search.distance=cosine], given {found!r}")
    return tuple(found)


def plan_runs(plan: Plan, entries: Sequence[Entry], seeds: int, out: Path, threads: int) -> list[Planned]:
    """Return the runs of entries, seed by seed, so that a study that is stopped has whole rows of few seeds rather than few rows.

    Raises:
        DiscoveryError: When an entry's settings are none of a run.
    """
    composed = {}
    with initialize_config_dir(str(CONFIGS), version_base="1.3"):
        for entry in entries:
            words = (*plan.every, *entry.overrides, f"threads={threads}")
            try:
                composed[entry.name] = words, read_settings(compose("config", with_todays_names(words)))
            except (HydraException, OmegaConfBaseException, DiscoveryError) as error:
                raise DiscoveryError(f"{entry.kind}, {entry.name}: {' '.join(str(error).split())[:300]}") from None
    planned = []
    for seed in range(seeds):
        for entry in entries:
            words, settings = composed[entry.name]
            path = out / entry.kind / entry.name / f"seed-{seed}"
            settings = dataclasses.replace(settings, seed=seed, folder=str(path))
            planned.append(Planned(entry, seed, path, (*words, f"seed={seed}"), settings))
    return planned


def choose(plan: Plan, only: Sequence[str] | None) -> list[Entry]:
    """Return the entries asked for by name or kind; all where none is asked for.

    Raises:
        DiscoveryError: On a name that no entry and no kind has.
    """
    if only is None:
        return list(plan.entries)
    known = [*dict.fromkeys(entry.kind for entry in plan.entries), *(entry.name for entry in plan.entries)]
    if unknown := [name for name in only if name not in known]:
        raise DiscoveryError(f"--only: no entry is named {unknown[0]!r}; there are {', '.join(known)}")
    return [entry for entry in plan.entries if entry.name in only or entry.kind in only]
