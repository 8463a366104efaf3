"""Names that settings had in earlier versions: accepted in run folders, configs and on the command line, for one version."""

from __future__ import annotations

from collections.abc import Sequence

from omegaconf import DictConfig, OmegaConf

KEYS = {
    "representation.roots": "representation.square_root",
    "representation.metrics_roots": "representation.metrics_square_root",
    "clustering.by_chance": "clustering.wccn",
    "clustering.stable": "clustering.repeatable",
}
"""Today's key of each earlier one."""
CHOICES = {
    "representation=hand_crafted_roots": "representation=hand_crafted_square_root",
}
"""Today's choice of a config group for each earlier one."""


def rename_keys(config: DictConfig) -> list[str]:
    """Give the values of earlier keys to today's, in place; return a line for each."""
    told = []
    for former, key in KEYS.items():
        group, name = former.split(".")
        part = config.get(group)
        if isinstance(part, DictConfig) and name in part:
            OmegaConf.set_struct(part, False)
            OmegaConf.update(config, key, part.pop(name))
            told.append(_say(former, key))
    return told


def rename_words(words: Sequence[str]) -> tuple[list[str], list[str]]:
    """Return the words of a command line with today's names, and a line for each that has changed."""
    renamed, told = [], []
    for former in words:
        word = _rename(former)
        renamed.append(word)
        if word != former:
            keys = former.partition("=")[0], word.partition("=")[0]
            told.append(_say(former, word) if keys[0] == keys[1] else _say(*keys))
    return renamed, told


def _say(former: str, today: str) -> str:
    return f"{former} is now {today}; the earlier name will go with the next version"


def _rename(word: str) -> str:
    key, equals, value = word.partition("=")
    plain = key.lstrip("+")
    if plain in KEYS:
        return f"{key[: len(key) - len(plain)]}{KEYS[plain]}{equals}{value}"
    choices = [f"{key}={choice}" for choice in value.split(",")]  # a sweep names several
    return key + equals + ",".join(CHOICES.get(choice, choice).removeprefix(f"{key}=") for choice in choices)
