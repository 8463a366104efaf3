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
    renamed = [_rename(word) for word in words]
    told = [
        _say(former, word) if word in CHOICES.values() else _say(former.partition("=")[0], word.partition("=")[0])
        for former, word in zip(words, renamed, strict=True)
        if former != word
    ]
    return renamed, told


def _say(former: str, today: str) -> str:
    return f"{former} is now {today}; the earlier name will go with the next version"


def _rename(word: str) -> str:
    key, equals, value = word.partition("=")
    plain = key.lstrip("+")
    if plain in KEYS:
        return f"{key[: len(key) - len(plain)]}{KEYS[plain]}{equals}{value}"
    return CHOICES.get(word, word)
