"""Distances of densities for people. It imports nothing, since commands load it before they know what to do."""

from __future__ import annotations

from math import log


def divergence_share(js: float) -> str:
    """A divergence in nats for people: 0 % for the same models, 100 % for files without a model in common."""
    return f"{js / log(2.0):.2%}" if js < 0.01 * log(2.0) else f"{js / log(2.0):.0%}"
