"""The likeliest value of one number near its present one, the others as they are."""

from __future__ import annotations

from collections.abc import Callable

from scipy.optimize import minimize_scalar


def line_search(
    log_likelihood: Callable[[float], float], now: float, best: float, bounds: tuple[float, float], tolerance: float, most: int = 500
) -> tuple[float, float]:
    """Return the likeliest value and its log-likelihood, those of the present one where nothing likelier is found.

    Args:
        log_likelihood: Of a value.
        now: The present value.
        best: Its log-likelihood.
        bounds: Between which to look.
        tolerance: Of the value.
        most: Values tried at most.
    """
    options = {"xatol": tolerance, "maxiter": most}
    found = minimize_scalar(lambda value: -log_likelihood(value), bounds=bounds, method="bounded", options=options)
    return (float(found.x), -float(found.fun)) if -found.fun > best else (now, best)
