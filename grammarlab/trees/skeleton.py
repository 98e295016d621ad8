"""Skeletons: the stems and leaves of all trees of a batch, as columns.

World axes: y up, metres, right-handed, the trunk's base at the origin of its model. A frame [3, 3] has the axes of a
stem as columns: x, about which it curves, y, and z, the direction along it. It is a proper rotation.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import Flags, Floats, Ints
from grammarlab.randomness import Keys


@dataclass(frozen=True, slots=True, eq=False)
class Stems:
    """S stems of one level, ordered by tree.

    A stem that splits goes on as itself, and each clone is a stem that begins where it split: its nodes are those from
    there on, its length and radius those of the whole stem.
    """

    tree: Ints
    """[S] tree of the batch, ascending."""
    parent: Ints
    """[S] row of the parent among the stems of the level before; -1 for trunks."""
    source: Ints
    """[S] row, in this level, of the stem that a clone split from; -1 for the others."""
    first: Ints
    """[S] index of the segment with which it begins: 0 but for clones."""
    key: Keys
    """[S] key of its draws."""
    offset: Floats
    """[S] metres from the base of the parent to where it begins, along the parent; 0 for trunks."""
    length: Floats
    """[S] metres, after pruning; of the whole stem for clones."""
    radius: Floats
    """[S] metres at its base, before taper, flare and lobes."""
    node_offsets: Ints
    """[S + 1] into the nodes: a stem of k segments has k + 1 nodes."""
    points: Floats
    """[N, 3] metres."""
    frames: Floats
    """[N, 3, 3] orientation of the segment that begins at a node; at the last one, of the segment that ends there."""
    along: Floats
    """[N] share of the whole stem's length at a node, 0 to 1."""

    def __len__(self) -> int:
        return len(self.tree)

    @property
    def num_nodes(self) -> Ints:
        """[S] nodes of each stem."""
        return np.diff(self.node_offsets)

    @property
    def is_clone(self) -> Flags:
        """[S] whether a stem is a clone."""
        return self.source >= 0


@dataclass(frozen=True, slots=True, eq=False)
class Leaves:
    """L leaves and blossoms, ordered by tree."""

    tree: Ints
    """[L] tree of the batch, ascending."""
    stem: Ints
    """[L] row of its stem among those of the last level of its tree."""
    level: NDArray[np.int8]
    """[L] level of its stem."""
    offset: Floats
    """[L] metres from the base of the stem along it."""
    position: Floats
    """[L, 3] metres: where its stalk leaves the stem."""
    frame: Floats
    """[L, 3, 3] proper rotations: x across the blade, y out of its upper side, z from the stalk to the tip."""
    length: Floats
    """[L] metres of the blade; of a petal for blossoms."""
    width: Floats
    """[L] metres of the blade."""
    is_blossom: Flags
    """[L] whether it is a blossom."""

    def __len__(self) -> int:
        return len(self.tree)

    def take(self, rows: Ints | Flags) -> Leaves:
        """Chosen leaves, in the order of the rows."""
        return Leaves(**{column.name: getattr(self, column.name)[rows] for column in fields(self)})

    @classmethod
    def joined(cls, parts: Sequence[Leaves]) -> Leaves:
        """The leaves of parts, ordered by tree; those of one tree in the order of the parts."""
        if len(parts) == 1:
            return parts[0]
        columns = {
            column.name: np.concatenate([getattr(part, column.name) for part in parts]) for column in fields(cls)
        }
        return Leaves(**columns).take(np.argsort(columns["tree"], kind="stable"))


@dataclass(frozen=True, slots=True, eq=False)
class Skeleton:
    """The trees of a batch.

    >>> import grammarlab as gl
    >>> trees = gl.sample(gl.load("palm"), 2, seed=1)
    >>> trees.num_trees, len(trees.levels)
    (2, 2)
    """

    rows: Floats
    """[n, P] parameters of the trees (`grammarlab.trees.parameters.COLUMNS`)."""
    keys: Keys
    """[n] keys of the trees."""
    scale: Floats
    """[n] metres: the height for which a tree is drawn, scale ± scale_v."""
    levels: tuple[Stems, ...]
    """Stems of the levels 0 to 3 that some tree has; at least that of the trunks."""
    leaves: Leaves

    @property
    def num_trees(self) -> int:
        """Number of trees."""
        return len(self.rows)
