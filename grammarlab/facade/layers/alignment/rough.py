"""Alignments without search, for words that are too long for an exact one: all words follow the longest word.

For each number of letters per column, the longest word is cut into columns. Each other word is fitted to these columns
independently, by dynamic programming. Whether the result is an alignment is checked afterwards.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from grammarlab.facade.layers.alignment.pairs import PairProblem
from grammarlab.facade.layers.alignment.rows import EMPTY, AlignedRow, RowStep

Path = tuple[tuple[RowStep, ...], ...]
"""[n][m] elements of columns."""


def rough_paths(problem: PairProblem) -> Iterator[Path]:
    """Candidate paths with ever wider columns; the rules of columns are not checked."""
    solid = [all(letter.hides for letter in row.word) for row in problem.rows]
    lead = max(range(len(problem.rows)), key=lambda at: (solid[at], len(problem.rows[at].word)))
    row = problem.rows[lead]
    letters = len(row.word)
    for together in dict.fromkeys(-(-letters // num) for num in range(letters, 0, -1)):
        leading = _columns(row, together)
        if leading is None:
            continue
        widths = [step.size for step in leading]
        paths = [leading if at == lead else _followed(problem, each, widths) for at, each in enumerate(problem.rows)]
        if all(path is not None for path in paths):
            yield tuple(zip(*(path for path in paths if path is not None), strict=True))


def _columns(row: AlignedRow, together: int) -> list[RowStep] | None:
    """A row with the given number of letters per element; None if these letters cannot share an element."""
    found: list[RowStep] = []
    state = 0
    while state < row.last:
        aim = min(state + 2 * together, row.last)
        steps = row.steps(state)
        step = next((each for each in (*steps.fixed, *steps.elastic) if each.state == aim), None)
        if step is None:
            return None
        found.append(step)
        state = aim
    return found


def _followed(problem: PairProblem, row: AlignedRow, widths: Sequence[int]) -> list[RowStep] | None:
    """The elements of a row that fit columns best; None if none fit."""
    best: dict[int, tuple[int, tuple[RowStep, ...]]] = {0: (0, ())}
    for width in widths:
        after: dict[int, tuple[int, tuple[RowStep, ...]]] = {}
        for state, (cost, path) in best.items():
            steps = row.steps(state)
            for step in (*((steps.empty,) if steps.empty else ()), *steps.fixed, *steps.elastic):
                error = _error(step, width)
                if error > problem.tolerance:
                    continue
                # Squares spread the error over columns: a single large error may exceed the tolerance.
                paid = cost + problem.prices.error * error**2 // problem.most + problem.prices.merge * step.merged
                if step.state not in after or paid < after[step.state][0]:
                    after[step.state] = paid, (*path, step)
        best = after
    return list(best[row.last][1]) if row.last in best else None


def _error(step: RowStep, width: int) -> int:
    """Difference of the widths of an element and a column, units."""
    if step.kind == EMPTY or step.fixed:
        return abs(width - step.size)
    return max(step.size - width, 0)
