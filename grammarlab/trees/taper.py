"""Radii along stems: taper, rounded ends, beads and the flare of trunks (Weber and Penn, section 4.4)."""

from __future__ import annotations

import numpy as np

from grammarlab.arrays import Floats, Ints
from grammarlab.trees.draws import values
from grammarlab.trees.skeleton import Skeleton

_FLARE_SHARE = 1.0 / 8.0
"""Share of the trunk's length that flares, of the paper."""


def radii(skeleton: Skeleton, level: int, stem: Ints, along: Floats) -> Floats:
    """[K] radius in metres of stems at places along them, with flare for trunks and without lobes.

    Args:
        skeleton: trees.
        level: level of the stems.
        stem: [K] rows of the stems of that level.
        along: [K] shares of the length of the whole stem, 0 to 1.
    """
    stems = skeleton.levels[level]
    tree = stems.tree[stem]
    taper = values(skeleton.rows, tree, f"taper_{level}")
    radius = tapered(stems.radius[stem], stems.length[stem], taper, along)
    return radius * flare(values(skeleton.rows, tree, "flare"), along) if level == 0 else radius


def tapered(radius: Floats, length: Floats, taper: Floats, along: Floats) -> Floats:
    """[K] radius at places along stems.

    Args:
        radius: [K] radius at the base.
        length: [K] length.
        taper: [K] 0 cylinder, 1 cone, up to 2 a rounded end, up to 3 beads.
        along: [K] share of the length, 0 to 1.
    """
    unit = np.where(taper < 1.0, taper, np.maximum(0.0, 2.0 - taper))
    t = radius * (1.0 - unit * along)
    if (taper < 1.0).all():
        return t
    rest = (1.0 - along) * length
    is_bead = taper >= 2.0
    depth = np.where(~is_bead | (rest < t), 1.0, taper - 2.0)
    period = np.where(t > 0.0, 2.0 * t, 1.0)
    distance = np.where(is_bead, np.abs(rest - period * np.floor(rest / period + 0.5)), rest)
    ball = (1.0 - depth) * t + depth * np.sqrt(np.maximum(0.0, t**2 - (distance - t) ** 2))
    return np.where((taper < 1.0) | (~is_bead & (distance >= t)), t, ball)


def flare(amount: Floats, along: Floats) -> Floats:
    """[K] factor of a trunk's radius by its flare and the share of its length."""
    rise = np.maximum(0.0, 1.0 - along / _FLARE_SHARE)
    return 1.0 + amount * (100.0**rise - 1.0) / 100.0
