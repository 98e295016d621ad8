"""Reach of crowns: how far trees extend from their trunks, without growing their twigs."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from grammarlab.arrays import Floats
from grammarlab.randomness import Keys, root_keys
from grammarlab.trees.accepted_trees import AcceptedTrees, accepted_rows
from grammarlab.trees.growth import grow
from grammarlab.trees.parameters import COLUMN
from grammarlab.trees.skeleton import Skeleton
from grammarlab.trees.species import Species

_BOUGHS, _TWIGS = 2, 3
"""Levels of a tree that is measured quickly, and of one that is measured well: stems of level 3 hardly change it."""
_NUM_REFERENCES = 32
"""Number of trees that are measured well: the first ones of the seed."""
_TREES_AT_ONCE = 256
"""Number of trees that grow at once."""


@dataclass(frozen=True, eq=False)
class CrownReach:
    """Radii of the crowns of a species under a seed: the largest distance of a part from the base of the trunk.

    Only trunks and boughs grow, and their reach is multiplied by the largest factor that twigs and leaves add to it in
    a few trees. So hardly a crown is wider, and most are a few per cent narrower.
    """

    species: Species
    seed: int

    def __call__(self, models: Keys) -> Floats:
        """[n] radii in metres of the crowns of models [n]."""
        return self.widening * self._reach(models, _BOUGHS)

    @cached_property
    def widening(self) -> float:
        """How much wider whole crowns are than their boughs."""
        models = np.arange(_NUM_REFERENCES, dtype=np.uint64)
        boughs, whole = self._reach(models, _BOUGHS), self._reach(models, _TWIGS)
        return float(np.max(whole[boughs > 0] / boughs[boughs > 0], initial=1.0))

    def _reach(self, models: Keys, levels: int) -> Floats:
        parts = [models[start : start + _TREES_AT_ONCE] for start in range(0, len(models), _TREES_AT_ONCE)]
        trees = (accepted_rows(self.species, root_keys(self.seed, part)) for part in parts)
        return np.concatenate([np.zeros(0), *(reach(_grown(part, levels)) for part in trees)])


def reach(skeleton: Skeleton) -> Floats:
    """[n] largest horizontal distance in metres of stems and tips of leaves from the bases of the trunks."""
    farthest = np.zeros(skeleton.num_trees)
    for stems in skeleton.levels:
        tree = np.repeat(stems.tree, stems.num_nodes)
        np.maximum.at(farthest, tree, np.hypot(stems.points[:, 0], stems.points[:, 2]))
    leaves = skeleton.leaves
    tips = leaves.position + leaves.length[:, None] * leaves.frame[:, :, 2]
    np.maximum.at(farthest, leaves.tree, np.hypot(tips[:, 0], tips[:, 2]))
    return farthest


def _grown(trees: AcceptedTrees, levels: int) -> Skeleton:
    """Trees with their first levels; leaves are left out of boughs."""
    rows = trees.rows.copy()
    rows[:, COLUMN["levels"]] = np.minimum(rows[:, COLUMN["levels"]], levels)
    if levels == _BOUGHS:
        rows[:, COLUMN["leaves"]] = 0.0
    return grow(rows, trees.keys)
