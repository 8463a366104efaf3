"""Embeddings on a common scale, against what the words say."""

import numpy as np
import numpy.typing as npt
import pytest

from discovery.errors import DiscoveryError
from discovery.representations.affine import AffineTransform
from discovery.representations.videos import fit_whitening


def embeddings(count: int = 4000, spread: tuple[float, ...] = (10.0, 3.0, 1.0, 0.01)) -> npt.NDArray[np.float32]:
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


def former_whitening(embeddings: npt.NDArray[np.float32], method: str, variance: float) -> tuple[npt.NDArray[np.float32], ...]:
    """Mean and directions as the version before computed them."""
    given = embeddings.astype(np.float64)
    mean, spread = given.mean(axis=0), given.std(axis=0)
    if method == "standardise":
        directions = np.diag(1.0 / np.where(spread > 1e-6 * spread.max(), spread, 1.0))
    else:
        _, singular, components = np.linalg.svd(given - mean, full_matrices=False)
        held = np.cumsum(singular**2) / np.sum(singular**2)
        kept = min(int(np.searchsorted(held, variance)) + 1, int(np.sum(singular > 1e-6 * singular[0])))
        directions = components[:kept].T * (np.sqrt(len(given)) / singular[:kept])
    return mean.astype(np.float32), np.ascontiguousarray(directions, dtype=np.float32)


@pytest.mark.parametrize("method", ["standardise", "pca"])
def test_scales_of_a_dataset_are_those_of_the_version_before_to_the_last_bit(method: str) -> None:
    found = fit_whitening(embeddings(), method, 0.95)
    mean, directions = former_whitening(embeddings(), method, 0.95)
    np.testing.assert_array_equal(found.mean, mean)
    np.testing.assert_array_equal(found.matrix, directions)
    np.testing.assert_array_equal(found(embeddings()), (embeddings() - mean) @ directions)


@pytest.mark.parametrize("standardise", [False, True])
def test_distances_between_whitened_rows_are_those_of_the_version_before(standardise: bool) -> None:
    """It took the components from the covariance's eigenvectors; only their signs may differ."""
    rows = embeddings(600).astype(np.float64)
    given = (rows - rows.mean(axis=0)) / (rows.std(axis=0) if standardise else 1.0)
    variances, axes = np.linalg.eigh(given.T @ given / len(given))
    variances, axes = variances[::-1], axes[:, ::-1]
    count = int(np.searchsorted(np.cumsum(variances), 0.99 * variances.sum())) + 1
    former = given @ (axes[:, :count] / np.sqrt(variances[:count]))
    found = AffineTransform.whitening(rows, 0.99, standardise)(rows)
    assert found.shape == former.shape
    (ours, theirs) = (np.linalg.norm(each[:50, None] - each[None, :50], axis=2) for each in (found, former))
    np.testing.assert_allclose(ours, theirs, atol=1e-9)


def test_within_class_covariance_normalisation_is_that_of_the_version_before_to_the_last_bit() -> None:
    rng = np.random.default_rng(3)
    mix = rng.normal(size=(6, 6))
    covariance, rows = mix @ mix.T, rng.normal(size=(40, 6))
    mean = np.trace(covariance) / 6
    variances, axes = np.linalg.eigh(0.9 * covariance + 0.1 * mean * np.eye(6))
    former = (rows - rows.mean(axis=0)) @ ((axes / np.sqrt(variances)) @ axes.T)
    np.testing.assert_array_equal(AffineTransform.within_class(rows.mean(axis=0), covariance)(rows), former)
