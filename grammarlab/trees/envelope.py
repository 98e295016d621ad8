"""Outlines of crowns: how long branches are by their height, and the envelope beyond which they are pruned."""

from __future__ import annotations

import numpy as np

from grammarlab.arrays import Flags, Floats, Ints
from grammarlab.trees.draws import counts, values

ENVELOPE = 8
"""The shape that is the envelope."""


def shape_ratio(shape: Ints, share: Floats, width: Floats) -> Floats:
    """[S] length of a branch by the longest one, 0 to 1.

    Args:
        shape: [S] outline, 0 to 8, of Weber and Penn's section 4.3.
        share: [S] how far below the top of the crown a branch is: 0 at the top, 1 at the lowest branch.
        width: [S] `envelope_ratio` at this share, for shape 8.
    """
    r = np.clip(share, 0.0, 1.0)
    flame = np.where(r <= 0.7, r / 0.7, (1.0 - r) / 0.3)
    return np.choose(
        shape,
        [
            0.2 + 0.8 * r,
            0.2 + 0.8 * np.sin(np.pi * r),
            0.2 + 0.8 * np.sin(0.5 * np.pi * r),
            np.ones_like(r),
            0.5 + 0.5 * r,
            flame,
            1.0 - 0.8 * r,
            0.5 + 0.5 * flame,
            width,
        ],
    )


def envelope_ratio(rows: Floats, tree: Ints, share: Floats) -> Floats:
    """[S] radius of the envelope by its largest radius: 1 at its widest part, 0 at both ends and outside of them.

    Args:
        rows: [n, P] parameters of the trees.
        tree: [S] tree of each place.
        share: [S] how far below the top a place is, by the height of the crown.
    """
    peak = values(rows, tree, "prune_width_peak")
    high, low = values(rows, tree, "prune_power_high"), values(rows, tree, "prune_power_low")
    inside = (share >= 0.0) & (share <= 1.0)
    r = np.where(inside, share, 0.0)
    above = r < 1.0 - peak
    # The printed (1 - r) / (1 - peak) does not reach 1 at the widest part; this form is continuous there.
    base = np.where(above, r / np.where(above, 1.0 - peak, 1.0), (1.0 - r) / np.where(above | (peak <= 0.0), 1.0, peak))
    # Without a lower part, the widest place is the lowest one.
    base = np.where(~above & (peak <= 0.0), 1.0, base)
    return np.where(inside, base ** np.where(above, high, low), 0.0)


def crown_ratio(rows: Floats, tree: Ints, share: Floats) -> Floats:
    """[S] `shape_ratio` of each tree's own outline."""
    return shape_ratio(counts(rows, tree, "shape"), share, envelope_ratio(rows, tree, share))


def is_inside(rows: Floats, tree: Ints, height: Floats, scale: Floats, points: Floats) -> Flags:
    """[K] whether points are within the envelope of their tree.

    Args:
        rows: [n, P] parameters of the trees.
        tree: [K] tree of each point.
        height: [n] metres: the height of each envelope.
        scale: [n] metres: the unit of its width.
        points: [K, 3] metres.
    """
    crown = height[tree] * (1.0 - values(rows, tree, "base_size"))
    share = (height[tree] - points[:, 1]) / crown
    radius = values(rows, tree, "prune_width") * scale[tree] * envelope_ratio(rows, tree, share)
    return np.hypot(points[:, 0], points[:, 2]) <= radius
