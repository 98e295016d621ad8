"""Alignments without search, for words that an exact one has no time for: all follow the word of most letters.

As many letters of that word as are asked for are a column each time. The other words are cut to fit these columns as
well as they can, each for itself, by dynamic programming. Whether all of them together are an alignment is looked at
then.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from grammarlab.facade.layers.alignment.pairs import PairProblem
from grammarlab.facade.layers.alignment.rows import EMPTY, AlignedRow, RowStep

Path = tuple[tuple[RowStep, ...], ...]
"""[n][m] the elements of columns."""


def rough_paths(problem: PairProblem) -> Iterator[Path]:
    """Paths that may be alignments, with ever wider columns; costs of columns are not looked at together."""
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
    """A row with so many letters in each of its elements; None where they may not stand together."""
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
    """The elements of a row that fit some columns best; None where none do."""
    best: dict[int, tuple[int, tuple[RowStep, ...]]] = {0: (0, ())}
    for width in widths:
        after: dict[int, tuple[int, tuple[RowStep, ...]]] = {}
        for state, (cost, path) in best.items():
            steps = row.steps(state)
            for step in (*((steps.empty,) if steps.empty else ()), *steps.fixed, *steps.elastic):
                error = _error(step, width)
                if error > problem.tolerance:
                    continue
                # Squares keep errors apart: columns may have no large ones.
                paid = cost + problem.prices.error * error**2 // problem.most + problem.prices.merge * step.merged
                if step.state not in after or paid < after[step.state][0]:
                    after[step.state] = paid, (*path, step)
        best = after
    return list(best[row.last][1]) if row.last in best else None


def _error(step: RowStep, width: int) -> int:
    """Units by which an element is not as wide as a column."""
    if step.kind == EMPTY or step.fixed:
        return abs(width - step.size)
    return max(step.size - width, 0)
