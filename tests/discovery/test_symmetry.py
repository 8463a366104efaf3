"""Videos that are one another's mirror images or quarter turns have one embedding, where the settings ask for it."""

import numpy as np
import numpy.typing as npt
import pytest
import torch

from discovery.representations.compute import Compute
from discovery.representations.encoder import Encoder, make_network
from discovery.representations.symmetry import turned_and_mirrored
from swarm_envs import Trajectories, load_world
from swarm_envs.rendering import videos

CPU = Compute(torch.device("cpu"), torch.float32)


def pictures(count: int = 2) -> npt.NDArray[np.uint8]:
    return np.random.default_rng(3).integers(0, 256, (count, 3, 32, 32)).astype(np.uint8)


def ways_by_numpy(given: npt.NDArray[np.uint8], symmetries: int) -> list[npt.NDArray[np.uint8]]:
    mirrored = given[..., ::-1]
    if symmetries == 4:
        return [given, mirrored, given[..., ::-1, :], mirrored[..., ::-1, :]]
    return [np.ascontiguousarray(np.rot90(each, turns, axes=(-2, -1))) for each in (given, mirrored) for turns in range(4)]


@pytest.mark.parametrize("symmetries", [4, 8])
def test_the_ways_are_those_that_leave_a_rectangle_or_a_square_in_place(symmetries: int) -> None:
    found = turned_and_mirrored(torch.from_numpy(pictures()), symmetries).numpy()
    expected = ways_by_numpy(pictures(), symmetries)
    assert {each.tobytes() for each in found} == {each.tobytes() for each in expected}
    assert len({each.tobytes() for each in found}) == symmetries


@pytest.mark.parametrize("symmetries", [4, 8])
def test_every_way_to_see_a_video_has_the_same_embedding_and_other_videos_have_others(symmetries: int) -> None:
    network, given = make_network(3, 0), pictures()
    encoder, plain = Encoder(network, CPU, symmetries=symmetries), Encoder(network, CPU)
    expected = encoder(given)
    apart = np.linalg.norm(expected[0] - expected[1])
    for way in ways_by_numpy(given, symmetries)[1:]:
        assert np.abs(encoder(way) - expected).max() < 1e-3 * apart
        assert np.linalg.norm(plain(way) - plain(given), axis=1).min() > 0.1 * apart, "without symmetries each way has its own"
    if symmetries == 4:
        turned = np.ascontiguousarray(np.rot90(given, axes=(-2, -1)))
        assert np.linalg.norm(encoder(turned) - expected, axis=1).min() > 0.05 * apart, "a quarter turn is no symmetry of a rectangle"


def test_the_embedding_is_the_mean_over_all_ways_and_has_length_one_when_normalised() -> None:
    network, given = make_network(3, 0), pictures()
    plain = Encoder(network, CPU)
    mean = np.mean([plain(np.ascontiguousarray(way)) for way in ways_by_numpy(given, 8)], axis=0)
    np.testing.assert_allclose(Encoder(network, CPU, symmetries=8)(given), mean, atol=1e-5)
    unit = Encoder(network, CPU, normalise=True, symmetries=8)(given)
    np.testing.assert_allclose(unit, mean / np.linalg.norm(mean, axis=1, keepdims=True), atol=1e-5)


def test_a_mirrored_rollout_is_drawn_as_the_mirrored_picture() -> None:
    world = load_world("hero_plus")
    width, height = world.size
    generator = np.random.default_rng(0)
    poses = np.concatenate([generator.uniform(0.1, 1.3, (5, 7, 8, 2)), generator.uniform(-3, 3, (5, 7, 8, 1))], axis=-1)
    left_right = poses * [-1, 1, -1] + [width, 0, np.pi]
    top_bottom = poses * [1, -1, -1] + [0, height, 0]

    def drawn(given: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
        nothing, still = np.zeros(given.shape[:3], np.uint8), np.zeros((*given.shape[:3], 2))
        return videos(Trajectories(world, "made", 0.1 * np.arange(7), given, nothing, still)).astype(float)

    ways = turned_and_mirrored(torch.from_numpy(drawn(poses)), 4).numpy()
    # positions are rounded to an eighth of a pixel and headings to 64 directions: edges differ a little
    rounding, another = 1.5, np.abs(drawn(poses) - drawn(left_right)).mean()
    assert another > 4 * rounding
    assert np.abs(drawn(left_right) - ways[1]).mean() < rounding
    assert np.abs(drawn(top_bottom) - ways[2]).mean() < rounding
