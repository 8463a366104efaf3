"""The annotation page in a real browser: what is answered by mouse and keys is in the file, and usable."""

from __future__ import annotations

import json
import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from discovery.annotation.answers import KINDS, open_answers, question, read_labels
from discovery.command import CONFIGS, Opened, run
from discovery.errors import DiscoveryError
from discovery.representations.judgements import read_judgements
from discovery.runs.run_folder import open_folder
from tests.browser import headless_chromium
from tests.discovery.tiny_run import tiny

pytest.importorskip("aiohttp", reason="aiohttp is absent: pip install swarm-envs[deployment]")


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("annotated") / "run"
    run(tiny("steps=200", "representation=hand_crafted", f"folder={path}", simclr=False), given=True, opened=Opened())
    return path


@pytest.fixture(scope="module")
def browser(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Any]:
    with headless_chromium(tmp_path_factory.mktemp("chromium"), "--window-size=1280,900") as started:
        yield started


@contextmanager
def page(browser: Any, *words: str) -> Iterator[subprocess.Popen[str]]:
    """Serve and open it."""
    environment = {**os.environ, "PYTHONPATH": str(CONFIGS.parent)}
    command = [sys.executable, "-m", "discovery.annotation", *words, "--port", "0", "--name", "Ada"]
    serving = subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=environment)
    assert serving.stdout is not None
    try:
        said = serving.stdout.readline()
        found = re.match(r"(http://127\.0\.0\.1:\d+)", said)
        assert found, f"said {said!r} instead of an address"
        browser.get(found[1])
        yield serving
    finally:
        serving.send_signal(signal.SIGINT)
        serving.wait(60)


def wait_for(browser: Any, text: str) -> None:
    deadline = time.monotonic() + 60
    while text not in browser.find_element("tag name", "body").text:
        assert time.monotonic() < deadline, f"{text!r} is not in: {browser.find_element('tag name', 'body').text}"
        time.sleep(0.05)


def press(browser: Any, key: str) -> None:
    browser.find_element("tag name", "body").send_keys(key)


def test_triples_are_judged_by_mouse_and_keys_taken_back_and_gone_on_with(folder: Path, tmp_path: Path, browser: Any) -> None:
    path = tmp_path / "answers.json"
    words = ("triples", str(folder), "--out", str(path), "--wanted", "4")
    with page(browser, *words):
        wait_for(browser, "0 of 4 answered")
        assert len(browser.find_elements("css selector", "#shown canvas")) == 3
        browser.find_element("css selector", "[data-answer=second]").click()
        wait_for(browser, "1 of 4 answered")
        press(browser, "1")
        wait_for(browser, "2 of 4 answered")
        press(browser, "0")
        wait_for(browser, "3 of 4 answered")
        press(browser, "\ue003")  # backspace
        wait_for(browser, "2 of 4 answered")
    assert [entry["answer"] for entry in json.loads(path.read_text())["answers"]] == ["second", "first"]
    with page(browser, *words) as serving:
        wait_for(browser, "2 of 4 answered")
        press(browser, "0")
        wait_for(browser, "3 of 4 answered")
        press(browser, "2")
        wait_for(browser, "Done, thank you")
        assert serving.wait(60) == 0
    videos = np.concatenate([part.tensors["videos"] for part in open_folder(folder).parts("dataset")])
    found = read_judgements(path, videos)
    asked = [question("triples", 24, number, 0) for number in range(4)]
    turned = [(asked[0], (0, 2, 1)), (asked[1], (0, 1, 2)), (asked[3], (0, 2, 1))]
    assert found.triples.tolist() == [[rows[k] for k in order] for rows, order in turned]
    assert found.annotators == ("Ada",)
    logs = [entry for entry in browser.get_log("browser") if "favicon" not in entry["message"]]
    assert not logs, logs


def test_a_persons_triples_teach_a_representation(folder: Path, tmp_path: Path) -> None:
    path = tmp_path / "answers.json"
    videos = np.concatenate([part.tensors["videos"] for part in open_folder(folder).parts("dataset")])
    from discovery.rollouts.filming import fingerprint

    answers = open_answers(path, "triples", fingerprint(videos), "Ada")
    for number in range(12):
        answers.add(question("triples", 24, number, 0), ("first", "second")[number % 2])
    made = tmp_path / "run"
    overrides = ("steps=200", "representation=triplet", f"representation.judgements={path}", "representation.weights=random")
    run(tiny(*overrides, "representation.epochs=1", "representation.batch=6", f"folder={made}", simclr=False), given=True, opened=Opened())
    origin = json.loads((made / "metrics.json").read_text())["representation"]["origin"]
    assert "12 answers of Ada" in origin
    assert "simulated" not in origin


def test_test_rollouts_are_labelled_and_shown_one_at_a_time(folder: Path, tmp_path: Path, browser: Any) -> None:
    path = tmp_path / "labels.json"
    with page(browser, "labels", str(folder), "--out", str(path), "--per-class", "10", "--most-draws", "1500", "--wanted", "2"):
        wait_for(browser, "0 of 2 answered")
        assert len(browser.find_elements("css selector", "#shown canvas")) == 1
        assert [b.get_attribute("data-answer") for b in browser.find_elements("css selector", "#options button")] == list(KINDS["labels"])
        press(browser, "4")
        wait_for(browser, "1 of 2 answered")
        press(browser, "0")
        wait_for(browser, "Done, thank you")
    content = json.loads(path.read_text())
    labels, name = read_labels(path, content["dataset"])
    assert (list(labels.values()), name) == (["milling"], "Ada")


def test_every_test_rollout_is_asked_once_before_any_is_asked_again() -> None:
    rows = [question("labels", 30, number, 3)[0] for number in range(60)]
    assert sorted(rows[:30]) == sorted(rows[30:]) == list(range(30))
    assert rows[:30] != sorted(rows[:30])
    for number in range(50):
        assert len(set(question("triples", 5, number, 0))) == 3


def test_answers_about_other_clips_by_others_or_damaged_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "answers.json"
    answers = open_answers(path, "labels", "abc", "Ada")
    answers.add([3], "milling")
    answers.add([4], "unsure")
    assert read_labels(path, "abc") == ({3: "milling"}, "Ada")
    with pytest.raises(DiscoveryError, match="expected aggregation, cyclic pursuit"):
        answers.add([5], "flocking")
    for kind, fingerprint, name, what in (
        ("triples", "abc", "Ada", "kind"),
        ("labels", "x", "Ada", "dataset"),
        ("labels", "abc", "Bo", "annotators"),
    ):
        with pytest.raises(DiscoveryError, match=f"has {what} .*choose another file"):
            open_answers(path, kind, fingerprint, name)
    with pytest.raises(DiscoveryError, match="expected labels of x"):
        read_labels(path, "x")
    path.write_text(path.read_text().replace("milling", "flocking"))
    with pytest.raises(DiscoveryError, match="no answers can be read"):
        read_labels(path, "abc")
