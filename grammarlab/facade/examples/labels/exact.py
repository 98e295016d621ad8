"""Grids of least energy, or near it, with a bound that says how near."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import ceil

import numpy as np

from grammarlab.facade.examples.label_grid import LabelGrid, Labels
from grammarlab.facade.examples.labels.demands import Demands
from grammarlab.facade.examples.labels.expectation import expectation_maximization
from grammarlab.facade.examples.labels.problem import Problem
from grammarlab.facade.examples.labels.search import Search
from grammarlab.facade.examples.labels.strips import lower_bound


@dataclass(frozen=True, slots=True)
class Bounded:
    """Grids, best first, and what no grid is below."""

    grids: tuple[tuple[int, Labels], ...]
    """Energy and labels."""
    bound: int


def least_energy(problem: Problem, demands: Demands, examples: Sequence[LabelGrid], seed: int, count: int) -> Bounded:
    """Grids of little energy that keep the demands."""
    problem = problem.within(demands.domain)
    bound = lower_bound(problem)
    search = Search(problem, demands, np.random.default_rng(seed))
    for start in starts(search, examples, seed):
        search.settle(start)
        if search.best is not None and search.best <= bound and len(search.found) >= count:
            break
    else:
        search.recombined(40)
    return Bounded(tuple(search.ranked()[:count]), bound)


def starts(search: Search, examples: Sequence[LabelGrid], seed: int) -> Iterator[Labels]:
    """Grids to begin with: of lines of an example in order, then from the paper's method with borders."""
    columns = search.problem.columns
    generator = search.generator
    for turn in range(3):
        for example in examples:
            size = example.columns
            if turn == 0:  # stretched
                across = np.round(np.linspace(0, size - 1, columns)).astype(np.int64)
            else:  # in order, from a drawn place
                inner = np.arange(1, size - 1) if size > 2 else np.arange(size)
                across = np.resize(np.roll(inner, -int(generator.integers(len(inner)))), columns)
                across[0], across[-1] = 0, size - 1
            yield search.factored(example.labels, across)
    for turn in range(4):
        yield expectation_maximization(search.problem, seed + turn).labels
