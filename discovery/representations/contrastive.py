"""SimCLR as a representation: trained on the dataset's videos, or read from the folder."""

from __future__ import annotations

from discovery.dataset import Dataset
from discovery.representations.interface import Fitted
from discovery.representations.pairs import Pairs
from discovery.representations.simclr import begin, train_simclr
from discovery.representations.training import describe
from discovery.representations.videos import compute_of, fit_look, save_network, saved_network, starting_weights
from discovery.run_folder import RunFolder
from discovery.settings import SimCLRSettings

LOSS = "NT-Xent loss (nat)"


def fit_simclr(folder: RunFolder, dataset: Dataset) -> Fitted:
    """Train SimCLR on the dataset's videos, or read the encoder that the folder holds already."""
    settings: SimCLRSettings = folder.settings.representation
    found = saved_network(folder)
    if found is not None:
        network, facts = found[0], found[1].facts
        origin, losses, done = facts["origin"], facts["losses"], "taken from the run folder"
    else:
        origin, start = starting_weights(folder)
        shape = folder.settings.dataset
        pairs = Pairs(len(dataset.videos), shape.starts, settings.batch)
        training = begin(settings, shape.frames, pairs.steps, folder.settings.seed, compute_of(settings), start)
        train_simclr(folder, dataset.videos, pairs, compute_of(settings), training, settings)
        network, losses = training.network, training.losses
        done = f"SimCLR on {len(dataset.videos)} videos, {len(losses)} steps, {describe(losses)}" if losses else "no steps"
        save_network(folder, network, origin, losses)
    return Fitted(fit_look(folder, network, dataset), origin, losses, LOSS, done)
