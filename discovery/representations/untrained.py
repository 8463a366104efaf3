"""The baselines: a ResNet18 as ImageNet left it, and one with random weights."""

from __future__ import annotations

from discovery.randomness import whole_seed
from discovery.representations.encoder import make_network
from discovery.representations.interface import Fitted
from discovery.representations.videos import fit_encoder, save_network, saved_network, starting_weights
from discovery.rollouts.dataset import Dataset
from discovery.runs.run_folder import RunFolder


def fit_untrained(folder: RunFolder, dataset: Dataset) -> Fitted:
    """Return a ResNet18 that has never seen a swarm."""
    found = saved_network(folder)
    if found is not None:
        network, origin = found[0], found[1].metadata["origin"]
    else:
        origin, start = starting_weights(folder)
        network = make_network(folder.settings.dataset.frames, whole_seed(folder.settings.seed, "network"), start)
        save_network(folder, network, origin, [])
    return Fitted(fit_encoder(folder, network, dataset), f"{origin}, and was not trained", done="a ResNet18 that is not trained")
