"""Entries that make no sense without ImageNet's weights."""

from __future__ import annotations

from discovery.representations.imagenet import NoWeightsError, imagenet_weights
from docs.studies.discovery_of_behaviours.plan import Plan

NEEDS_WEIGHTS = "representation=imagenet"
"""The setting of an entry that is nothing else than those weights; encoders that merely start from them start from random ones instead."""


def without_weights(plan: Plan) -> dict[str, str]:
    """Return why entries are left out, by name; empty when the weights can be had."""
    wanting = [entry.name for entry in plan.entries if NEEDS_WEIGHTS in entry.overrides]
    if not wanting:
        return {}
    try:
        imagenet_weights()
    except NoWeightsError as reason:
        return dict.fromkeys(wanting, f"ImageNet's weights cannot be had ({reason})")
    return {}
