"""Scores with the columns that may explain them."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from grammarlab.arrays import Floats, Ints
from grammarlab.preference.judge.cuts import MAX_BINS, BinnedColumns
from grammarlab.preference.judge.leaf_evidence import LeafEvidence
from grammarlab.preference.judge.unexplained_scores import UnexplainedScores
from grammarlab.preference.person import Person


class Explanation(NamedTuple):
    """What the best explanation of a kind uses."""

    total: float
    """Evidence minus description length, in nats."""
    columns: frozenset[int]
    person: Person


@dataclass(frozen=True, eq=False)
class Labels:
    """n scores and F columns."""

    values: Floats
    """[n, F] columns."""
    binned: BinnedColumns
    """The columns in bins."""
    prices: Floats
    """[F] description length of each column, in nats."""
    scores: Floats
    """[n] 0-100."""
    unexplained: UnexplainedScores
    """Evidence of the scores without columns."""

    @classmethod
    def of(cls, values: Floats, prices: Floats, scores: Floats, num_bins: int = MAX_BINS) -> Labels:
        """Scores [n] with columns [n, F] in at most so many bins."""
        return cls(values, BinnedColumns.of(values, num_bins), prices, scores, UnexplainedScores.of(scores))

    @cached_property
    def every(self) -> Ints:
        """[n] indices of all labels."""
        return np.arange(len(self.scores))

    def joined(self, values: Floats, prices: Floats) -> Labels:
        """The same scores with further columns [n, C] after these."""
        return replace(
            self,
            values=np.concatenate([self.values, values], axis=1),
            binned=self.binned + BinnedColumns.of(values),
            prices=np.append(self.prices, prices),
        )

    def evidence(self, person: Person) -> LeafEvidence:
        """Evidence of leaves for a person."""
        return LeafEvidence.of(self.scores, self.unexplained, person.noise, person.blunders)
