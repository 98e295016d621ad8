"""Probabilities of choices learned from few examples: shrunk towards a grammar, by their exact posterior mean.

A preference about a choice has one level per branch, and branches often share a level. So the prior is a
product partition model (Barry and Hartigan, Product partition models for change point problems, 1992): the branches
fall into groups, a group has a probability drawn from a Dirichlet distribution around its original one, and inside a
group the original proportions stay. Groups of a drawn number are ranges, so that a sum over all partitions is a
recursion; partitions of other choices are enumerated.

Most choices of a grammar are irrelevant to a preference. So each keeps its original probabilities, unless levels of its
own make the examples much more likely: the spike-and-slab prior. About one choice of each kind is expected to matter,
so the prior odds fall with the number of choices; choices that decide more of a model are more likely to matter than
details.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache, cached_property
from itertools import combinations

import numpy as np
from scipy import sparse
from scipy.special import expit, gammaln

from grammarlab.arrays import MANY, Flags, Floats, Ints
from grammarlab.density.samples.mixture import Cells, dense

Groups = tuple[tuple[int, ...], ...]
CONCENTRATIONS = np.array([1.0, 4.0])
"""Candidate weights of the prior, as numbers of derivations by the original grammar; averaged by evidence."""
_MAX_ENUMERATED = 5
"""Largest number of branches with all partitions; of more, one or two against the rest and all singletons are used."""
_EXPECTED_CUTS = 2.0
"""Expected number of cuts of a drawn number."""
_EXTENT_SHARE = 0.5
"""Share of the prior probability that is distributed over choices of rules by their extents; the rest is uniform."""
_MIN_RELEVANCE = 0.2
"""Choices with a smaller probability of mattering are unchanged, so that the grammar stays readable."""


@dataclass(frozen=True, slots=True)
class LevelPosterior:
    """Posterior of each choice, if it is learned, for K sets of examples."""

    evidence: Floats
    """[K, choices] log of the probability of the examples, divided by that under the original grammar."""
    ratio: Floats
    """[K, A] posterior mean of each cell's probability divided by the original one; 1 where that is 0."""


