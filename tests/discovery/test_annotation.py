"""The annotation page in a real browser: what is answered by mouse and keys is in the file, and usable."""

from __future__ import annotations

import asyncio
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

from discovery.annotation.answers import KINDS, Answers, open_answers, question, read_labels
from discovery.annotation.clips import DatasetClips
from discovery.command import RunContext, run
from discovery.controllers import random_controllers
from discovery.errors import DiscoveryError
from discovery.representations.judgements import read_judgements
from discovery.rollouts.simulator import Simulator
from discovery.runs.run_folder import open_folder
from swarm_envs.simulation import Trajectories
from swarm_envs.worlds import load_world
from tests.browser import headless_chromium
from tests.discovery.tiny_run import tiny

pytest.importorskip("aiohttp", reason="aiohttp is absent: pip install swarm-envs[fleet]")
from discovery.annotation.server import AnnotationPage

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("annotated") / "run"
    run(tiny("steps=200", "representation=hand_crafted", f"folder={path}", simclr=False), given=True, context=RunContext())
    return path


@pytest.fixture(scope="module")
def browser(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Any]:
    with headless_chromium(tmp_path_factory.mktemp("chromium"), "--window-size=1280,900") as started:
        yield started


@contextmanager
def page(browser: Any, *words: str) -> Iterator[subprocess.Popen[str]]:
    """Serve and open it."""
    environment = {**os.environ, "PYTHONPATH": str(Path(__file__).parents[2])}
    command = [sys.executable, "-m", "discovery.annotation", *words, "--port", "0", "--name", "Ada"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=environment) as serving:
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


def test_keys_pressed_while_an_answer_is_on_its_way_are_kept(folder: Path, tmp_path: Path, browser: Any) -> None:
    path = tmp_path / "answers.json"
    with page(browser, "triples", str(folder), "--out", str(path), "--wanted", "5"):
        wait_for(browser, "0 of 5 answered")
        # the page's own requests are held up: every key comes before the answer to the first has arrived
        browser.execute_script("const fetched = window.fetch; window.fetch = async (...a) => { await new Promise(d => setTimeout(d, 300)); "
                               "return fetched(...a); };")  # fmt: skip
        for key in ("1", "2", "x", "0", "1"):
            press(browser, key)
        wait_for(browser, "4 of 5 answered")
    assert [entry["answer"] for entry in json.loads(path.read_text())["answers"]] == ["first", "second", "unsure", "first"]


class SlowClips:
    """Clips that take time, and tell which rows were asked for."""

    fingerprint = "slow"

    def __init__(self, world: str) -> None:
        self.simulator = Simulator(load_world(world), "disc", 4, 1)
        self.asked: list[int] = []

    def __len__(self) -> int:
        return 9

    def rollout(self, row: int) -> Trajectories:
        self.asked.append(row)
        time.sleep(0.1)
        return self.simulator.again(np.zeros(4), 0, row)


def test_the_next_question_is_prepared_while_this_one_is_looked_at(tmp_path: Path) -> None:
    clips = SlowClips("hero_plus")
    asking = AnnotationPage(clips, Answers(tmp_path / "answers.json", "triples", "slow", "Ada"), 2, 0)

    async def look() -> None:
        assert len((await asking._prepare(0))["rollouts"]) == 3
        deadline = time.monotonic() + 60
        while len(clips.asked) < 6 and time.monotonic() < deadline:
            await asyncio.sleep(0.05)  # looking, and asking for nothing
        assert len((await asking._prepare(1))["rollouts"]) == 3

    asyncio.run(look())
    assert sorted(clips.asked) == sorted(question("triples", 9, 0, 0) + question("triples", 9, 1, 0)), "simulated once each"


def test_a_clip_is_simulated_alone_and_is_that_of_its_batch() -> None:
    world, batch = load_world("hero_plus"), 70
    for engine in ("chipmunk", "disc"):
        simulator = Simulator(world, engine, 20, 1)
        controllers = random_controllers(world, batch, np.random.default_rng(0))
        together = simulator(controllers, 5)
        clips = DatasetClips(simulator, 3, batch, controllers, "x")
        for row in (0, 1, 69):
            alone = simulator.again(controllers[row], 5, row)
            assert len(alone) == 1
            assert np.array_equal(alone.poses[0], together.poses[row])
        assert len(clips.rollout(69)) == 1


def test_a_persons_triples_teach_a_representation(folder: Path, tmp_path: Path) -> None:
    path = tmp_path / "answers.json"
    videos = np.concatenate([part.tensors["videos"] for part in open_folder(folder).parts("dataset")])
    from discovery.rollouts.filming import fingerprint

    answers = open_answers(path, "triples", fingerprint(videos), "Ada")
    for number in range(12):
        answers.add(question("triples", 24, number, 0), ("first", "second")[number % 2])
    made = tmp_path / "run"
    overrides = ("steps=200", "representation=triplet", f"representation.judgements={path}", "representation.weights=random")
    run(
        tiny(*overrides, "representation.epochs=1", "representation.batch=6", f"folder={made}", simclr=False),
        given=True,
        context=RunContext(),
    )
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
