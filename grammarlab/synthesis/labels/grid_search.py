"""Grids of small energy: grids of whole rows and columns, improved line by line, and the paper's own method.

The paper alternates majority labels and nearest neighbourhoods (`expectation_maximization`).
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from grammarlab.synthesis.label_grid import Labels
from grammarlab.synthesis.labels.demands import Domain, LabelDemands
from grammarlab.synthesis.labels.line_search import RowWindows, best_columns, suits
from grammarlab.synthesis.labels.problem import Problem, distances, energy, votes

PENALTY = 9
"""Energy of a cell that has to change: at least the increase by a change, since 9 windows lie over it."""
_MOST_ITERATIONS = 100
"""Largest number of iterations of expectation maximization."""
_MAX_ADDITIONS = 1e8
"""Largest number of additions for settling before the result is kept: some tenths of a second."""
_MIN_PASSES = 2
"""Least number of passes over all lines of a grid, for any size."""
_TRACKED_LIMIT = 4
"""Largest counts below this number are tracked during the choice of lines; others are not."""
_NOISE_SUM = 0.25
"""Largest sum of what is added to the energy, over a grid, to choose among grids of equal energy."""
_RANDOM_PART = 0.02
"""Random part of it, which decides among grids of equal proportions."""


@dataclass(frozen=True, slots=True)
class Trace:
    """Result of one run of expectation maximization."""

    labels: Labels
    """[rows, columns] labels."""
    history: tuple[int, ...]
    """Energy after each iteration; it never rises."""


@dataclass
class GridSearch:
    """A search for grids, with its results."""

    problem: Problem
    demands: LabelDemands
    generator: np.random.Generator
    dissimilarity: NDArray[np.float64]
    """[rows, columns, labels] from 0 to 1, how unlike the stretched example a label is there: of equal grids
    the search prefers those of the example's proportions."""
    effort: float = 1.0
    """Factor on the usual amount of work."""
    spent: float = 0.0
    """Additions so far."""
    solutions: dict[bytes, tuple[int, Labels]] = field(default_factory=dict)
    """By content: energy and labels of grids that satisfy all constraints."""

    def __post_init__(self) -> None:
        self.rows = RowWindows.from_problem(self.problem)
        self.columns = RowWindows.from_problem(self.problem.transposed())
        shape = self.problem.domain.shape
        once = self.problem.rows * self.rows.work + self.problem.columns * self.columns.work
        self.budget = max(_MAX_ADDITIONS, _MIN_PASSES * once) * self.effort
        chance = _RANDOM_PART * self.generator.random(shape)
        self.noise = ((1.0 - _RANDOM_PART) * self.dissimilarity + chance) * (_NOISE_SUM / (shape[0] * shape[1]))

    @property
    def best(self) -> int | None:
        return min((value for value, _ in self.solutions.values()), default=None)

    def ranked(self) -> list[tuple[int, Labels]]:
        """Energies and labels, best first; of equal ones, those of the example's proportions."""
        cells = np.indices(self.problem.kind.shape)
        return sorted(self.solutions.values(), key=lambda grid: (grid[0], float(self.noise[*cells, grid[1]].sum())))

    def settle(self, labels: Labels) -> Labels:
        """A grid that satisfies the constraints, and that no change of one row or one column improves."""
        domain = self._pinned(labels)
        if domain is None:
            return labels
        labels = labels.copy()
        dirty = [set(range(self.problem.rows)), set() if self.demands.symmetric else set(range(self.problem.columns))]
        while dirty[0] or dirty[1]:
            if self.spent > self.budget and self.demands.domain_kept(labels):
                break
            axis = 0 if dirty[0] else 1
            line = int(self.generator.choice(sorted(dirty[axis])))
            dirty[axis].discard(line)
            view, allowed = (labels, domain) if axis == 0 else (labels.T, domain.transpose(1, 0, 2))
            noise = self.noise if axis == 0 else self.noise.transpose(1, 0, 2)
            windows = self.rows if axis == 0 else self.columns
            self.spent += windows.work
            chosen = windows.best_row(view, line, allowed[line], noise[line], self.demands.symmetric)
            changed = np.flatnonzero(chosen != view[line])
            if len(changed):
                view[line] = chosen
                dirty[axis] |= {near for near in range(line - 2, line + 3) if 0 <= near < len(view) and near != line}
                if not self.demands.symmetric:
                    near = {int(index) + step for index in changed for step in range(-2, 3)}
                    dirty[1 - axis] |= {index for index in near if 0 <= index < view.shape[1]}
        self.keep(labels)
        return labels

    def keep(self, labels: Labels) -> None:
        """Records a grid, if it satisfies the constraints."""
        if self.demands.broken(labels) == 0:
            self.solutions.setdefault(labels.tobytes(), (energy(self.problem, labels), labels))

    def _pinned(self, labels: Labels) -> Domain | None:
        """Domains that keep every counted label within its limits; None if there is no room."""
        domain = self.demands.domain.copy()
        for label, least, most in self.demands.counts:
            able = domain[:, :, label]
            forced = able & (domain.sum(axis=2) == 1)
            here = able & (labels == label) & ~forced
            others = able & ~here & ~forced
            strict = most < int(able.sum())
            chosen = self._chosen(forced, here, others, least, most if strict else least)
            if chosen is None:
                return None
            if strict:
                domain[:, :, label] = False
            domain[chosen] = False
            domain[chosen, label] = True
        for row in self.demands.equal_ends:
            both = domain[row, 0] & domain[row, -1]
            if not both.any():
                return None
            here = [label for label in (labels[row, 0], labels[row, -1]) if both[label]]
            chosen = here[0] if here else self.generator.choice(np.flatnonzero(both))
            domain[row, [0, -1]] = np.arange(domain.shape[2]) == chosen
        return domain

    def _chosen(self, forced: Domain, here: Domain, others: Domain, least: int, most: int) -> NDArray[np.bool_] | None:
        """[rows, columns] cells that get a label: forced ones first, then those that have it, then any."""
        chosen = forced.copy()
        columns = chosen.shape[1]
        for cells, limit in ((here, most), (others, least)):
            for row, column in self.generator.permutation(np.argwhere(cells)):
                if chosen[row, column]:
                    continue
                mirror = columns - 1 - column if self.demands.symmetric else column
                added = 1 + int(mirror != column)
                if int(chosen.sum()) + added <= min(limit, most):
                    chosen[row, [column, mirror]] = True
        return chosen if least <= int(chosen.sum()) else None

    def factored(self, example: Labels, across: Labels) -> Labels:
        """The best grid of rows of an example for these columns of it, then the best columns for those rows, and so on.

        Args:
            example: [rows, columns] without holes.
            across: [columns] initial column of the example for each column.
        """
        cost = np.inf
        labels = example[np.ix_(np.arange(self.problem.rows) % len(example), across)]
        while suits(self.problem, example.T) and suits(self.problem.transposed(), example):
            rows = self._lines(example[:, across], turned=True)
            columns = self._lines(example[rows].T, turned=False)
            chosen = example[np.ix_(rows, columns)]
            value = energy(self.problem, chosen) + PENALTY * self.demands.broken(chosen)
            if value >= cost:
                return labels
            labels, cost, across = chosen, value, columns
        return labels

    def recombined(self, most: int) -> None:
        """The best grid of the columns of the found grids, and that of their rows.

        Args:
            most: largest number of columns to choose from; those found last are left out.
        """
        for turned in (False,) if self.demands.symmetric else (False, True):
            grids = [labels if turned else labels.T for _, labels in self.ranked()[:8]]
            if grids:
                lines = np.concatenate(grids)
                first = np.sort(np.unique(lines, axis=0, return_index=True)[1])
                candidates = lines[first[:most]]
                if not suits(self.problem.transposed() if turned else self.problem, candidates):
                    continue
                grid = candidates[self._lines(candidates, turned)]
                self.settle(grid if turned else np.ascontiguousarray(grid.T))

    def _lines(self, candidates: Labels, turned: bool) -> NDArray[np.int64]:
        """Indices of the candidates, columns or rows if turned, of the best grid."""
        problem, noise = self.problem.within(self.demands.domain), self.noise
        limits = [count for count in self.demands.counts if count[2] < _TRACKED_LIMIT]
        if turned:
            return best_columns(problem.transposed(), candidates, noise.transpose(1, 0, 2), limits)
        return best_columns(problem, candidates, noise, limits, self.demands.symmetric)


def expectation_maximization(problem: Problem, seed: int, iterations: int = _MOST_ITERATIONS) -> Trace:
    """Local optimum of the energy from random initial neighbourhoods.

    E step: each cell gets the majority label of the neighbourhoods over it, the lowest label of equally frequent ones.
    M step: each window gets the nearest neighbourhood (Eq. 2), the first of equally near ones. It ends when no
    neighbourhood changes.

    Args:
        problem: the windows, without borders for the paper's energy.
        seed: seed of the initial neighbourhoods.
        iterations: largest number of iterations.
    """
    generator = np.random.default_rng(seed)
    sizes = np.array([len(patches) for patches in problem.patches])
    nearest = np.where(problem.kind < 0, -1, generator.integers(0, sizes[problem.kind]))
    history: list[int] = []
    labels = nearest
    for _ in range(max(1, iterations)):
        labels = votes(problem, nearest).argmax(axis=2)
        updated, differ = distances(problem, labels)
        history.append(int(differ.sum()))
        if np.array_equal(updated, nearest):
            break
        nearest = updated
    return Trace(labels, tuple(history))
