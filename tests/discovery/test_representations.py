"""Every representation through the whole pipeline, and judgements that triplet learning learns from."""

from __future__ import annotations

import dataclasses
import json
import shutil
from pathlib import Path

import numpy as np
import pytest
import torch

from discovery import load_run
from discovery.command import RunContext, run
from discovery.errors import DiscoveryError
from discovery.representations import METHODS, fit
from discovery.representations.judgements import Judgements, read_judgements, simulate_annotator, write_judgements
from discovery.representations.triplet import JUDGEMENTS, train_triplet
from discovery.representations.videos import CONCATENATION, WHITENING, VideoRepresentation
from discovery.rollouts.dataset import Dataset, make_dataset
from discovery.rollouts.filming import film, fingerprint
from discovery.rollouts.simulator import Simulator
from discovery.runs.run_folder import ARCHIVE, ENCODER, make_folder, open_folder
from discovery.settings import REPRESENTATIONS, Settings, to_yaml
from swarm_envs.metrics import hand_crafted
from swarm_envs.rendering import trails, videos
from swarm_envs.worlds import load_world
from tests.discovery.stopping import run_until
from tests.discovery.tiny_run import tiny

pytestmark = pytest.mark.slow

SMALL = {
    "hand_crafted": (),
    "hand_crafted_standardised": (),
    "hand_crafted_square_root": (),
    "random": (),
    "triplet": (
        "representation.weights=random", "representation.answers=48", "representation.batch=24", "representation.epochs=2",
        "representation.checkpoint_seconds=0",
    ),
}  # fmt: skip
"""Representations beside SimCLR, which the other tests take, and what makes each tiny."""


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    folders = {name: tmp_path_factory.mktemp("representations") / name for name in SMALL}
    for name, path in folders.items():
        run(small(name, f"folder={path}"), given=True, context=RunContext())
    return folders


def small(name: str, *overrides: str) -> Settings:
    return tiny("steps=120", f"representation={name}", *SMALL[name], *overrides, simclr=False)


def test_every_method_has_its_settings() -> None:
    assert set(METHODS) == set(REPRESENTATIONS)


def test_the_raw_metrics_are_the_embeddings_of_the_hand_crafted_representation(runs: dict[str, Path]) -> None:
    archive = load_run(runs["hand_crafted"]).archive
    np.testing.assert_array_equal(archive.embeddings, archive.metrics.astype(np.float32))


def test_of_squared_lengths_the_roots_are_taken_where_that_is_asked(runs: dict[str, Path]) -> None:
    archive = load_run(runs["hand_crafted_square_root"]).archive
    speed, momentum, variance, scatter, rotation = archive.metrics.T
    expected = np.column_stack([speed, momentum, np.sqrt(variance), np.sqrt(scatter), rotation])
    np.testing.assert_allclose(archive.embeddings, expected, rtol=1e-6)


def test_standardised_metrics_have_mean_0_and_spread_1_over_the_dataset(runs: dict[str, Path]) -> None:
    raw, standard = load_run(runs["hand_crafted"]).archive, load_run(runs["hand_crafted_standardised"]).archive
    # the first generation is the same for both: one shift and one scale a metric take it from one to the other
    first = raw.generation == 0
    for k in range(5):
        a, b = raw.metrics[first, k], standard.embeddings[first, k]
        np.testing.assert_allclose(np.corrcoef(a, b)[0, 1], 1.0, atol=1e-5)
        assert 0.3 < b.std() < 3.0, "eight other random controllers spread about as the dataset's"


def test_encoders_that_are_not_trained_say_so_and_give_512_numbers(runs: dict[str, Path]) -> None:
    found = load_run(runs["random"])
    assert found.embeddings.shape[1] == 512
    assert "was not trained" in json.loads((runs["random"] / "metrics.json").read_text())["representation"]["origin"]
    assert "was not trained" in (runs["random"] / "report.html").read_text()


def test_what_a_simulated_annotator_taught_is_marked_as_such_wherever_it_is_shown(runs: dict[str, Path]) -> None:
    for name in ("metrics.json", JUDGEMENTS, "report.html"):
        assert "simulated annotator with 10 % errors" in (runs["triplet"] / name).read_text(), name


