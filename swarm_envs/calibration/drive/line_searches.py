"""The likeliest values of parameters along which the likelihood has no slopes."""

from __future__ import annotations

import numpy as np
from scipy.optimize import minimize_scalar

from swarm_envs.calibration.drive.candidates import BY_NAME, thresholds
from swarm_envs.calibration.drive.fitting import Model
from swarm_envs.calibration.drive.measured import Measured

COARSE = 40
"""Thresholds that are tried before those near the best."""


def likeliest_threshold(model: Model, data: Measured) -> Model:
    """Return the model with the likeliest deadband: the best of some thresholds, then of all near it."""
    parameter = BY_NAME["deadband"].parameters
    every = thresholds(model.parameters, data)
    if not len(every):
        return model
    stride = max(1, len(every) // COARSE)
    best, likelihood = model, model.filtered(data).total
    near = int(np.searchsorted(every, model.parameters[parameter[0].index]))
    for places in (range(0, len(every), stride), None):
        for place in places if places is not None else range(max(0, near - stride), min(len(every), near + stride + 1)):
            trial = model.with_values(parameter, [float(every[place])])
            total = trial.filtered(data).total
            if total > likelihood:
                best, likelihood, near = trial, total, place
    return best


def likeliest_loss(model: Model, data: Measured) -> Model:
    """Return the model with the likeliest probability of a lost command."""
    parameter = BY_NAME["command_loss"].parameters

    def drop(logit: float) -> float:
        return -model.with_values(parameter, [1 / (1 + np.exp(-logit))]).filtered(data).total

    logit = float(minimize_scalar(drop, bounds=(-7.0, 2.0), method="bounded", options={"xatol": 0.02}).x)
    return model.with_values(parameter, [1 / (1 + np.exp(-logit))])
