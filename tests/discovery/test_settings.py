"""Settings: each is said once in configs, keeps its earlier names, and tells a run from others whatever its order."""

from __future__ import annotations

import dataclasses
import random
import re
import shutil
import sys
from pathlib import Path
from typing import Any

import pytest
import yaml
from omegaconf import MISSING, OmegaConf

from discovery import load_run
from discovery.command import CONFIGS, RunContext, main, run
from discovery.errors import DiscoveryError
from discovery.runs.run_folder import CONFIG, open_folder
from discovery.settings import REPRESENTATIONS, Settings, flat, identity
from discovery.settings.former_names import KEYS, rename_keys, rename_words
from tests.discovery.stopping import run_until
from tests.discovery.tiny_run import tiny

GROUPS = {path.parent.name: sorted(path.parent.glob("*.yaml")) for path in CONFIGS.glob("*/*.yaml")}


@pytest.mark.parametrize("group", [name for name in GROUPS if name != "experiment"])
def test_a_setting_is_explained_in_one_place(group: str) -> None:
    explained: dict[str, list[str]] = {}
    for path in GROUPS[group] + (GROUPS["shared"] if group == "representation" else []):
        for key in re.findall(r"^(\w+):[^#\n]*#", path.read_text(encoding="utf-8"), re.M):
            explained.setdefault(key, []).append(path.name)
    kinds = {"learning_rate", "batch"}  # what they count is each method's own
    assert not {key: files for key, files in explained.items() if len(files) > 1 and key not in kinds}


def neutral_values(part: Any, prefix: str = "") -> dict[str, Any]:
    found: dict[str, Any] = {}
    for field in dataclasses.fields(part):
        value = getattr(part, field.name)
        if dataclasses.is_dataclass(value):
            found |= neutral_values(value, f"{prefix}{field.name}.")
        elif field.default not in (dataclasses.MISSING, MISSING):
            found[prefix + field.name] = field.default
    return found


@pytest.mark.parametrize("kind", ["simclr", "triplet", "imagenet", "random", "hand_crafted"])
def test_what_a_new_run_takes_by_default_is_what_an_earlier_run_had_that_lacks_the_setting(kind: str) -> None:
    settings = tiny(f"representation={kind}", "dataset.videos=6000", simclr=False)
    values = flat(settings)
    assert {key: values[key] for key in neutral_values(settings)} == neutral_values(settings)


def test_every_setting_stands_in_configs() -> None:
    words = {key for paths in GROUPS.values() for path in paths for key in yaml.safe_load(path.read_text(encoding="utf-8"))}
    parts = [
        *REPRESENTATIONS.values(),
        *(field.default_factory for field in dataclasses.fields(Settings) if callable(field.default_factory)),
    ]
    assert {field.name for part in parts if dataclasses.is_dataclass(part) for field in dataclasses.fields(part)} <= words


def test_the_order_of_keys_changes_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "run"
    words = ("representation=hand_crafted", "tracker=none", "engine=disc")
    run_until("search/00001", tiny(*words, f"folder={path}", simclr=False), monkeypatch)
    content = OmegaConf.to_container(OmegaConf.load(path / CONFIG))
    assert isinstance(content, dict)
    mixed = list(content.items())
    random.Random(1).shuffle(mixed)
    assert list(dict(mixed)) != list(content)
    (path / CONFIG).write_text(yaml.safe_dump(dict(mixed), sort_keys=False))
    run(tiny(f"resume={path}"), given=False, context=RunContext())
    assert len(load_run(path).archive) == 24


def test_another_value_is_another_run(tmp_path: Path) -> None:
    names = {identity(tiny(*words)) for words in ((), ("seed=1",), ("search.mutation=0.2",), ("clustering.sample=99",))}
    assert len(names) == 4
    assert identity(tiny("runs=elsewhere")) == identity(tiny())


