"""Embeddings on a common scale, against what the words say."""

import numpy as np
import pytest

from discovery.errors import DiscoveryError
from discovery.representations.whitening import Embeddings, fit_whitening


def embeddings(count: int = 4000, spread: tuple[float, ...] = (10.0, 3.0, 1.0, 0.01)) -> Embeddings:
    """Uncorrelated numbers of the given standard deviations, off zero, then turned so that all are correlated."""
    generator = np.random.default_rng(0)
    turn = np.linalg.qr(generator.normal(size=(len(spread), len(spread))))[0]
    return ((generator.normal(size=(count, len(spread))) * spread + 5.0) @ turn).astype(np.float32)


def test_standardised_numbers_have_mean_0_and_standard_deviation_1() -> None:
    given = embeddings()
    found = fit_whitening(given, "standardise", 0.95)(given)
    assert found.dtype == np.float32
    np.testing.assert_allclose(found.mean(axis=0), 0.0, atol=1e-4)
    np.testing.assert_allclose(found.std(axis=0), 1.0, atol=1e-4)
    assert np.corrcoef(found[:, 0], given[:, 0])[0, 1] == pytest.approx(1.0, abs=1e-5), "each by itself"


def test_a_number_that_never_changes_is_not_blown_up() -> None:
    given = embeddings()
    given[:, 2] = 7.0
    found = fit_whitening(given, "standardise", 0.95)(given + np.float32([0, 0, 0.5, 0]))
    np.testing.assert_allclose(found[:, 2], 0.5, atol=1e-6)


def test_principal_components_are_uncorrelated_with_standard_deviation_1() -> None:
    given = embeddings()
    found = fit_whitening(given, "pca", 1.0)(given)
    assert found.shape == given.shape
    np.testing.assert_allclose(found.T @ found / len(found), np.eye(4), atol=2e-3)


@pytest.mark.parametrize(("variance", "kept"), [(0.5, 1), (0.9, 1), (0.95, 2), (0.995, 3), (1.0, 4)])
def test_the_fewest_components_that_hold_the_variance_are_kept(variance: float, kept: int) -> None:
    # their shares of the variance: 0.909, 0.082, 0.009, 0.000001
    assert fit_whitening(embeddings(), "pca", variance)(embeddings()).shape == (4000, kept)


def test_fewer_videos_than_numbers_give_no_components_of_nothing() -> None:
    given = np.random.default_rng(1).normal(size=(6, 512)).astype(np.float32)
    found = fit_whitening(given, "pca", 1.0)(given)
    assert found.shape == (6, 5)
    np.testing.assert_allclose(found.std(axis=0), 1.0, atol=1e-3)


@pytest.mark.parametrize("method", ["standardise", "pca"])
def test_embeddings_that_are_all_the_same_are_refused(method: str) -> None:
    with pytest.raises(DiscoveryError, match=r"representation\.whiten: every video .* same embedding; take whiten=none"):
        fit_whitening(np.ones((5, 3), dtype=np.float32), method, 0.95)
