"""The quantities that everything else is made of: counts of nodes, draws, and choices at places."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from grammarlab.derivation.forest import Forest, Site
from grammarlab.features.columns.paths import is_quantity
from grammarlab.features.patterns.counts import count
from grammarlab.features.patterns.pattern import Below, Draw, Pattern
from grammarlab.tastes.labelled_nodes import LabelledNodes
from grammarlab.tastes.quantities import Quantities, joined

_MAX_COUNTS = 4_000
"""Largest number of counts of one kind."""
_MIN_NUMERAL_VALUES = 3
"""Smallest number of values of a count that is a number of things, instead of whether there is one."""


@dataclass(frozen=True)
class Elements:
    """Quantities of n models of one grammar that vary among them."""

    forests: tuple[Forest, ...]
    nodes: LabelledNodes

    @classmethod
    def of(cls, forests: Sequence[Forest]) -> Elements:
        """The quantities of models.

        Raises:
            UsageError: If the columns of a forest are not trees.
        """
        return cls(tuple(forests), LabelledNodes.of(forests))

    @property
    def num(self) -> int:
        """Number of models."""
        return self.nodes.num_models

    @cached_property
    def branches(self) -> Quantities:
        """Counts of the branches of rules."""
        nodes, labels = self.nodes, self.nodes.labels
        counts = nodes.count(nodes.model, nodes.label, labels.unknown + 1)
        used = list(nodes.alternatives)[:_MAX_COUNTS]
        return Quantities(tuple(map(nodes.pattern, used)), counts[:, used])

    @cached_property
    def symbols(self) -> Quantities:
        """Counts of the nodes of each symbol."""
        nodes, names = self.nodes, self.nodes.labels.symbols[:_MAX_COUNTS]
        inside = nodes.symbol < len(names)
        counts = nodes.count(nodes.model[inside], nodes.symbol[inside], len(names))
        return Quantities(tuple(map(Pattern, names)), counts)

    @cached_property
    def children(self) -> Quantities:
        """Counts of the nodes of a symbol that are children of another symbol."""
        nodes, size = self.nodes, len(self.nodes.labels.symbols)
        inner = np.flatnonzero(nodes.parent >= 0)
        codes = nodes.symbol[nodes.parent[inner]] * size + nodes.symbol[inner]
        kinds, index = np.unique(codes, return_inverse=True)
        kinds, kept = kinds[:_MAX_COUNTS], index < _MAX_COUNTS
        counts = nodes.count(nodes.model[inner[kept]], index[kept], len(kinds))
        names = [[nodes.labels.symbols[number] for number in divmod(kind, size)] for kind in kinds.tolist()]
        return Quantities(tuple(Pattern(above, below=(Below((Pattern(one),)),)) for above, one in names), counts)

    @cached_property
    def outcomes(self) -> Quantities:
        """Counts of the outcomes of random choices outside rules, such as those of attributes."""
        symbols = set(self.nodes.labels.symbols)
        choices = {
            site.name: max(site.choices, 2)
            for site in self._sites
            if not is_quantity(site) and site.definition not in symbols
        }
        return self._counted([Draw(name, branch) for name, number in choices.items() for branch in range(number)])

    @cached_property
    def draws(self) -> Quantities:
        """Random numbers."""
        return varying(self._counted([Draw(name) for name in self._names]))

    @cached_property
    def counts(self) -> Quantities:
        """All counts that vary, once each; branches before symbols before children."""
        return distinct(joined([self.branches, self.symbols, self.outcomes, self.children], self.num))

    @cached_property
    def numerals(self) -> Quantities:
        """Counts of three values or more: numbers of things."""
        several = [len(np.unique(column)) >= _MIN_NUMERAL_VALUES for column in self.counts.values.T]
        return self.counts.take(np.flatnonzero(several))

    @cached_property
    def flags(self) -> Quantities:
        """Counts that are 0 or 1."""
        return self.counts.take(np.flatnonzero(self.counts.values.max(axis=0, initial=0.0) == 1.0))

    @property
    def _sites(self) -> tuple[Site, ...]:
        return self.forests[0].sites if self.forests else ()

    @property
    def _names(self) -> list[str]:
        return list(dict.fromkeys(site.name for site in self._sites if is_quantity(site)))

    def _counted(self, features: Sequence[Draw]) -> Quantities:
        values = np.concatenate([np.zeros((0, len(features))), *(count(f, features) for f in self.forests)])
        return Quantities(tuple(features), values)


def varying(quantities: Quantities) -> Quantities:
    """The quantities that are not the same in all models."""
    return quantities.take(np.flatnonzero(np.ptp(quantities.values, axis=0) > 0.0)) if len(quantities) else quantities


def distinct(quantities: Quantities) -> Quantities:
    """The quantities that vary, without those equal to an earlier one."""
    first: dict[bytes, int] = {}
    for index, column in enumerate(quantities.values.T):
        if len(column) and np.ptp(column) > 0.0:
            first.setdefault(column.tobytes(), index)
    return quantities.take(np.array(list(first.values()), dtype=np.int64))