def test_a_folder_of_an_earlier_version_whose_config_was_changed_is_refused_as_one_of_this_version_is(tmp_path: Path) -> None:
    path = tmp_path / "run"
    shutil.copytree(Path(__file__).parent / "earlier_runs" / "stopped", path)
    assert open_folder(path).settings.clustering.wccn
    (path / CONFIG).write_text((path / CONFIG).read_text().replace("seed: 0", "seed: 1"))
    with pytest.raises(DiscoveryError, match=r"config\.yaml: was changed since the run began"):
        open_folder(path)


def test_a_folder_of_a_later_version_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "run"
    shutil.copytree(Path(__file__).parent / "earlier_runs" / "stopped", path)
    manifest = path / "manifest.json"
    manifest.write_text(manifest.read_text().replace('"status"', '"identity_version": 3, "status"'))
    with pytest.raises(DiscoveryError, match="of a later version"):
        open_folder(path)


def test_earlier_names_on_the_command_line_are_taken_and_told(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["clustering.by_chance=true", "representation=hand_crafted_roots", "dataset.starts=1"]
    assert rename_words(words)[0] == ["clustering.wccn=true", "representation=hand_crafted_square_root", "dataset.starts=1"]
    monkeypatch.setattr(sys, "argv", ["discovery", *words])
    assert main() == 1
    said = capsys.readouterr().err.splitlines()
    assert said[0] == "discovery: clustering.by_chance is now clustering.wccn; the earlier name will go with the next version"
    assert said[1].startswith("discovery: representation=hand_crafted_roots is now representation=hand_crafted_square_root; ")
    assert said[2].startswith("discovery: clustering.wccn: needs dataset.starts of 2 or more")
    assert len(said) == 3


def test_an_earlier_choice_is_taken_in_a_sweep_too_and_other_words_stay_as_they_are() -> None:
    sweep, today = "representation=simclr,hand_crafted_roots", "representation=simclr,hand_crafted_square_root"
    others = ["-m", "search.include=[[0.1,0,0.05,1]]", "name=a=b", "resume="]
    assert rename_words([*others, sweep]) == (
        [*others, today],
        [f"{sweep} is now {today}; the earlier name will go with the next version"],
    )


@pytest.mark.parametrize("former", KEYS)
def test_each_earlier_key_is_taken_on_the_command_line_and_in_a_config(former: str) -> None:
    group, name = KEYS[former].split(".")
    told = f"{former} is now {KEYS[former]}; the earlier name will go with the next version"
    assert rename_words([f"{former}=1", "seed=1"]) == ([f"{KEYS[former]}=1", "seed=1"], [told])
    assert rename_words([f"++{former}=1"])[0] == [f"++{KEYS[former]}=1"]
    config = OmegaConf.create({group: {former.split(".")[1]: 1, name: 0}})
    assert rename_keys(config) == [told]
    assert config == {group: {name: 1}}


def test_earlier_names_in_a_persons_own_config_are_taken_and_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    own = tmp_path / "experiment" / "mine.yaml"
    own.parent.mkdir()
    own.write_text("# @package _global_\nname: mine\nclustering: {by_chance: true}\n")
    monkeypatch.setattr(sys, "argv", ["discovery", "--config-dir", str(tmp_path), "experiment=mine"])
    assert main() == 1
    said = capsys.readouterr().err.splitlines()
    assert said[0] == "discovery: clustering.by_chance is now clustering.wccn; the earlier name will go with the next version"
    assert said[1].startswith("discovery: clustering.wccn: needs dataset.starts of 2 or more")
    assert len(said) == 2


def test_earlier_names_in_a_config_are_taken() -> None:
    settings = load_run(Path(__file__).parent / "earlier_runs" / "finished").settings
    assert (settings.clustering.wccn, settings.clustering.repeatable, settings.representation.square_root) == (True, 2, True)
    assert set(KEYS.values()) <= {*flat(settings), "representation.metrics_square_root"}
