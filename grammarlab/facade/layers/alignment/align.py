"""Alignment of words: the matrix of substrings whose columns fit each other best (paper 003, section 5.2)."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

from grammarlab.errors import FacadeError
from grammarlab.facade.layers.alignment.columns import column_size
from grammarlab.facade.layers.alignment.naming import Element, named_columns
from grammarlab.facade.layers.alignment.pairs import PairProblem, Prices
from grammarlab.facade.layers.alignment.rows import EMPTY, RowStep, build_rows, unit_of
from grammarlab.facade.layers.alignment.search import Path, search
from grammarlab.facade.layers.alignment.spreads import Spreads
from grammarlab.facade.layers.alignment.strains import Strains
from grammarlab.facade.layers.letters import Word
from grammarlab.facade.layers.weights import Weights

_PRICE = 1_000_000
"""Weights become whole numbers: this is 1 for each unit of length."""
_DEAREST = 1 << 200
"""More than any alignment costs."""


@dataclass(frozen=True)
class Alignment:
    """Words that are cut at the same columns."""

    words: tuple[Word, ...]
    """m rows, from the top layer down."""
    cells: tuple[tuple[Element, ...], ...]
    """[m, n]"""
    omega: float
    """Metres: the sum of the errors of columns."""
    span: float
    """Metres: the sum of the widest elements of columns."""
    merged: int
    """Letters of elements beyond their first."""
    energy: float
    """Of omega and merged letters, weighted."""
    strain: float
    """Square metres: sizes of symbols deviate at least so much from what is preferred; 0 where nobody asked."""
    bound: float
    """No alignment that comes after those before it in the list has less energy than this."""
    proven: bool
    """Whether `bound` is `energy`."""

    @property
    def num_columns(self) -> int:
        """N."""
        return len(self.cells[0]) if self.cells else 0

    def columns(self) -> list[list[str]]:
        """[n][m] each element as text, from the top layer down; an empty one is 'ε'.

        Parts of a letter are numbered where numbers tell something, for a letter with a size or a symbol that occurs
        several times: parts of one symbol have the same number where what stands in their column is the same.
        """
        return named_columns(self.words, self.cells)


@dataclass(frozen=True)
class Aligned:
    """What a search for alignments came to."""

    best: tuple[Alignment, ...]
    """The best first."""
    bound: float
    """All that are not among `best` have at least this energy."""
    done: bool
    """Whether there are no more, or they are as many as were asked for: false when effort ran out."""
    steps: int = 0
    """That the search took."""


def alignments(
    words: Sequence[Word],
    canvas: float,
    weights: Weights,
    count: int = 1,
    *,
    tolerance: float,
    effort: int = 200_000,
) -> list[Alignment]:
    """The best different alignments of some words, best first; see `align`."""
    return list(align(words, canvas, weights, count, tolerance=tolerance, effort=effort).best)


def align(
    words: Sequence[Word],
    canvas: float,
    weights: Weights,
    count: int = 1,
    *,
    tolerance: float,
    effort: int = 200_000,
    cutoff: float = math.inf,
    sizing: float = 0.0,
    gaps: bool = False,
    finest: bool = False,
    problem: PairProblem | None = None,
) -> Aligned:
    """The best different alignments of some words.

    Columns satisfy the constraints of section 5.2. Besides, an empty element counts as one of size 0 unless an opaque
    letter above explains it; none stands beside a transparent letter, which is wider instead; and layers with equal
    words have equal elements. A transparent letter may be split over columns, and its parts are of any size.

    Args:
        words: m words, from the top layer down.
        canvas: metres, > 0.
        weights: of omega and merged letters.
        count: how many.
        tolerance: mu, metres that the span may miss of the canvas, and the error of a column at most, >= 0.
        effort: steps of the search at most, each about a microsecond; then what is returned may not be proven.
        cutoff: alignments of more energy are not wanted.
        sizing: weight of `Alignment.strain`, which then counts for what is best.
        gaps: see `size_letters`; only for `sizing`.
        finest: whether alignments are left out that look like one with finer columns, which is better.
        problem: what `problem_of` makes of these words, where several searches are about it.

    Raises:
        FacadeError: for a canvas, a tolerance or a count that means nothing.
    """
    if not (math.isfinite(canvas) and canvas > 0.0 and math.isfinite(tolerance) and tolerance >= 0.0 and count >= 1):
        raise FacadeError(
            "Alignment: expected a canvas above 0, a tolerance of at least 0 and a count of at least 1, found "
            f"{canvas}, {tolerance} and {count}."
        )
    if not any(words):
        return Aligned((), math.inf, done=True)
    unit = unit_of(canvas)
    problem = problem or problem_of(
        words, canvas, weights, tolerance=tolerance, sizing=sizing, gaps=gaps, finest=finest
    )
    highest = _DEAREST if cutoff == math.inf else math.floor(cutoff / unit * _PRICE) + 1
    found = search(problem, count, effort, highest)
    bound = found.bound * unit / _PRICE
    made = []
    for paths, proven in ((found.paths, True), (found.guessed, False)):
        for _, path in paths:
            one = _alignment(problem, tuple(words), path, canvas, unit, weights)
            made.append(one if proven else replace(one, bound=min(bound, one.energy), proven=False))
    return Aligned(tuple(made), bound, found.done, found.steps)


def problem_of(
    words: Sequence[Word],
    canvas: float,
    weights: Weights,
    *,
    tolerance: float,
    sizing: float = 0.0,
    gaps: bool = False,
    finest: bool = False,
) -> PairProblem:
    """What is to be searched, in whole units; arguments as for `align`."""
    unit = unit_of(canvas)
    prices = Prices(round(weights.omega * _PRICE), max(round(weights.merge / unit * _PRICE), 1), sizing * unit * _PRICE)
    least, most = math.floor((canvas - tolerance) / unit), math.ceil((canvas + tolerance) / unit)
    return PairProblem(
        rows=build_rows(words, unit),
        prices=prices,
        least=least,
        most=most,
        tolerance=math.ceil(tolerance / unit),
        gaps=gaps,
        finest=finest,
    )


def _alignment(
    problem: PairProblem, words: tuple[Word, ...], path: Path, canvas: float, unit: float, weights: Weights
) -> Alignment:
    """The matrix that a path stands for, with its numbers."""
    errors, span, elastic = 0, 0, False
    strains, states, worst = Strains(problem), [0] * len(problem.rows), 0
    spreads = Spreads(problem)
    widths = spreads.start
    for column in path:
        error, high, fixed = column_size(column)
        errors, span, elastic = errors + error, span + high, elastic or not fixed
        if problem.prices.strain:
            after = spreads.after(widths, states, column, high, elastic=not fixed, span=span)
            if after is None:
                raise AssertionError("The path of an alignment has widths for its letters.")
            widths, strain = after
            worst = max(worst, strain, strains.of(states, column))
        states = [step.state for step in column]
    cells: list[tuple[Element, ...]] = [()] * len(words)
    merged = 0
    for at, row in enumerate(problem.rows):
        elements = _elements([column[at] for column in path])
        merged += len(row.layers) * sum(len(element) - 1 for element in elements if element)
        for layer in row.layers:
            cells[layer] = elements
    omega = errors * unit
    width = max(span * unit, canvas) if elastic else span * unit
    energy = weights.omega * omega + weights.merge * merged
    strain = worst / problem.prices.strain * unit**2 if worst else 0.0
    return Alignment(
        words=words,
        cells=tuple(cells),
        omega=omega,
        span=width,
        merged=merged,
        energy=energy,
        strain=strain,
        bound=energy,
        proven=True,
    )


def _elements(steps: Sequence[RowStep]) -> tuple[Element, ...]:
    """The letters of the elements of a row."""
    elements: list[Element] = []
    state, part = 0, 0
    for step in steps:
        if step.kind == EMPTY:
            elements.append(())
            continue
        is_open, read, until = bool(state % 2), (state + 1) // 2, (step.state + 1) // 2
        part = part + 1 if is_open else 0
        continued = ((read - 1, part),) if is_open else ()
        elements.append((*continued, *((at, 0) for at in range(read, until))))
        if until > read:
            part = 0
        state = step.state
    return tuple(elements)