def test_triplet_learning_that_was_stopped_ends_with_the_same_bits(
    runs: dict[str, Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "stopped"
    run_until("step-0000003", small("triplet", f"folder={path}"), monkeypatch)
    assert (path / "training" / "step-0000002.safetensors").exists()
    run(small("triplet", f"resume={path}"), given=False, context=RunContext())
    for name in (ARCHIVE, ENCODER):
        assert (path / name).read_bytes() == (runs["triplet"] / name).read_bytes()


WHITENED = (
    "representation.symmetries=4", "representation.whiten=pca", "representation.whiten_variance=0.9", "representation.normalise=true",
    "representation.metrics=2", "representation.metrics_square_root=true", "dataset.trail=true", "dataset.frames=2",
)  # fmt: skip


@pytest.fixture(scope="module")
def whitened(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("representations") / "whitened"
    run(small("random", f"folder={path}", *WHITENED), given=True, context=RunContext())
    return path


def test_a_run_with_every_option_is_read_back_with_the_embeddings_that_it_had(whitened: Path) -> None:
    torch.set_num_threads(1)
    found = load_run(whitened)
    first = found.archive.generation == 0
    rollouts = Simulator(load_world("hero_plus"), "chipmunk", 120, 1)(found.archive.controllers[first], int(found.archive.world_seed[0]))
    assert found.representation.dimension == found.embeddings.shape[1] < 24, "fewer components than videos"
    np.testing.assert_array_equal(found.representation.embed(rollouts), found.embeddings[first])
    seen, metrics = found.embeddings[:, :-5], found.embeddings[:, -5:]
    lengths = np.linalg.norm(seen, axis=1)
    np.testing.assert_allclose(lengths, lengths[0], rtol=1e-5)
    raw = hand_crafted(rollouts)
    raw[:, 2:4] **= 0.5
    ratio = raw / metrics[first]
    np.testing.assert_allclose(ratio, ratio[0, 0], rtol=1e-5)


def test_metrics_beside_an_embedding_vary_over_the_dataset_as_much_as_their_weight_says(whitened: Path) -> None:
    folder = open_folder(whitened)
    dataset = make_dataset(folder, Simulator(load_world("hero_plus"), "chipmunk", 120, 1))
    found = load_run(whitened).representation
    assert isinstance(found, VideoRepresentation)
    assert found.concatenated is not None
    joined = found.concatenated(found.encoder(dataset.videos), dataset.metrics)
    seen, metrics = (np.sqrt(part.var(axis=0).sum()) for part in (joined[:, :-5], joined[:, -5:]))
    assert seen == pytest.approx(1.0, rel=1e-4)
    assert metrics == pytest.approx(2.0, rel=1e-4)


def test_a_trail_is_drawn_into_the_pictures_that_an_encoder_sees(whitened: Path) -> None:
    found = load_run(whitened)
    rollouts = Simulator(load_world("hero_plus"), "chipmunk", 120, 1)(found.archive.controllers[:2], 0)
    np.testing.assert_array_equal(film(rollouts, found.settings.dataset), np.maximum(videos(rollouts, 2), trails(rollouts, 2)))


@pytest.mark.parametrize("file", [WHITENING, CONCATENATION])
def test_a_run_that_was_stopped_before_its_scales_were_saved_ends_with_the_same_bits(
    file: str, whitened: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "stopped"
    run_until(file, small("random", f"folder={path}", *WHITENED), monkeypatch)
    assert (path / ENCODER).exists()
    run(small("random", f"resume={path}", *WHITENED), given=False, context=RunContext())
    for name in (ARCHIVE, ENCODER, WHITENING, CONCATENATION):
        assert (path / name).read_bytes() == (whitened / name).read_bytes()


@pytest.mark.parametrize("file", [WHITENING, CONCATENATION])
def test_damaged_scales_are_refused_and_computed_again_by_a_run_but_not_by_a_reader(
    file: str, whitened: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "damaged"
    shutil.copytree(whitened, path)
    content = (path / file).read_bytes()
    (path / file).write_bytes(content[:-1] + bytes([content[-1] ^ 1]))
    with pytest.raises(DiscoveryError, match=rf"{file}: its checksum does not match"):
        _ = load_run(path).representation
    folder = open_folder(path)
    fit(folder, make_dataset(folder, Simulator(load_world("hero_plus"), "chipmunk", 120, 1)))
    assert "its checksum does not match its content; making it again" in capsys.readouterr().err
    assert (path / file).read_bytes() == content
    (path / file).unlink()
    with pytest.raises(DiscoveryError, match=rf"{file}: there is none"):
        _ = load_run(path).representation


def test_settings_that_came_later_are_not_written_while_neutral_so_that_earlier_runs_keep_their_identity() -> None:
    for name in ("simclr_quick", "triplet", "random"):
        neutral = to_yaml(tiny(f"representation={name}", "dataset.videos=100", simclr=False))
        for later in ("symmetries", "whiten", "trail", "metrics", "starts"):
            assert later not in neutral
    config = to_yaml(small("random", *WHITENED))
    for line in ("symmetries: 4", "whiten: pca", "whiten_variance: 0.9", "metrics: 2.0", "trail: true"):
        assert line in config


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ("representation.symmetries=2", "given 2, expected 1 or 4 or 8"),
        ("representation.whiten=zca", "given 'zca', expected none or standardise or pca"),
        ("representation.whiten_variance=0", r"given 0\.0, expected a number from 0\.01 to 1"),
        ("representation.metrics=-1", r"given -1\.0, expected a number"),
        ("dataset.trail=maybe", "dataset.trail"),
    ],
)
def test_options_that_there_are_not_are_refused_in_one_line(given: str, message: str) -> None:
    with pytest.raises(DiscoveryError, match=message):
        tiny(given)


def test_triplet_learning_brings_together_what_is_judged_alike(tmp_path: Path) -> None:
    """Bright squares, each at its own place, in a corner of one of two sizes; size is what the judge goes by."""
    generator = np.random.default_rng(4)
    labels = np.array(["large", "small"])[np.arange(60) % 2]
    videos = np.zeros((60, 3, 64, 64), dtype=np.uint8)
    for video, label in zip(videos, labels, strict=True):
        x, y = generator.integers(20, 40, 2)
        half = 10 if label == "large" else 4
        video[:, y - half : y + half, x - half : x + half] = generator.integers(60, 255)
    dataset = Dataset(np.zeros((60, 4)), videos, np.zeros((60, 5)), labels)
    settings = tiny(
        f"folder={tmp_path / 'learning'}", "representation=triplet", "representation.weights=random", "representation.epochs=6",
        "representation.batch=30", "representation.margin=0.5", "representation.normalise=true", simclr=False,
    )  # fmt: skip
    triples = simulate_annotator(labels, 90, 0.0, generator)
    with make_folder(settings) as folder:
        training = train_triplet(folder, dataset, Judgements(triples, ("a test",), fingerprint(videos)), None)
    assert np.mean(training.losses[-3:]) < 0.5 * np.mean(training.losses[:3])


def test_the_simulated_annotator_goes_by_the_labels_and_errs_at_its_rate() -> None:
    labels = np.array(["a", "b", "c", "c"])[np.random.default_rng(0).integers(4, size=300)]
    for rate in (0.0, 0.2):
        triples = simulate_annotator(labels, 4000, rate, np.random.default_rng(1))
        assert triples.shape == (4000, 3)
        anchor, chosen, other = labels[triples].T
        assert np.all((anchor == chosen) != (anchor == other)), "what is unclear is passed over"
        assert np.all(triples[:, 0] != triples[:, 1])
        wrong = np.mean(anchor == other)
        assert abs(wrong - rate) < 4 * np.sqrt(rate * (1 - rate) / 4000) + 1e-12


def test_with_one_label_there_is_nothing_to_judge() -> None:
    with pytest.raises(DiscoveryError, match="nothing to judge; take more videos"):
        simulate_annotator(np.array(["random"] * 9), 5, 0.0, np.random.default_rng(0))


def test_judgements_come_back_from_their_file_and_only_for_the_videos_that_were_judged(tmp_path: Path) -> None:
    videos = np.random.default_rng(0).integers(0, 255, (5, 3, 8, 8), dtype=np.uint8)
    given = Judgements(np.array([[0, 1, 2], [4, 3, 2]]), ("a person",), fingerprint(videos))
    path = tmp_path / "answers.json"
    write_judgements(path, given)
    found = read_judgements(path, videos)
    np.testing.assert_array_equal(found.triples, given.triples)
    assert dataclasses.replace(found, triples=given.triples) == given
    with pytest.raises(DiscoveryError, match=r"judges dataset .* this run's is"):
        read_judgements(path, 255 - videos)
    for content in ("", "[]", '{"dataset": "x", "annotators": [], "triples": [[1, 2]]}'):
        path.write_text(content)
        with pytest.raises(DiscoveryError, match=r"answers\.json: no judgements can be read"):
            read_judgements(path, videos)
    path.write_text(json.dumps({"dataset": fingerprint(videos), "annotators": ["a person"], "triples": [[0, 1, 5]]}))
    with pytest.raises(DiscoveryError, match="rows outside 0 to 4"):
        read_judgements(path, videos)
