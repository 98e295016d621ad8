"""Pruning: stems that leave the envelope of their tree are shortened (Weber and Penn, section 4.5).

The draws of a stem stay as they are, so a shorter stem is the same path at a smaller scale, about the place where it
begins. Its length is found by bisection, together with that of its clones. Trunks are not pruned.
"""

from __future__ import annotations

import numpy as np

from grammarlab.arrays import Flags, Floats, Ints, row_of_value
from grammarlab.trees.draws import values
from grammarlab.trees.envelope import is_inside
from grammarlab.trees.stem_paths import Paths

_STEPS = 24
"""Halvings of the length: the result is exact to 2^-24 of it."""


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
