"""Pairs of views: which two videos they are made of, and what an encoder learns from two runs of one controller."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from discovery.errors import DiscoveryError
from discovery.evaluation.triplets import confusion
from discovery.randomness import generator
from discovery.representations.pairs import Pairs
from discovery.representations.simclr import fit_simclr
from discovery.representations.videos import VideoRepresentation
from discovery.rollouts.dataset import Dataset, make_dataset
from discovery.rollouts.simulator import Simulator
from discovery.runs.run_folder import make_folder
from swarm_envs.worlds import load_world
from tests.discovery.tiny_run import tiny


@given(starts=st.integers(1, 5), batch=st.integers(2, 7), batches=st.integers(1, 4), rest=st.integers(0, 1), seed=st.integers(0, 99))
def test_no_controller_comes_twice_in_a_batch_and_no_video_is_a_first_view_twice_in_an_epoch(
    starts: int, batch: int, batches: int, rest: int, seed: int
) -> None:
    pairs = Pairs(starts * (batch * batches + rest), starts, batch)
    assert pairs.steps == starts * batches
    for epoch in (0, 3):
        firsts = []
        for number in range(epoch * pairs.steps, (epoch + 1) * pairs.steps):
            first, second = pairs(seed, number)
            assert len(first) == len(second) == batch
            np.testing.assert_array_equal(first // starts, second // starts)
            assert len(set(first // starts)) == batch
            assert (first != second).all() or starts == 1
            firsts += first.tolist()
        assert len(set(firsts)) == len(firsts) == starts * batch * batches


def test_with_several_starts_every_other_start_can_be_the_partner() -> None:
    pairs = Pairs(8, 4, 2)
    partners = {(a % 4, b % 4) for number in range(200) for a, b in zip(*pairs(0, number), strict=True)}
    assert partners == {(a, b) for a in range(4) for b in range(4) if a != b}


def test_with_one_start_both_views_are_of_one_video_in_the_order_that_earlier_runs_had() -> None:
    first, second = Pairs(25, 1, 6)(7, 4 * 3 + 2)
    np.testing.assert_array_equal(first, generator(7, "epoch", 3).permutation(25)[12:18])
    np.testing.assert_array_equal(first, second)


def test_a_dataset_has_each_controller_as_often_as_asked_each_time_from_another_start(tmp_path: Path) -> None:
    settings = tiny("dataset.starts=3", "representation.batch=8", f"folder={tmp_path / 'run'}")
    with make_folder(settings) as folder:
        dataset = make_dataset(folder, Simulator(load_world("hero_plus"), "chipmunk", 40, 1))
    groups = dataset.controllers.reshape(8, 3, 4)
    assert (groups == groups[:, :1]).all()
    assert len(np.unique(dataset.controllers, axis=0)) == 8
    assert len(np.unique(dataset.videos.reshape(24, -1), axis=0)) == 24


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("dataset.starts=5",), r"dataset.videos: given 24, expected a multiple of dataset.starts, 5"),
        (("dataset.starts=8",), r"dataset.chunk: given 12, expected a multiple of dataset.starts, 8"),
        (("dataset.starts=3",), r"representation.batch: given 12, expected at most the controllers of the dataset.*, 8"),
        (("dataset.starts=0",), r"dataset.starts: given 0, expected a number from 1"),
    ],
)
def test_numbers_that_do_not_go_together_are_refused_in_one_line(words: tuple[str, ...], message: str) -> None:
    with pytest.raises(DiscoveryError, match=message):
        tiny(*words)


def test_what_differs_between_two_starts_counts_for_less_and_what_does_not_counts_for_more(tmp_path: Path) -> None:
    """A square whose side is the controller's and whose brightness, which is easier to see, is chance."""
    chance = np.random.default_rng(1)
    sides = np.repeat(chance.permutation(np.repeat([3, 8], 40)), 2)
    brightness = chance.choice([40, 255], 160)
    videos = np.zeros((160, 3, 32, 32), dtype=np.uint8)
    for video, side, bright in zip(videos, sides, brightness, strict=True):
        x, y = chance.integers(0, 32 - side, 2)
        video[:, y : y + side, x : x + side] = bright
    dataset = Dataset(np.zeros((160, 4)), videos, np.zeros((160, 5)), sides.astype(str))
    by_side, by_brightness = {}, {}
    for starts in (1, 2):
        settings = tiny(
            f"folder={tmp_path / str(starts)}", "dataset.videos=160", "dataset.chunk=160", "dataset.size=32", f"dataset.starts={starts}",
            "seed=1", "representation.batch=20", "representation.epochs=8", "representation.learning_rate=10",
            "representation.temperature=0.2", "representation.normalise=true", "representation.checkpoint_seconds=60",
        )  # fmt: skip
        with make_folder(settings) as folder:
            found = fit_simclr(folder, dataset).representation
        assert isinstance(found, VideoRepresentation)
        embeddings = found.encoder(videos)
        by_side[starts] = np.diag(confusion(embeddings, sides.astype(str), ["3", "8"])).mean()
        by_brightness[starts] = np.diag(confusion(embeddings, brightness.astype(str), ["40", "255"])).mean()
    assert by_brightness[1] > by_side[1] + 0.1, "brightness is easier to see"
    assert by_brightness[2] < by_brightness[1] - 0.05
    assert by_side[2] > by_side[1] + 0.05
