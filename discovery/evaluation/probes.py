"""What simple classifiers read from embeddings: nearest neighbours, and a linear probe."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from sklearn.linear_model import LogisticRegression
from sklearn.model_selection import StratifiedKFold, cross_val_score
from sklearn.neighbors import KNeighborsClassifier
from sklearn.pipeline import make_pipeline
from sklearn.preprocessing import StandardScaler

NEIGHBOURS = 5
FOLDS = 5


def probe(embeddings: npt.NDArray[np.floating], labels: npt.NDArray[np.str_], seed: int = 0) -> dict[str, float]:
    """Return balanced accuracies, each the mean over five stratified folds.

    Args:
        embeddings: (N, d).
        labels: (N,), each class at least as often as there are folds.
        seed: Of the folds.

    Returns:
        ``knn``: five nearest neighbours in the embeddings as they are. ``linear``: logistic regression on standardised embeddings.
    """
    folds = StratifiedKFold(FOLDS, shuffle=True, random_state=seed)
    classifiers = {
        "knn": KNeighborsClassifier(NEIGHBOURS),
        "linear": make_pipeline(StandardScaler(), LogisticRegression(C=0.01, max_iter=2000)),
    }
    return {
        name: float(cross_val_score(classifier, embeddings, labels, cv=folds, scoring="balanced_accuracy").mean())
        for name, classifier in classifiers.items()
    }
