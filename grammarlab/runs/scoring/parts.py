"""The visible shapes of a model that is looked at, and the rules that made them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from grammarlab.arrays import Ints
from grammarlab.derivation.forest import Forest
from grammarlab.derivation.tracing import origin_of, way_to
from grammarlab.errors import UsageError
from grammarlab.language.numbering import Numbering
from grammarlab.runs.scoring.tasks import Part
from grammarlab.scene.triangles import leaf_of_triangle


@dataclass(frozen=True, slots=True)
class PartFinder:
    """The parts of one model."""

    model: str
    """Address."""
    forest: Forest
    """The model alone."""
    numbering: Numbering
    leaf: Ints
    """[T] row of the leaf of each triangle of its file."""
    parts: Ints
    """[P] rows of the leaves that have triangles, in the order of the derivation."""

    @classmethod
    def of(cls, model: str, forest: Forest, numbering: Numbering) -> PartFinder:
        """The parts of a model.

        Args:
            model: its address.
            forest: the model alone.
            numbering: of its grammar.
        """
        leaf = leaf_of_triangle(forest)
        rows = np.unique(leaf)
        return cls(model, forest, numbering, leaf, rows[np.argsort(forest.leaves.node[rows], kind="stable")])

    def find(self, number: int, is_triangle: bool) -> Part:
        """A part by its number, counted round and round, or by the number of one of its triangles.

        Raises:
            UsageError: when there is no such triangle, or no part at all.
        """
        if not len(self.parts):
            raise UsageError("the model has no visible part.")
        if is_triangle and not 0 <= number < len(self.leaf):
            raise UsageError(f"triangle: expected 0 to {len(self.leaf) - 1}, found {number}.")
        row = self.leaf[number] if is_triangle else self.parts[number % len(self.parts)]
        triangles = np.flatnonzero(self.leaf == row)
        node = int(self.forest.leaves.node[row])
        return Part(
            int(np.flatnonzero(self.parts == row)[0]),
            len(self.parts),
            (int(triangles[0]), int(triangles[-1]) + 1),
            tuple(self._step(node) for node in way_to(self.forest, node)),
        )

    def _step(self, node: int) -> tuple[str, str]:
        origin = origin_of(self.forest, self.numbering, node)
        return origin.symbol, str(origin.rule_at or origin.made_at or "")
