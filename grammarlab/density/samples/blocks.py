"""Mixtures of blocks of choices: independent blocks are learned separately, and their mixtures multiplied.

Where the legs of a table and its wood are chosen independently, three kinds of legs and three woods are nine components
of one mixture, each learned from a ninth of the examples; as two mixtures of three, each is learned from a third.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import reduce

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse.csgraph import connected_components
from scipy.special import xlogy

from grammarlab.arrays import Ints
from grammarlab.density.mixtures.mixture import Cells, Mixture, dense, fit_mixture
from grammarlab.density.samples.sampled import MOST_COMPONENTS, Sample, chosen_components, kinds

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]

_TOGETHER = 5.0
"""Smallest deviation of dependent choices, in standard deviations."""


def going_together(cells: Cells, counts: sparse.csr_array, weights: Floats) -> Flags:
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
    found = spread @ (score > _TOGETHER) @ spread.T > 0.0
    np.fill_diagonal(found, False)
    single = (table @ spread.T).max(axis=0, initial=0.0) <= 1.0
    for one, other in np.argwhere(found & single & single[:, None]):
        columns = table[:, cells.choice == one], table[:, cells.choice == other]
        found[one, other] = information(columns[0].T @ (weights[:, None] * columns[1])) > 0.0
    return found


def information(together: Floats) -> float:
    """Gain of the dependence of two choices in nats, minus the price of its parameters (BIC).

    Args:
        together: [branches, branches] how often each pair was taken.
    """
    total, rows, columns = together.sum(), together.sum(axis=1), together.sum(axis=0)
    gain = xlogy(together, together).sum() - xlogy(rows, rows).sum() - xlogy(columns, columns).sum()
    numbers = max(0, np.count_nonzero(rows) - 1) * max(0, np.count_nonzero(columns) - 1)
    return float(gain + xlogy(total, total) - 0.5 * numbers * np.log(max(total, 1.0)))


@dataclass(frozen=True, slots=True)
class BlockFit:
    """A fitted mixture of blocks."""

    mixture: Mixture
    numbers: int
    """Number of estimated free parameters."""


def fit_blocks(cells: Cells, counts: sparse.csr_array, weights: Floats, together: Flags) -> BlockFit:
    """A mixture for each block of dependent choices, combined into one mixture.

    Held-out derivations decide the number of components of each.

    Args:
        cells: what is learned.
        counts: [N, A] how often each derivation took each cell.
        weights: [N] how much each derivation counts, >= 0 and not all 0.
        together: [choices, choices] which choices depend on each other.
    """
    number, block = connected_components(sparse.csr_array(together), directed=False)
    parts = [np.flatnonzero(block[cells.choice] == i) for i in range(number)]
    fitted = [_fitted(cells, counts, weights, part) for part in parts]
    if len(parts) < 2 or np.prod([float(len(found.mixture.weights)) for found in fitted]) > MOST_COMPONENTS:
        return _fitted(cells, counts, weights, np.arange(len(cells.choice)))
    mixture = multiplied(parts, [found.mixture for found in fitted], len(cells.choice))
    return BlockFit(mixture, sum(found.numbers for found in fitted))


def _fitted(cells: Cells, counts: sparse.csr_array, weights: Floats, part: Ints) -> BlockFit:
    """The mixture of selected cells only."""
    own = Cells(cells.original[part], np.unique(cells.choice[part], return_inverse=True)[1].reshape(-1))
    taken = sparse.csr_array(counts[:, part])
    nothing = np.zeros((len(weights), 0))
    components = chosen_components(own, Sample(taken, nothing, nothing, weights), [kinds(taken)])
    mixture = fit_mixture(own, taken, weights, components).mixture
    free = len(part) - len(np.unique(own.choice))
    return BlockFit(mixture, len(mixture.weights) * (free + 1) - 1)


def multiplied(parts: Sequence[Ints], mixtures: Sequence[Mixture], size: int) -> Mixture:
    """All combinations of the components of mixtures of different cells."""
    weights = reduce(np.multiply.outer, [mixture.weights for mixture in mixtures]).reshape(-1)
    chosen = np.indices([len(mixture.weights) for mixture in mixtures]).reshape(len(mixtures), -1)
    probabilities = np.zeros((len(weights), size))
    for part, mixture, component in zip(parts, mixtures, chosen, strict=True):
        probabilities[:, part] = mixture.probabilities[component]
    return Mixture(weights, probabilities)
