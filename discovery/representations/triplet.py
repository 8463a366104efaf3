"""Triplet learning on similarity judgements (Mattson and Brown 2023)."""

from __future__ import annotations

from pathlib import Path

import torch
from lightly.utils.scheduler import CosineWarmupScheduler
from torch import nn

from discovery.randomness import generator, whole_seed
from discovery.representations.augment import augment, draw_views
from discovery.representations.encoder import make_network
from discovery.representations.interface import Fitted
from discovery.representations.judgements import SIMULATED, Judgements, read_judgements, simulate_annotator, write_judgements
from discovery.representations.training import Training, describe, train
from discovery.representations.videos import compute_of, fit_encoder, save_network, saved_network, starting_weights
from discovery.rollouts.dataset import Dataset
from discovery.rollouts.filming import fingerprint
from discovery.runs.run_folder import RunFolder
from discovery.settings import TripletSettings

JUDGEMENTS = "judgements.json"
"""File of the run folder with the answers that were learned from."""


def fit_triplet(folder: RunFolder, dataset: Dataset) -> Fitted:
    """Learn that of two videos the one judged more similar to a third is nearer to it, or read the folder's encoder."""
    found = saved_network(folder)
    if found is not None:
        network, metadata = found[0], found[1].metadata
        origin, losses, done = metadata["origin"], metadata["losses"], "taken from the run folder"
    else:
        judgements = gather_judgements(folder, dataset)
        weights, start = starting_weights(folder)
        origin = f"{weights}, and learned from {len(judgements.triples)} answers of {' and '.join(judgements.annotators)}"
        training = train_triplet(folder, dataset, judgements, start)
        network, losses = training.network, training.losses
        done = f"triplets on {len(judgements.triples)} answers, {len(losses)} steps, {describe(losses)}"
        save_network(folder, network, origin, losses)
    return Fitted(fit_encoder(folder, network, dataset), origin, losses, "triplet margin loss (distance)", done)


def gather_judgements(folder: RunFolder, dataset: Dataset) -> Judgements:
    """Return the answers to learn from: a person's file, or the simulated annotator's."""
    settings: TripletSettings = folder.settings.representation
    if settings.judgements is not None:
        found = read_judgements(Path(settings.judgements), dataset.videos)
    else:
        draws = generator(folder.settings.seed, "judgements")
        triples = simulate_annotator(dataset.labels, settings.answers, settings.error_rate, draws)
        found = Judgements(triples, (f"a {SIMULATED} with {100 * settings.error_rate:g} % errors",), fingerprint(dataset.videos))
    write_judgements(folder.path / JUDGEMENTS, found)
    return found


def train_triplet(folder: RunFolder, dataset: Dataset, judgements: Judgements, start: dict[str, torch.Tensor] | None) -> Training:
    """Train an encoder on judged triples."""
    settings: TripletSettings = folder.settings.representation
    seed, compute = folder.settings.seed, compute_of(settings)
    network = make_network(folder.settings.dataset.frames, whole_seed(seed, "network"), start).to(compute.device)
    batch = min(settings.batch, len(judgements.triples))
    per_epoch = len(judgements.triples) // batch
    optimizer = torch.optim.AdamW(network.parameters(), lr=settings.learning_rate, weight_decay=settings.weight_decay)
    scheduler = CosineWarmupScheduler(optimizer, warmup_epochs=0, max_epochs=max(1, settings.epochs * per_epoch), end_value=0.0)
    training = Training(network, nn.Identity(), optimizer, scheduler, [])
    videos, triples, loss = torch.from_numpy(dataset.videos), torch.from_numpy(judgements.triples), nn.TripletMarginLoss(settings.margin)
    crop = (settings.crop_scale[0], settings.crop_scale[1])

    def one(number: int) -> None:
        epoch, place = divmod(number, per_epoch)
        order = generator(seed, "epoch", epoch).permutation(len(triples))[place * batch : (place + 1) * batch]
        pictures = compute.picture(videos[triples[torch.from_numpy(order)].T.reshape(-1)])
        views = torch.Generator().manual_seed(whole_seed(seed, "views", number))
        pictures = augment(pictures, draw_views(len(pictures), crop, settings.flip, views))
        with compute.autocast():
            embedded = network(pictures.contiguous(memory_format=torch.channels_last))
        embedded = embedded.float()
        if settings.normalise:
            embedded = nn.functional.normalize(embedded)
        training.descend(loss(*embedded.chunk(3)))

    train(folder, training, one, settings.epochs * per_epoch, batch * 3, settings.checkpoint_seconds)
    return training
