"""Dependent choices: blocks of choices with mixtures of their own, and gates found in few examples.

Independent blocks are learned separately, and their mixtures multiplied. Where the legs of a table and its wood are
chosen independently, three kinds of legs and three woods are nine components of one mixture, each learned from a ninth
of the examples; as two mixtures of three, each is learned from a third.

With few examples, one choice is the gate, and others depend on its branch. A gate that is made once in every example
determines the component of the example: its branches fall into groups, and for each group the other choices may have
their own levels. For a choice that is made several times, the counts of each example are the gate; then the groups pay
for their number and sizes (Chinese restaurant process). A gate is used if it raises the likelihood of the examples by
more than the number of possible gates.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import reduce
from itertools import combinations

import numpy as np
from scipy import sparse
from scipy.sparse.csgraph import connected_components
from scipy.special import expit, gammaln, xlogy

from grammarlab.arrays import FEW, NUM_LEVELS, SEVERAL, Flags, Floats, Ints
from grammarlab.density.samples.levels import ProbabilityPrior, Shrinkage, averaged
from grammarlab.density.samples.mixture import Cells, Mixture, dense, fit_mixture, merged
from grammarlab.density.samples.sampled import MAX_COMPONENTS, Sample, chosen_components, kinds

_MIN_DEVIATION = 5.0
"""Smallest deviation of dependent choices, in standard deviations."""
_NUM_RANGES = 4
"""Number of ranges of a drawn number that is a gate."""
_MIN_GAIN = 2.0
"""Gain in nats beyond their prior that guessed groups need, since they are the best of many."""


@dataclass(frozen=True, slots=True)
class BlockFit:
    """A fitted mixture of blocks."""

    mixture: Mixture
    num_parameters: int
    """Number of estimated free parameters."""


@dataclass(frozen=True, slots=True)
class Gate:
    """A gate with the choices that depend on it."""

    cells: Ints
    """The cells of all these choices."""
    mixture: Mixture
    """Mixture of these cells."""
    gain: float
    """Log of the ratio of the evidence with and without it, prior included."""


@dataclass(frozen=True, slots=True)
class Gated:
    """Learned choices and gates."""

    mixture: Mixture
    evidence: float
    """Log of the probability of the examples, divided by that under the original grammar."""


def dependent_choices(cells: Cells, counts: sparse.csr_array, weights: Floats) -> Flags:
    """[choices, choices] whether choices of the derivations depend on each other significantly.

    Args:
        cells: the choices.
        counts: [N, A] how often each derivation took each cell.
        weights: [N] how much each derivation counts.
    """
    size = int(cells.choice.max(initial=-1)) + 1
    spread = np.zeros((size, len(cells.choice)))
    spread[cells.choice, np.arange(len(cells.choice))] = 1.0
    table, total = dense(counts), np.asarray(weights @ counts)
    # Deviation of each count from its expectation, given that the choice is made: uncorrelated in a grammar.
    rest = (table - (table @ spread.T @ spread) * cells.normalised(total[None])) * np.sqrt(weights)[:, None]
    product, scale = rest.T @ rest, (rest**2).T @ (rest**2)
    score = np.abs(product) / np.sqrt(np.where(scale > 0.0, scale, np.inf))
    dependent = spread @ (score > _MIN_DEVIATION) @ spread.T > 0.0
    np.fill_diagonal(dependent, False)
    single = (table @ spread.T).max(axis=0, initial=0.0) <= 1.0
    for first, second in np.argwhere(dependent & single & single[:, None]):
        columns = table[:, cells.choice == first], table[:, cells.choice == second]
        dependent[first, second] = information(columns[0].T @ (weights[:, None] * columns[1])) > 0.0
    return dependent


def information(together: Floats) -> float:
    """Gain of the dependence of two choices in nats, minus the price of its parameters (BIC).

    Args:
        together: [branches, branches] how often each pair was taken.
    """
    total, rows, columns = together.sum(), together.sum(axis=1), together.sum(axis=0)
    gain = xlogy(together, together).sum() - xlogy(rows, rows).sum() - xlogy(columns, columns).sum()
    num_parameters = max(0, np.count_nonzero(rows) - 1) * max(0, np.count_nonzero(columns) - 1)
    return float(gain + xlogy(total, total) - 0.5 * num_parameters * np.log(max(total, 1.0)))


def fit_blocks(cells: Cells, counts: sparse.csr_array, weights: Floats, together: Flags) -> BlockFit:
    """A mixture for each block of dependent choices, combined into one mixture.

    Held-out derivations decide the number of components of each.

    Args:
        cells: cells of the learned choices.
        counts: [N, A] how often each derivation took each cell.
        weights: [N] how much each derivation counts, >= 0 and not all 0.
        together: [choices, choices] which choices depend on each other.
    """
    number, block = connected_components(sparse.csr_array(together), directed=False)
    parts = [np.flatnonzero(block[cells.choice] == i) for i in range(number)]
    fitted = [_fitted(cells, counts, weights, part) for part in parts]
    if len(parts) < 2 or np.prod([float(len(fit.mixture.weights)) for fit in fitted]) > MAX_COMPONENTS:
        return _fitted(cells, counts, weights, np.arange(len(cells.choice)))
    mixture = multiplied(parts, [fit.mixture for fit in fitted], len(cells.choice))
    return BlockFit(mixture, sum(fit.num_parameters for fit in fitted))


def multiplied(parts: Sequence[Ints], mixtures: Sequence[Mixture], size: int) -> Mixture:
    """All combinations of the components of mixtures of different cells."""
    weights = reduce(np.multiply.outer, [mixture.weights for mixture in mixtures]).reshape(-1)
    chosen = np.indices([len(mixture.weights) for mixture in mixtures]).reshape(len(mixtures), -1)
    probabilities = np.zeros((len(weights), size))
    for part, mixture, component in zip(parts, mixtures, chosen, strict=True):
        probabilities[:, part] = mixture.probabilities[component]
    return Mixture(weights, probabilities)


def gated(shrinkage: Shrinkage, counts: sparse.csr_array, weights: Floats, ordered: Flags) -> Gated:
    """The most likely model of the choices, independent or with gates.

    Args:
        shrinkage: the choices, each alone.
        counts: [N, A] counts of cells in each example.
        weights: [N] weight of each example, >= 0 and not all 0.
        ordered: [choices] whether the branches of each are ranges of a number (`ProbabilityPrior.of`).
    """
    cells = shrinkage.cells
    used = weights > 0.0
    counts, weights = counts[used], weights[used]
    open_choices = np.ones(len(shrinkage.odds), dtype=bool)
    strength = _strength(shrinkage, counts, weights, ordered)
    gates: list[Gate] = []
    while len(gates) < FEW:
        candidates = _candidates(strength, open_choices)
        if not len(candidates):
            break
        search = _GateSearch(shrinkage, counts, weights, ordered, candidates)
        best = max(search.gates(), key=lambda gate: gate.gain, default=None)
        if best is None or best.gain <= 0.0:
            break
        gates.append(best)
        open_choices[cells.choice[best.cells]] = False
    single = shrinkage.probabilities
    evidence = float(shrinkage.evidence.sum()) + sum(gate.gain for gate in gates)
    rest = np.flatnonzero(open_choices[cells.choice])
    alone = Mixture(np.ones(1), single[None, rest])
    mixture = multiplied([rest, *(g.cells for g in gates)], [alone, *(g.mixture for g in gates)], len(single))
    return Gated(mixture, evidence)


def _fitted(cells: Cells, counts: sparse.csr_array, weights: Floats, part: Ints) -> BlockFit:
    """The mixture of selected cells only."""
    block_cells = Cells(cells.original[part], np.unique(cells.choice[part], return_inverse=True)[1].reshape(-1))
    block_counts = sparse.csr_array(counts[:, part])
    nothing = np.zeros((len(weights), 0))
    components = chosen_components(block_cells, Sample(block_counts, nothing, nothing, weights), [kinds(block_counts)])
    mixture = fit_mixture(block_cells, block_counts, weights, components).mixture
    free = len(part) - len(np.unique(block_cells.choice))
    return BlockFit(mixture, len(mixture.weights) * (free + 1) - 1)


def _strength(shrinkage: Shrinkage, counts: sparse.csr_array, weights: Floats, ordered: Flags) -> Floats:
    """[choices, choices] dependence of choices: squared scores, divided by their expectation under independence.

    The diagonal has the dependence of a choice with itself, if it is made several times.
    """
    cells = shrinkage.cells
    block = _blocks(cells, ordered)
    spread = sparse.csr_array((np.ones(len(block)), (np.arange(len(block)), block)))
    choice = np.zeros(int(block.max(initial=-1)) + 1, dtype=np.int64)
    choice[block] = cells.choice
    to_choice = sparse.csr_array((np.ones(len(choice)), (np.arange(len(choice)), choice)))
    table = dense(counts @ spread)
    choice_counts = table @ to_choice
    mean = cells.normalised(np.asarray(weights @ counts)[None])[0] @ spread
    rest = (table - choice_counts[:, choice] * mean) * np.sqrt(weights)[:, None]
    scale = (rest**2).T @ (rest**2)
    squares = (rest.T @ rest) ** 2 / np.where(scale > 0.0, scale, np.inf)
    freedom = np.maximum(np.bincount(choice) - 1.0, 1.0)
    number = np.outer(freedom, freedom)
    strength = (
        dense(to_choice.T @ squares @ to_choice) * number / np.outer(*2 * [np.bincount(choice)]) - number
    ) / np.sqrt(2.0 * number)
    single = choice_counts.max(axis=0, initial=0.0) <= 1.0
    strength[np.diag_indices(len(strength))] = np.where(single, -np.inf, strength.diagonal())
    return strength


def _blocks(cells: Cells, ordered: Flags) -> Ints:
    """[A] coarser cells: equally likely ranges of numbers; all other cells do not change."""
    block = np.arange(len(cells.choice))
    for choice in np.flatnonzero(ordered):
        members = np.flatnonzero(cells.choice == choice)
        ahead = np.cumsum(cells.original[members]) - 0.5 * cells.original[members]
        block[members] = members[0] + np.minimum((_NUM_RANGES * ahead).astype(np.int64), _NUM_RANGES - 1)
    return np.unique(block, return_inverse=True)[1].reshape(-1)


def _candidates(strength: Floats, open_choices: Flags) -> Ints:
    """The choices with the strongest dependence, ascending."""
    rows, columns = np.nonzero(np.triu(open_choices[:, None] & open_choices))
    order = np.argsort(-strength[rows, columns], kind="stable")
    chosen: dict[int, None] = {}
    for pair in order:
        if len(chosen) >= NUM_LEVELS:
            break
        chosen |= dict.fromkeys((int(rows[pair]), int(columns[pair])))
    return np.array(sorted(chosen), dtype=np.int64)


class _GateSearch:
    """Gates among some choices."""

    def __init__(
        self, shrinkage: Shrinkage, counts: sparse.csr_array, weights: Floats, ordered: Flags, choices: Ints
    ) -> None:
        cells = shrinkage.cells
        self.cells = np.flatnonzero(np.isin(cells.choice, choices))
        self.candidate_cells = Cells(cells.original[self.cells], np.searchsorted(choices, cells.choice[self.cells]))
        self.ordered = ordered[choices]
        self.levels = ProbabilityPrior.of(self.candidate_cells, self.ordered)
        self.odds = shrinkage.odds[choices]
        self.evidence = shrinkage.evidence[choices]
        self.all = shrinkage.posterior.evidence[0, choices]
        self.single = shrinkage.probabilities[self.cells]
        self.ratio = shrinkage.posterior.ratio[0, self.cells]
        self.counts = sparse.csr_array(counts[:, self.cells])
        self.weights = weights
        self.spread = shrinkage.spread[self.cells]
        choice_counts = dense(
            self.counts
            @ sparse.csr_array((np.ones(len(self.cells)), (np.arange(len(self.cells)), self.candidate_cells.choice)))
        )
        self.once: Flags = np.all(choice_counts == 1.0, axis=0)
        self.several: Flags = np.any(choice_counts > 1.0, axis=0)
        # One choice is the gate, and at least one other depends on it.
        self.prior = -np.log(2.0 * max(len(shrinkage.odds), 2))

    def gates(self) -> Iterator[Gate]:
        """The best gate of each choice."""
        for choice in range(len(self.odds)):
            if self.once[choice] or self.several[choice]:
                gate = self._gate(choice)
                if gate is not None:
                    yield gate

    def _gate(self, choice: int) -> Gate | None:
        """The best way to group the examples by a choice."""
        columns = np.flatnonzero(self.candidate_cells.choice == choice)
        gate_counts = sparse.csr_array(self.counts[:, columns])
        if self.once[choice]:
            block = _blocks(
                Cells(self.candidate_cells.original[columns], np.zeros(len(columns), dtype=np.int64)),
                self.ordered[[choice]],
            )
            start = block[np.asarray(np.argmax(dense(gate_counts), axis=1))]
        else:
            gate_cells = Cells(self.candidate_cells.original[columns], np.zeros(len(columns), dtype=np.int64))
            steps = merged(gate_cells, gate_counts, self.weights, kinds(gate_counts), SEVERAL)
            start = next(labels for labels in steps if labels.max() < SEVERAL)
        start = np.unique(start, return_inverse=True)[1].reshape(-1)
        best: tuple[float, Ints] | None = None
        labels = start
        while labels.max() > 0:
            score = self._score(choice, self._totals(labels), [range(int(labels.max()) + 1)])[0]
            if best is None or score > best[0]:
                best = score, labels
            if labels.max() == 1:
                break
            labels = self._joined(choice, labels)
        return None if best is None else self._gate_of(choice, *best)

    def _totals(self, labels: Ints) -> Floats:
        share = sparse.csr_array((self.weights, (labels, np.arange(len(labels)))))
        mass = np.bincount(labels, weights=self.weights).astype(np.float64)
        return np.concatenate([dense(share @ self.counts) / self.spread, mass[:, None]], axis=1)

    def _joined(self, choice: int, labels: Ints) -> Ints:
        """The labels with those two groups joined that cost least."""
        totals = self._totals(labels)
        pairs = list(combinations(range(len(totals)), 2))
        rows = np.concatenate([totals, [totals[first] + totals[second] for first, second in pairs]])
        groups = [
            [*(i for i in range(len(totals)) if i not in pair), len(totals) + number]
            for number, pair in enumerate(pairs)
        ]
        first, second = pairs[int(np.argmax(self._score(choice, rows, groups)))]
        joined = np.where(labels == second, first, labels)
        return np.unique(joined, return_inverse=True)[1].reshape(-1)

    def _score(self, choice: int, totals: Floats, groupings: Sequence[Sequence[int]]) -> Floats:
        """Gain of each grouping, from the totals of all groups; the last column is the mass."""
        evidence = self.levels.posterior(totals[:, :-1]).evidence
        special = np.logaddexp(0.0, evidence) - np.log(2.0)
        gains = np.zeros(len(groupings))
        for i, groups in enumerate(groupings):
            gain = averaged(self.odds, self._mixed(special[list(groups)].sum(axis=0))) - self.evidence
            mass = totals[list(groups), -1]
            if self.once[choice]:
                gain[choice] = 0.0
                gains[i] = gain.sum()
            else:
                gains[i] = gain.sum() + float(gammaln(mass).sum() - gammaln(mass.sum() + 1.0)) - _MIN_GAIN
        return gains + self.prior

    def _mixed(self, apart: Floats) -> Floats:
        """Log-evidence of choices that either are equal in all groups or differ."""
        return np.logaddexp(self.all, apart) - np.log(2.0)

    def _gate_of(self, choice: int, gain: float, labels: Ints) -> Gate:
        """The mixture of a grouping."""
        totals = self._totals(labels)
        posterior = self.levels.posterior(totals[:, :-1])
        special = expit(posterior.evidence)
        apart = (np.logaddexp(0.0, posterior.evidence) - np.log(2.0)).sum(axis=0)
        matters = expit(self.odds + self._mixed(apart))
        differs = expit(apart - self.all)
        with_gate = (matters * differs > 0.5) | (np.arange(len(matters)) == choice)
        by_cell = self.candidate_cells.choice
        ratio = 1.0 + special[:, by_cell] * (posterior.ratio - 1.0)
        ratio = 1.0 + matters[by_cell] * (differs[by_cell] * ratio + (1.0 - differs[by_cell]) * self.ratio - 1.0)
        probabilities = self.candidate_cells.original * ratio
        columns = np.flatnonzero(by_cell == choice)
        if self.once[choice]:
            weights, probabilities[:, columns] = self._opened(columns, totals)
        else:
            weights = totals[:, -1] / totals[:, -1].sum()
        chosen = with_gate[by_cell]
        return Gate(self.cells[chosen], Mixture(weights, probabilities[:, chosen]), gain)

    def _opened(self, columns: Ints, totals: Floats) -> tuple[Floats, Floats]:
        """Probability and branches of each group of the gate; branches never taken join the largest group."""
        gate_counts = totals[:, columns]
        group = np.where(gate_counts.any(axis=0), gate_counts.argmax(axis=0), int(totals[:, -1].argmax()))
        single = self.single[columns]
        inside = (group == np.arange(len(totals))[:, None]) * single
        weights = inside.sum(axis=1)
        return weights / weights.sum(), inside / np.where(weights > 0.0, weights, 1.0)[:, None]
