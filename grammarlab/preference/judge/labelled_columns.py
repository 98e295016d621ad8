"""Scores with the columns that may explain them."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from grammarlab.arrays import Floats, Ints
from grammarlab.preference.growth.split_columns import SplitColumns
from grammarlab.preference.judge.leaf_evidence import LeafEvidence
from grammarlab.preference.person import START_PERSONS, Person

MAX_LABELS = 384
"""Largest number of labels that trees and lines are fitted to, an even selection by score. More are only slower."""


class Explanation(NamedTuple):
    """What the best explanation of a kind uses."""

    total: float
    """Evidence minus description length, in nats."""
    columns: frozenset[int]
    person: Person


@dataclass(frozen=True, eq=False)
class Labels:
    """n scores and F columns."""

    columns: SplitColumns
    """The columns, each with its price."""
    evidence: LeafEvidence
    """Evidence of the scores, for any person."""

    @classmethod
    def of(cls, values: Floats, prices: Floats, scores: Floats) -> Labels:
        """Scores [n] with columns [n, F] and their prices [F] in nats."""
        return cls(SplitColumns.plain(values, prices), LeafEvidence.of(scores, START_PERSONS[0]))

    @property
    def values(self) -> Floats:
        """[n, F] columns."""
        return self.columns.values

    @property
    def prices(self) -> Floats:
        """[F] description length of each column, in nats."""
        return self.columns.prices

    @property
    def scores(self) -> Floats:
        """[n] 0-100."""
        return self.evidence.scores

    @cached_property
    def every(self) -> Ints:
        """[n] indices of all labels."""
        return np.arange(len(self.scores))

    def joined(self, values: Floats, prices: Floats) -> Labels:
        """The same scores with further columns [n, C] after these."""
        every = np.concatenate([self.values, values], axis=1), np.append(self.prices, prices)
        return replace(self, columns=SplitColumns.plain(*every))


def selected(scores: Floats) -> Ints:
    """Ascending indices of at most `MAX_LABELS` labels, an even selection by score."""
    num = min(MAX_LABELS, len(scores))
    return np.sort(np.argsort(scores, kind="stable")[np.arange(num) * len(scores) // max(num, 1)])