@dataclass(frozen=True)
class ProbabilityPrior:
    """Prior of the probabilities of choices."""

    cells: Cells
    ordered: tuple[Ints, ...]
    """Cells [choices, length] of the choices whose groups are ranges, for each length."""
    groups: sparse.csr_array
    """[A, G] whether each group of each partition of the other choices has a cell."""
    partition: Ints
    """[G] partition of each group, ascending from 0."""
    choice: Ints
    """[P] choice of each partition, ascending."""
    prior: Floats
    """[P] log of the prior probability of each partition, among the partitions of its choice."""

    @classmethod
    def of(cls, cells: Cells, ordered: Flags) -> ProbabilityPrior:
        """The prior for choices.

        Args:
            cells: branches of the choices.
            ordered: [choices] whether the branches of each are ranges of a number, or numbers that ascend.
        """
        possible = [np.flatnonzero((cells.choice == i) & (cells.original > 0.0)) for i in range(len(ordered))]
        ranges: dict[int, list[Ints]] = {}
        columns: list[Ints] = []
        partition: list[int] = []
        choice: list[int] = []
        prior: list[float] = []
        for number, members in enumerate(possible):
            if len(members) > 1 and ordered[number]:
                ranges.setdefault(len(members), []).append(members)
            elif len(members) > 1:
                for groups, weight in _partitions(len(members)):
                    columns += [members[list(group)] for group in groups]
                    partition += [len(choice)] * len(groups)
                    choice.append(number)
                    prior.append(weight)
        sizes = [len(column) for column in columns]
        cell_indices = np.concatenate([*columns, np.zeros(0, dtype=np.int64)]).astype(np.int64)
        shape = len(cells.original), len(columns)
        return cls(
            cells,
            tuple(np.stack(same_length) for same_length in ranges.values()),
            sparse.csr_array(
                (np.ones(len(cell_indices)), (cell_indices, np.repeat(np.arange(len(sizes)), sizes))), shape=shape
            ),
            np.array(partition, dtype=np.int64),
            np.array(choice, dtype=np.int64),
            np.array(prior),
        )

    def posterior(self, counts: Floats) -> LevelPosterior:
        """Posterior from counts of cells [K, A] in K sets of examples."""
        evidence = np.zeros((len(counts), int(self.cells.choice.max(initial=-1)) + 1))
        ratio = np.ones(counts.shape)
        if len(self.choice):
            self._enumerated(counts, evidence, ratio)
        for members in self.ordered:
            original = self.cells.original[members] / self.cells.original[members].sum(axis=1, keepdims=True)
            log_evidence, mean = _ranges(counts[:, members], original)
            evidence[:, self.cells.choice[members[:, 0]]] = log_evidence
            ratio[:, members] = mean
        return LevelPosterior(evidence, ratio)

    def _enumerated(self, counts: Floats, evidence: Floats, ratio: Floats) -> None:
        starts = np.flatnonzero(np.diff(self.partition, prepend=-1))
        first = np.flatnonzero(np.diff(self.choice, prepend=-1))
        original = np.asarray(self.cells.original @ self.groups)
        original = original / np.add.reduceat(original, starts)[self.partition]
        group_counts = dense(counts @ self.groups)[:, None]
        total = np.add.reduceat(group_counts, starts, axis=2)
        prior = CONCENTRATIONS[:, None] * original
        logs = np.add.reduceat(_log_ratio(group_counts, prior, original), starts, axis=2) + self.prior
        logs += _log_norm(total, CONCENTRATIONS[:, None])
        # [K, partitions] with the concentration summed out, then [K, choices].
        most = np.maximum.reduceat(logs.max(axis=1), first, axis=1)
        choice_of = np.repeat(np.arange(len(first)), np.diff(np.append(first, len(self.choice))))
        weight = np.exp(logs - most[:, None, choice_of])
        sums = np.add.reduceat(weight.sum(axis=1), first, axis=1)
        evidence[:, self.choice[first]] = np.log(sums / len(CONCENTRATIONS)) + most
        mean = (prior + group_counts) / (CONCENTRATIONS[:, None] + total[..., self.partition]) / original
        share = weight / sums[:, None, choice_of]
        is_learned = np.isin(self.cells.choice, self.choice[first]) & (self.cells.original > 0.0)
        ratio[:, is_learned] = dense((mean * share[..., self.partition]).sum(axis=1) @ self.groups.T)[:, is_learned]


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
            ordered: [choices] whether the branches of each are ranges of a number (`ProbabilityPrior.of`).
            drawn: [choices] whether each is an attribute or a choice of a rule; one of each kind is expected to matter.
            counts: [N, A] count of each cell in each example.
            weights: [N] weight of each example, >= 0.
            extents: [choices] share of a model that each choice of a rule decides (`Choices.extents`); equal if
                default.
        """
        total = np.asarray(weights @ counts)
        spread = _spread(cells, counts, weights)
        is_used = np.bincount(cells.choice, weights=total, minlength=len(drawn)) > 0.0
        number = np.where(drawn, np.count_nonzero(is_used & drawn), np.count_nonzero(is_used & ~drawn))
        prior = 1.0 / np.maximum(number, 1.0)
        if extents is not None and (extent := np.where(is_used & ~drawn, extents, 0.0)).any():
            prior = np.where(drawn, prior, (1.0 - _EXTENT_SHARE) * prior + _EXTENT_SHARE * extent / extent.sum())
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
        probability = expit(self.odds + self.posterior.evidence[0])
        return np.where(probability < _MIN_RELEVANCE, 0.0, probability)

    @cached_property
    def probabilities(self) -> Floats:
        """[A] posterior mean of each cell's probability."""
        ratio = 1.0 + self.relevance[self.cells.choice] * (self.posterior.ratio[0] - 1.0)
        return self.cells.original * ratio


def averaged(odds: Floats, evidence: Floats) -> Floats:
    """Log-evidence of choices that matter with some prior odds, from the evidence if they do."""
    return np.logaddexp(0.0, odds + evidence) - np.logaddexp(0.0, odds)


@cache
def _partitions(size: int) -> tuple[tuple[Groups, float], ...]:
    """Partitions of branches into two groups or more with log-probabilities: their number is drawn first."""
    if size <= _MAX_ENUMERATED:
        partitions = [groups for groups in _all(size) if len(groups) > 1]
    else:
        subsets = [subset for most in (1, 2)[: 1 + (size <= MANY)] for subset in combinations(range(size), most)]
        rest = [tuple(i for i in range(size) if i not in subset) for subset in subsets]
        partitions = [*zip(subsets, rest, strict=True), tuple((i,) for i in range(size))]
    numbers = [len(groups) for groups in partitions]
    prior = {number: -np.log(len(set(numbers)) * numbers.count(number)) for number in numbers}
    return tuple((groups, float(prior[len(groups)])) for groups in partitions)


