"""The nodes of all derivation trees of several forests as columns, with the same labels."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from grammarlab.arrays import Floats, Ints
from grammarlab.derivation.forest import Forest
from grammarlab.features.columns.column_keys import Meaning
from grammarlab.features.columns.column_names import ColumnNames
from grammarlab.features.patterns.node_labels import NodeLabels
from grammarlab.features.patterns.pattern import Pattern
from grammarlab.features.patterns.tree_index import Trees


@dataclass(frozen=True)
class LabelledNodes:
    """N nodes of n models."""

    labels: NodeLabels
    num_models: int
    model: Ints
    """[N] model, counted across forests."""
    parent: Ints
    """[N] row of the parent, -1 for a root."""
    label: Ints
    """[N] see `NodeLabels`."""
    child: Ints
    """[N] index among the successors of the parent."""
    following: Ints
    """[N] row of the next sibling, -1 for none."""

    @classmethod
    def of(cls, forests: Sequence[Forest]) -> LabelledNodes:
        """The nodes of models of one grammar.

        Raises:
            UsageError: If the columns of a forest are not trees.
        """
        labels = NodeLabels.of(forests)
        parts, models, rows = list[Ints]([np.zeros((5, 0), dtype=np.int64)]), 0, 0
        for trees in map(Trees, forests):
            nodes = trees.forest.nodes
            links = [np.where(link >= 0, link + rows, -1) for link in (trees.parent, trees.next_sibling)]
            model = nodes.model.astype(np.int64) + models
            parts.append(np.stack([model, links[0], trees.labels(labels), nodes.child.astype(np.int64), links[1]]))
            models, rows = models + trees.num_models, rows + len(nodes)
        return cls(labels, models, *np.concatenate(parts, axis=1))

    def count(self, models: Ints, kinds: Ints, number: int) -> Floats:
        """[n, number] how often each kind [K] of 0 to number - 1 occurs in the models [K] that go with them."""
        codes = np.bincount(models * number + kinds, minlength=self.num_models * number)
        return codes.reshape(self.num_models, number).astype(np.float64)

    @cached_property
    def symbol(self) -> Ints:
        """[N] symbol of each node."""
        return self.labels.symbol_numbers[self.label]

    @cached_property
    def meaning(self) -> Meaning:
        """Patterns of labels."""
        return Meaning(self.labels, (), ())

    @cached_property
    def names(self) -> ColumnNames:
        """Words for branches."""
        return ColumnNames(self.labels, self.meaning)

    def pattern(self, label: int) -> Pattern:
        """The nodes of a label."""
        labels = self.labels
        return self.meaning.node(label) if label < len(labels.rules) else Pattern(labels.symbol_of(label))

    @cached_property
    def alternatives(self) -> tuple[int, ...]:
        """Labels of rules that have alternatives."""
        return tuple(label for label in range(len(self.labels.rules)) if len(self.labels.alternatives(label)) > 1)
