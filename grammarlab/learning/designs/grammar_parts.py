"""The visible shapes of a model, and the rules that made them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from grammarlab.arrays import Ints
from grammarlab.derivation.forest import Forest
from grammarlab.derivation.tracing import origin_of, way_to
from grammarlab.language.numbering import Numbering
from grammarlab.learning.designs.design_space import AbstractParts
from grammarlab.scene.triangles import leaf_of_triangle


@dataclass(frozen=True)
class GrammarParts(AbstractParts):
    """The leaves of one model that have triangles, in the order of the derivation."""

    forest: Forest
    """The model alone."""
    numbering: Numbering
    """Of its grammar."""

    @property
    def of_triangles(self) -> Ints:
        return self._found[1]

    def way_to(self, part: int) -> tuple[tuple[str, str], ...]:
        node = int(self.forest.leaves.node[self._found[0][part]])
        return tuple(self._step(above) for above in way_to(self.forest, node))

    @cached_property
    def _found(self) -> tuple[Ints, Ints]:
        """Rows of the leaves [P], and the part of each triangle [T]."""
        leaf = leaf_of_triangle(self.forest)
        rows, place = np.unique(leaf, return_inverse=True)
        order = np.argsort(self.forest.leaves.node[rows], kind="stable")
        rank = np.empty_like(order)
        rank[order] = np.arange(len(order))
        return rows[order], rank[place.ravel()]

    def _step(self, node: int) -> tuple[str, str]:
        origin = origin_of(self.forest, self.numbering, node)
        return origin.symbol, str(origin.rule_at or origin.made_at or "")
