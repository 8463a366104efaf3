"""What a change of a model gains on runs that it was not fitted to."""

from __future__ import annotations

from collections.abc import Callable


def cross_validated_gain(groups: int, folds: int, gained: Callable[[list[int], list[int]], float]) -> float:
    """Return the gain over all groups, each predicted by what was fitted to other folds.

    Args:
        groups: Number of groups that are held out together, at least two.
        folds: Number of folds at most.
        gained: From the groups that are fitted to and those held out to the gain on the latter.
    """
    folds = min(folds, groups)
    total = 0.0
    for fold in range(folds):
        out = [group for group in range(groups) if group % folds == fold]
        total += gained([group for group in range(groups) if group not in out], out)
    return total
