"""Choices learned from few examples: probability that each matters, and its shrunk probabilities.

Most choices of a grammar are irrelevant to a preference. So each keeps its original probabilities, unless levels of its
own make the examples much more likely: the spike-and-slab prior. About one choice of each kind is expected to matter,
so the prior odds fall with the number of choices; choices that decide more of a model are more likely to matter than
details.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.special import expit

from grammarlab.density.mixtures.mixture import Cells, dense
from grammarlab.density.samples.levels import LevelPosterior, ProbabilityPrior

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]

_BY_EXTENT = 0.5
"""Share of the prior probability that is distributed over choices of rules by their extents; the rest is uniform."""
_DOUBTFUL = 0.2
"""Choices with a smaller probability of mattering are unchanged, so that the grammar stays readable."""


@dataclass(frozen=True)
class Shrinkage:
    """Choices, the prior of each, and the total counts of all examples."""

    levels: ProbabilityPrior
    odds: Floats
    """[choices] log of the prior odds that each matters."""
    total: Floats
    """[A] count of each cell in the examples, divided by `spread`."""
    spread: Floats
    """[A] overdispersion of the choice between examples, >= 1."""

    @classmethod
    def of(
        cls,
        cells: Cells,
        ordered: Flags,
        drawn: Flags,
        counts: sparse.csr_array,
        weights: Floats,
        extents: Floats | None = None,
    ) -> Shrinkage:
        """Choices of a grammar.

        Args:
            cells: cells of the choices.
            ordered: see `ProbabilityPrior.of`.
            drawn: [choices] whether each is an attribute or a choice of a rule; one of each kind is expected to matter.
            counts: [N, A] count of each cell in each example.
            weights: [N] weight of each example, >= 0.
            extents: [choices] share of a model that each choice of a rule decides (`Choices.extents`); equal if
                default.
        """
        total = np.asarray(weights @ counts)
        spread = _spread(cells, counts, weights)
        made = np.bincount(cells.choice, weights=total, minlength=len(drawn)) > 0.0
        number = np.where(drawn, np.count_nonzero(made & drawn), np.count_nonzero(made & ~drawn))
        prior = 1.0 / np.maximum(number, 1.0)
        if extents is not None and (extent := np.where(made & ~drawn, extents, 0.0)).any():
            prior = np.where(drawn, prior, (1.0 - _BY_EXTENT) * prior + _BY_EXTENT * extent / extent.sum())
        return cls(ProbabilityPrior.of(cells, ordered), np.log(prior), total / spread, spread)

    @property
    def cells(self) -> Cells:
        """The branches of the choices."""
        return self.levels.cells

    @cached_property
    def posterior(self) -> LevelPosterior:
        """Posterior from all examples; K is 1."""
        return self.levels.posterior(self.total[None])

    @cached_property
    def evidence(self) -> Floats:
        """[choices] log of the ratio of the examples' probability to that under the original grammar."""
        return averaged(self.odds, self.posterior.evidence[0])

    @cached_property
    def relevance(self) -> Floats:
        """[choices] probability that each matters; 0 for doubtful ones."""
        found = expit(self.odds + self.posterior.evidence[0])
        return np.where(found < _DOUBTFUL, 0.0, found)

    @cached_property
    def probabilities(self) -> Floats:
        """[A] posterior mean of each cell's probability."""
        ratio = 1.0 + self.relevance[self.cells.choice] * (self.posterior.ratio[0] - 1.0)
        return self.cells.original * ratio


def _spread(cells: Cells, counts: sparse.csr_array, weights: Floats) -> Floats:
    """[A] overdispersion of each choice between examples, >= 1.

    A choice that is made several times in an example, always alike, has the information of one (McCullagh and Nelder,
    Generalized linear models, 4.5): Pearson's statistic divided by its degrees of freedom.
    """
    table = dense(counts)
    total = weights @ table
    number = int(cells.choice.max(initial=-1)) + 1
    to_choice = sparse.csr_array((np.ones(len(total)), (np.arange(len(total)), cells.choice)), (len(total), number))
    made = table @ to_choice
    expected = made[:, cells.choice] * cells.normalised(total[None])[0]
    squares = np.divide((table - expected) ** 2, expected, out=np.zeros_like(table), where=expected > 0.0)
    freedom = (weights @ (made > 0.0) - 1.0) * (((total > 0.0) @ to_choice) - 1.0)
    several = (freedom > 0.0) & (made.max(axis=0, initial=0.0) > 1.0)
    found = np.divide((weights @ squares) @ to_choice, freedom, out=np.ones(number), where=several)
    return np.maximum(found, 1.0)[cells.choice]


def averaged(odds: Floats, evidence: Floats) -> Floats:
    """Log-evidence of choices that matter with some prior odds, from the evidence if they do."""
    return np.logaddexp(0.0, odds + evidence) - np.logaddexp(0.0, odds)
