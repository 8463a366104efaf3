"""The paper's own numbers, to stand beside ours (Mattson et al., AAMAS 2025)."""

from __future__ import annotations

HAND_CRAFTED, TRIPLET, SIMCLR = "hand-crafted", "triplet learning", "SimCLR"

GAIN = {"cyclic pursuit": 0.16, "aggregation": 0.00, "dispersal": 0.05}
"""Figure 3: triplet accuracy of SimCLR less that of the hand-crafted metrics, by the anchor's behaviour; mean of 3 training runs."""

FREQUENCY: dict[str, dict[str, tuple[float, float]]] = {
    HAND_CRAFTED: {"aggregation": (4.33, 0.66), "cyclic pursuit": (0.66, 0.33), "dispersal": (0.0, 0.0), "random": (5.0, 1.0)},
    TRIPLET: {"aggregation": (3.66, 0.66), "cyclic pursuit": (2.0, 0.0), "dispersal": (0.0, 0.0), "random": (4.33, 0.66)},
    SIMCLR: {"aggregation": (2.0, 0.0), "cyclic pursuit": (1.0, 0.57), "dispersal": (2.0, 0.57), "random": (5.0, 1.0)},
}
"""Table 1: mean and standard error of each behaviour's medoids, of ten, over 3 runs; labels given by people."""

UNIQUE = {HAND_CRAFTED: (1.6, 0.33), TRIPLET: (2.0, 0.0), SIMCLR: (2.6, 0.33)}
"""Table 1: different behaviours among the ten medoids, random not counted."""

DEPLOYED: dict[str, dict[str, tuple[str, str, str]]] = {
    "unrefined": {
        "aggregation": ("◐✗", "-", "✗✗✗"), "cyclic pursuit": ("✗", "✓", "✓✗"), "dispersal": ("-", "✓✓", "-"),
        "milling": ("-", "✗", "✗✗"), "wall following": ("✗", "✗✗", "-"),
    },
    "hero_plus": {
        "aggregation": ("✓✓", "✓◐", "✓✓"), "cyclic pursuit": ("✓", "✓◐", "-"), "dispersal": ("✓", "✓✓◐", "✓✓"),
        "milling": ("-", "-", "-"), "wall following": ("-", "-", "-"),
    },
}  # fmt: skip
"""Table 2: medoids tried on real robots, by the world that they were found in, in three trials; marks as in our own table."""

SUCCESS = {"unrefined": (0.22, 0.27), "hero_plus": (0.70, 0.90)}
"""Share of medoids other than random that real robots reproduced at the first attempt, and within three (Discovery and Deployment; for
``hero_plus`` it counts medoids of both representations)."""


def counterpart(name: str) -> str | None:
    """Return which of the paper's representations one of ours corresponds to, None when it has none."""
    for theirs in (TRIPLET, SIMCLR):
        if name == theirs or name.startswith(f"{theirs} (simulated"):
            return theirs
    return HAND_CRAFTED if name == HAND_CRAFTED else None
