"""Outlines of crowns: how long branches are by their height, and the envelope to which they are pruned.

Stems that leave the envelope of their tree are shortened (Weber and Penn, section 4.5). The draws of a stem stay as
they are, so a shorter stem is the same path at a smaller scale, about the place where it begins. Its length is found by
bisection, together with that of its clones. Trunks are not pruned.
"""

from __future__ import annotations

import numpy as np

from grammarlab.arrays import Flags, Floats, Ints, row_of_value
from grammarlab.trees.draws import counts, values
from grammarlab.trees.stem_paths import Paths

_STEPS = 24
"""Halvings of the length: the result is exact to 2^-24 of it."""


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


def pruned_lengths(
    rows: Floats, height: Floats, scale: Floats, tree: Ints, base: Floats, length: Floats, root: Ints, paths: Paths
) -> Floats:
    """[W] metres: the lengths of whole stems after pruning.

    Args:
        rows: [n, P] parameters of the trees.
        height: [n] metres: the height of each tree's envelope.
        scale: [n] metres: the unit of its width.
        tree: [W] tree of each whole stem.
        base: [W, 3] metres: where it begins.
        length: [W] metres, before pruning.
        root: [S] whole stem of each stem, clones included.
        paths: paths of these stems for a length of 1.
    """
    ratio = values(rows, tree, "prune_ratio")
    if not ratio.any():
        return length
    owner = root[row_of_value(np.diff(paths.node_offsets))]

    def fit(share: Floats, nodes: Ints) -> Flags:
        """[W] whether some nodes of a stem are in the envelope if it has a share [W] of its length."""
        stem = owner[nodes]
        points = base[stem] + (length * share)[stem, None] * paths.points[nodes]
        result = np.ones(len(tree), bool)
        result[stem[~is_inside(rows, tree[stem], height, scale, points)]] = False
        return result

    high = np.ones(len(tree))
    low = fit(high, np.flatnonzero(ratio[owner] > 0.0)).astype(np.float64)
    nodes = np.flatnonzero(low[owner] < 1.0)
    for _ in range(_STEPS):
        middle = 0.5 * (low + high)
        fits = fit(middle, nodes)
        low, high = np.where(fits, middle, low), np.where(fits, high, middle)
    return (1.0 - ratio) * length + ratio * (length * low)
