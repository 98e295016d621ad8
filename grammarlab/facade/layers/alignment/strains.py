"""Lower bounds on the change of symbol sizes that makes the elements of one column equally wide."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

from grammarlab.facade.layers.alignment.pairs import PairProblem
from grammarlab.facade.layers.alignment.rows import EMPTY, PARTIAL, RowStep


class Strains:
    """Lower bounds on the error of sizes, column by column."""

    def __init__(self, problem: PairProblem) -> None:
        self.problem = problem
        self.known: dict[tuple[int, int, int, int, int, int], int] = {}

    def of(self, states: Sequence[int], column: Sequence[RowStep]) -> int:
        """Least cost of equal widths of the narrowest and the widest fixed element of a column from these states.

        Sizes with a total difference of d become equal at a cost of at least d^2 / |c|^2, where c is the difference of
        the counts of each symbol.
        """
        fixed = [
            (step.size, at)
            for at, step in enumerate(column)
            if step.fixed and step.kind != EMPTY and not (self.problem.gaps and step.kind == PARTIAL)
        ]
        if len(fixed) < 2:
            return 0
        (low, one), (high, other) = min(fixed), max(fixed)
        if low == high:
            return 0
        key = (one, states[one], column[one].state, other, states[other], column[other].state)
        found = self.known.get(key)
        if found is None:
            often = self._symbols(one, states[one], column[one])
            often.subtract(self._symbols(other, states[other], column[other]))
            square = sum(times**2 for times in often.values())
            found = self.known[key] = int(self.problem.prices.strain * (high - low) ** 2 / square)
        return found

    def _symbols(self, row: int, state: int, step: RowStep) -> Counter[str]:
        word = self.problem.rows[row].word
        return Counter(letter.symbol for letter in word[(state + 1) // 2 : (step.state + 1) // 2])
