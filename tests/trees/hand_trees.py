"""Skeletons that are drawn by hand: straight stems and leaves of given places."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from grammarlab.arrays import offsets_from_counts
from grammarlab.randomness import root_keys
from grammarlab.trees.parameters import COLUMN, DEFAULTS
from grammarlab.trees.skeleton import Leaves, Skeleton, Stems


@dataclass(frozen=True)
class Stem:
    """A straight stem of two segments; a clone has one."""

    base: tuple[float, float, float]
    tip: tuple[float, float, float]
    radius: float
    tree: int = 0
    parent: int = -1
    offset: float = 0.0
    source: int = -1
    begin: float = 0.0
    """Share of its length where it begins, for clones: above 0."""


@dataclass(frozen=True)
class Leaf:
    """A leaf that points up."""

    position: tuple[float, float, float]
    length: float = 0.1
    width: float = 0.06
    tree: int = 0
    is_blossom: bool = False


def skeleton(levels: Sequence[Sequence[Stem]], leaves: Sequence[Leaf] = (), taper: float = 0.0) -> Skeleton:
    """Trees with the stems of each level and the leaves, ordered by tree, and one taper for all stems."""
    num = 1 + max(stem.tree for stem in levels[0])
    rows = np.tile(DEFAULTS, (num, 1))
    rows[:, [COLUMN[f"taper_{level}"] for level in range(4)]] = taper
    rows[:, COLUMN["flare"]] = 0.0
    scale = np.ones(num)
    return Skeleton(
        rows, root_keys(0, np.arange(num)), scale, tuple(_stems(stems) for stems in levels), _leaves(leaves)
    )


def _stems(stems: Sequence[Stem]) -> Stems:
    points, along, counts = [], [], []
    for stem in stems:
        base, tip = np.array(stem.base), np.array(stem.tip)
        shares = (0.0, 0.5, 1.0) if stem.source < 0 else (stem.begin, 1.0)
        points += [base + share * (tip - base) for share in shares]
        along += shares
        counts.append(len(shares))
    return Stems(
        tree=np.array([stem.tree for stem in stems], dtype=np.int64),
        parent=np.array([stem.parent for stem in stems], dtype=np.int64),
        source=np.array([stem.source for stem in stems], dtype=np.int64),
        first=np.array([int(stem.source >= 0) for stem in stems], dtype=np.int64),
        key=root_keys(1, np.arange(len(stems))),
        offset=np.array([stem.offset for stem in stems]),
        length=np.array([float(np.linalg.norm(np.subtract(stem.tip, stem.base))) for stem in stems]),
        radius=np.array([stem.radius for stem in stems]),
        node_offsets=offsets_from_counts(np.array(counts, dtype=np.int64)),
        points=np.array(points, dtype=np.float64).reshape(-1, 3),
        frames=np.tile(np.eye(3), (len(points), 1, 1)),
        along=np.array(along, dtype=np.float64),
    )


_UP: ArrayLike = [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]]
"""Frame of leaves: z is up."""


def _leaves(leaves: Sequence[Leaf]) -> Leaves:
    num = len(leaves)
    return Leaves(
        tree=np.array([leaf.tree for leaf in leaves], dtype=np.int64),
        stem=np.zeros(num, dtype=np.int64),
        level=np.zeros(num, dtype=np.int8),
        offset=np.zeros(num),
        position=np.array([leaf.position for leaf in leaves], dtype=np.float64).reshape(-1, 3),
        frame=np.tile(np.array(_UP), (num, 1, 1)),
        length=np.array([leaf.length for leaf in leaves]),
        width=np.array([leaf.width for leaf in leaves]),
        is_blossom=np.array([leaf.is_blossom for leaf in leaves], dtype=bool),
    )
