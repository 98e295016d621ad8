"""Alignment of words: the matrix of substrings whose columns fit each other best (paper 003, section 5.2)."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace

from grammarlab.errors import FacadeError
from grammarlab.layers.alignment.pairs import PairProblem, Prices, Strains
from grammarlab.layers.alignment.rows import EMPTY, RowStep, build_rows, column_size, unit_of
from grammarlab.layers.alignment.search import Path, search
from grammarlab.layers.alignment.spreads import Spreads
from grammarlab.layers.design import Weights, Word

Element = tuple[tuple[int, int], ...]
"""Letters in one row and one column; empty for a gap.

Each is the index of a letter in its word, and the index of its part: 0, unless columns split the letter.
"""
_EMPTY_TEXT = "ε"
_LENGTH_PRICE = 1_000_000
"""Integer weight of one unit of length."""
_MAX_COST = 1 << 200
"""An upper bound of the cost of any alignment."""
_MIN_CANVAS, _MAX_CANVAS = 1e-100, 1e100
"""Smallest and largest canvas: its unit and all prices are finite numbers."""


@dataclass(frozen=True)
class Alignment:
    """Words cut at common columns."""

    words: tuple[Word, ...]
    """m rows, from the top layer down."""
    cells: tuple[tuple[Element, ...], ...]
    """[m, n] letters of each element."""
    omega: float
    """Sum of the errors of columns, metres."""
    span: float
    """Sum of the widest elements of columns, metres."""
    merged: int
    """Number of letters of elements beyond their first."""
    energy: float
    """Weighted sum of omega and merged letters."""
    strain: float
    """Lower bound of the deviation of sizes from the preferred sizes, square metres; 0 if it was not requested."""
    bound: float
    """Lower bound of the energy of all alignments that are not before this one in the list."""
    proven: bool
    """Whether `bound` equals `energy`."""

    @property
    def num_columns(self) -> int:
        """Number n of columns."""
        return len(self.cells[0]) if self.cells else 0

    def columns(self) -> list[list[str]]:
        """[n][m] each element as text, from the top layer down; an empty one is 'ε'.

        Parts of a letter are numbered if the numbers distinguish something: if the letter has a size, or its symbol
        occurs several times. Parts of one symbol have the same number if the elements of their columns are the same.
        """
        return _named_columns(self.words, self.cells)


@dataclass(frozen=True)
class Aligned:
    """Result of a search for alignments."""

    best: tuple[Alignment, ...]
    """Alignments in order of energy, the best first."""
    bound: float
    """Lower bound of the energy of all alignments that are not in `best`."""
    done: bool
    """Whether the search is complete: all alignments, or the requested number, were found before effort ran out."""
    steps: int = 0
    """Steps of the search."""


def alignments(
    words: Sequence[Word],
    canvas: float,
    weights: Weights,
    count: int = 1,
    *,
    tolerance: float,
    effort: int = 200_000,
) -> list[Alignment]:
    """The best different alignments of words, best first; see `align`."""
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
    """The best different alignments of words.

    Columns satisfy the constraints of section 5.2. In addition, an empty element has size 0 unless an opaque letter
    above it explains the gap; no empty element is next to a transparent letter, which becomes wider instead; and layers
    with equal words have equal elements. A transparent letter may be split over columns, and its parts have any size.

    Args:
        words: m words, from the top layer down.
        canvas: length of the canvas, metres, > 0.
        weights: weights of omega and merged letters.
        count: largest number of alignments.
        tolerance: mu, largest difference of the span and the canvas and largest error of a column, metres, >= 0.
        effort: largest number of search steps, each about a microsecond; a result of a search that used them up may be
            unproven.
        cutoff: largest energy of an alignment.
        sizing: weight of `Alignment.strain` in the energy.
        gaps: whether elements with letters that are not opaque keep their size, see `size_letters`; used only with
            `sizing`.
        finest: whether to leave out alignments that look like another alignment with finer columns, which has less
            energy.
        problem: the result of `problem_of` for these words, if several searches share it.

    Raises:
        FacadeError: If the canvas, the tolerance or the count is out of range.
    """
    if not (_MIN_CANVAS <= canvas <= _MAX_CANVAS and 0.0 <= tolerance <= _MAX_CANVAS and count >= 1):
        raise FacadeError(
            f"Alignment: expected a canvas above 0, from {_MIN_CANVAS:g} to {_MAX_CANVAS:g} m, "
            f"a tolerance of at least 0 and a count of at least 1, found {canvas}, {tolerance} and {count}."
        )
    if not any(words):
        return Aligned((), math.inf, done=True)
    unit = unit_of(canvas)
    problem = problem or problem_of(
        words, canvas, weights, tolerance=tolerance, sizing=sizing, gaps=gaps, finest=finest
    )
    highest = _MAX_COST if cutoff == math.inf else math.floor(cutoff / unit * _LENGTH_PRICE) + 1
    result = search(problem, count, effort, highest)
    bound = result.bound * unit / _LENGTH_PRICE
    best = []
    for paths, proven in ((result.paths, True), (result.guessed, False)):
        for _, path in paths:
            alignment = _alignment(problem, tuple(words), path, canvas, unit, weights)
            best.append(alignment if proven else replace(alignment, bound=min(bound, alignment.energy), proven=False))
    return Aligned(tuple(best), bound, result.done, result.steps)


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
    """The search problem in integer units; arguments as for `align`."""
    unit = unit_of(canvas)
    prices = Prices(
        round(weights.omega * _LENGTH_PRICE),
        max(round(weights.merge / unit * _LENGTH_PRICE), 1),
        sizing * unit * _LENGTH_PRICE,
    )
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


def _named_columns(words: Sequence[Word], cells: Sequence[Sequence[Element]]) -> list[list[str]]:
    """[n][m] the elements as text, see `Alignment.columns`."""
    split = [{index for element in row for index, part in element if part} for row in cells]
    occurs = Counter(letter.symbol for word in dict.fromkeys(words) for letter in word)
    separator = " " if any(len(symbol) > 1 for symbol in occurs) else ""
    numbers: dict[str, dict[tuple[tuple[str, ...], ...], int]] = {}
    columns = []
    for column in zip(*cells, strict=True):
        whole = tuple(
            tuple(word[index].symbol for index, _ in element if index not in parts)
            for word, element, parts in zip(words, column, split, strict=True)
        )
        names = []
        for word, element, parts in zip(words, column, split, strict=True):
            texts = []
            for index, _ in element:
                letter, number = word[index], ""
                if index in parts and (letter.size is not None or occurs[letter.symbol] > 1):
                    numbering = numbers.setdefault(letter.symbol, {})
                    number = str(numbering.setdefault(whole, len(numbering) + 1))
                texts.append(letter.symbol + number)
            names.append(separator.join(texts) or _EMPTY_TEXT)
        columns.append(names)
    return columns


def _alignment(
    problem: PairProblem, words: tuple[Word, ...], path: Path, canvas: float, unit: float, weights: Weights
) -> Alignment:
    """The alignment of a path, with its numbers."""
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
                raise AssertionError("A path of an alignment has widths for its letters.")
            widths, strain = after
            worst = max(worst, strain, strains.least_cost(states, column))
        states = [step.state for step in column]
    cells: list[tuple[Element, ...]] = [()] * len(words)
    merged = 0
    for index, row in enumerate(problem.rows):
        elements = _elements([column[index] for column in path])
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
        elements.append((*continued, *((letter, 0) for letter in range(read, until))))
        if until > read:
            part = 0
        state = step.state
    return tuple(elements)
