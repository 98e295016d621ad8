"""By how much the sizes of symbols have to change at least so that the elements of one column are equally wide."""

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
        """What the narrowest and the widest fixed element of a column cost at least, where they begin at these states.

        Sizes that differ by d in total become equal at least for d^2 / |c|^2, c how often each symbol is in the one
        more than in the other.
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