def _all(size: int) -> Iterator[Groups]:
    """All partitions of branches."""
    if size == 0:
        yield ()
        return
    for groups in _all(size - 1):
        for index, group in enumerate(groups):
            yield (*groups[:index], (*group, size - 1), *groups[index + 1 :])
        yield (*groups, (size - 1,))


def _ranges(counts: Floats, original: Floats) -> tuple[Floats, Floats]:
    """Sums over all partitions of choices into ranges.

    Args:
        counts: [K, choices, cells] counts of the cells.
        original: [choices, cells] summing to 1.

    Returns:
        [K, choices] log-evidence and [K, choices, cells] posterior mean by the original probability.
    """
    size = original.shape[1]
    low, high = np.triu_indices(size + 1, 1)
    ends = np.concatenate([np.zeros((*original.shape[:-1], 1)), np.cumsum(original, axis=-1)], axis=-1)
    cumulative = np.concatenate([np.zeros((*counts.shape[:-1], 1)), np.cumsum(counts, axis=-1)], axis=-1)
    share = ends[:, high] - ends[:, low]
    range_counts = (cumulative[..., high] - cumulative[..., low])[:, None]
    concentration = CONCENTRATIONS[:, None, None]
    cut = min(0.5, _EXPECTED_CUTS / size)
    log_weights = np.full((len(counts), len(CONCENTRATIONS), len(original), size + 1, size + 1), -np.inf)
    # A range from `low` to `high` ends in a cut, except at the end of the number, and has none inside.
    log_weights[..., low, high] = _log_ratio(range_counts, concentration * share, share)
    log_weights[..., low, high] += (high - low - 1) * np.log1p(-cut) + np.where(high < size, np.log(cut), 0.0)
    ahead = np.full(log_weights.shape[:-1], -np.inf)
    behind = np.full(log_weights.shape[:-1], -np.inf)
    ahead[..., 0] = behind[..., size] = 0.0
    for end in range(1, size + 1):
        ahead[..., end] = np.logaddexp.reduce(ahead[..., :end] + log_weights[..., :end, end], axis=-1)
    for start in range(size - 1, -1, -1):
        behind[..., start] = np.logaddexp.reduce(
            behind[..., start + 1 :] + log_weights[..., start, start + 1 :], axis=-1
        )
    total = cumulative[..., -1:][:, None]
    logs = ahead[..., size] + _log_norm(total, concentration)[..., 0]
    evidence = np.logaddexp.reduce(logs, axis=1)
    logs = logs - evidence[:, None] - ahead[..., size]
    weight = np.exp(ahead[..., low] + log_weights[..., low, high] + behind[..., high] + logs[..., None])
    value = (weight * (concentration * share + range_counts) / (concentration + total) / share).sum(axis=1)
    inside = (np.arange(size) >= low[:, None]) & (np.arange(size) < high[:, None])
    return evidence - np.log(len(CONCENTRATIONS)), value @ inside


def _log_ratio(group_counts: Floats, prior: Floats, original: Floats) -> Floats:
    """A group's share in the log-evidence."""
    return gammaln(prior + group_counts) - gammaln(prior) - group_counts * np.log(original)


def _log_norm(total: Floats, concentration: Floats) -> Floats:
    return gammaln(concentration) - gammaln(concentration + total)


def _spread(cells: Cells, counts: sparse.csr_array, weights: Floats) -> Floats:
    """[A] overdispersion of each choice between examples, >= 1.

    A choice that is made several times in an example, always alike, has the information of one (McCullagh and Nelder,
    Generalized linear models, 4.5): Pearson's statistic divided by its degrees of freedom.
    """
    table = dense(counts)
    total = weights @ table
    number = int(cells.choice.max(initial=-1)) + 1
    to_choice = sparse.csr_array((np.ones(len(total)), (np.arange(len(total)), cells.choice)), (len(total), number))
    choice_counts = table @ to_choice
    expected = choice_counts[:, cells.choice] * cells.normalised(total[None])[0]
    squares = np.divide((table - expected) ** 2, expected, out=np.zeros_like(table), where=expected > 0.0)
    freedom = (weights @ (choice_counts > 0.0) - 1.0) * (((total > 0.0) @ to_choice) - 1.0)
    several = (freedom > 0.0) & (choice_counts.max(axis=0, initial=0.0) > 1.0)
    overdispersion = np.divide((weights @ squares) @ to_choice, freedom, out=np.ones(number), where=several)
    return np.maximum(overdispersion, 1.0)[cells.choice]
