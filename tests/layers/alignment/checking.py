"""An independent check of alignments: each constraint of section 5.2 (paper 003), stated on the matrix alone."""

from __future__ import annotations

import itertools
import math
from collections import Counter
from collections.abc import Sequence

from grammarlab.layers.alignment.align import Alignment, Element
from grammarlab.layers.design import Letter, Word

_ROUNDING = 1e-9
"""Largest rounding error of sums of sizes, as a fraction of the canvas."""


def violations(alignment: Alignment, canvas: float, tolerance: float) -> list[str]:
    """Violated constraints of an alignment, in words; empty for a valid one.

    Args:
        alignment: an alignment from any source.
        canvas: length of the canvas, metres.
        tolerance: largest difference of the span and the canvas and largest error of a column, metres.
    """
    words, cells = alignment.words, alignment.cells
    if len(words) != len(cells) or len({len(row) for row in cells}) > 1:
        return ["the matrix does not have one row for each word, with the same number of elements in each row"]
    violated = [text for word, row in zip(words, cells, strict=True) for text in _row(word, row)]
    if violated:
        return violated
    for row_index, word in enumerate(words):
        if cells[words.index(word)] != cells[row_index]:
            violated.append(f"row {row_index + 1} differs from the row of an equal word above it")
    columns = list(zip(*cells, strict=True))
    for number, column in enumerate(columns):
        violated += [f"column {number + 1}: {text}" for text in _column(words, cells, column, number)]
    return violated + _numbers(alignment, canvas, tolerance) + _spreads(alignment, canvas, tolerance)


def _row(word: Word, row: Sequence[Element]) -> list[str]:
    """Violations of one row: it spells its word, splits no visible letter and has no gap where none is allowed."""
    violated = []
    parts = [part for element in row for part in element]
    order: dict[int, list[int]] = {}
    for index, part in parts:
        order.setdefault(index, []).append(part)
    if [index for index, part in parts if part == 0] != list(range(len(word))) or parts != sorted(parts):
        violated.append("a row does not spell its word")
    if any(numbers != list(range(len(numbers))) for numbers in order.values()):
        violated.append("parts of a letter are not in order")
    if any(len(numbers) > 1 and not word[index].transparent for index, numbers in order.items() if index < len(word)):
        violated.append("a visible letter is split")
    for before, after in itertools.pairwise(row):
        if before and not after and _at_edge(word[before[-1][0]]):
            violated.append(f"no gap is allowed after {word[before[-1][0]].symbol}")
        if after and not before and _at_edge(word[after[0][0]]):
            violated.append(f"no gap is allowed before {word[after[0][0]].symbol}")
    return violated


def _at_edge(letter: Letter) -> bool:
    return letter.attached or letter.transparent


def _letters(word: Word, element: Element) -> list[Letter]:
    return [word[index] for index, _ in element]


def _opaque(letters: Sequence[Letter]) -> bool:
    return bool(letters) and all(letter.hides for letter in letters)


def _column(
    words: Sequence[Word], cells: Sequence[Sequence[Element]], column: Sequence[Element], number: int
) -> list[str]:
    violated = []
    letters = [_letters(word, element) for word, element in zip(words, column, strict=True)]
    if not any(_opaque(group) for group in letters):
        violated.append("no element is opaque")
    for group in letters:
        if len({letter.transparent for letter in group}) > 1:
            violated.append("transparent letters share an element with others")
    for below, group in enumerate(letters):
        if not any(letter.unoccludable and not letter.transparent for letter in group):
            continue
        for upper, above in enumerate(letters[:below]):
            is_visible = above and not all(letter.transparent for letter in above)
            # The same letters on another layer are in the same position, and hide only each other.
            if is_visible and not _opaque(above) and words[upper] != words[below]:
                violated.append("an element that covers only a part lies over an unoccludable letter")
    wide = column_widths(words, cells, number)[2]
    if not wide and any(not group and not any(map(_opaque, letters[:upper])) for upper, group in enumerate(letters)):
        violated.append("a column that takes the remaining length has an unexplained gap")
    return violated


def column_widths(words: Sequence[Word], cells: Sequence[Sequence[Element]], number: int) -> tuple[float, float, bool]:
    """Error of a column and its width, both in metres, and whether an element fixes its width."""
    exact, least, hidden = [], [0.0], False
    gap_sizes = []
    for word, row in zip(words, cells, strict=True):
        element = row[number]
        split = {index for other in row for index, part in other if part}
        sizes = [None if index in split else word[index].size for index, _ in element]
        total = math.fsum(size for size in sizes if size is not None)
        least.append(total)
        if not element:
            if not hidden:
                gap_sizes.append(0.0)
        elif None not in sizes:
            exact.append(total)
        hidden = hidden or _opaque(_letters(word, element))
    smallest = min(exact + gap_sizes, default=None)
    return (0.0 if smallest is None else max(least) - smallest), max(least), bool(exact)


def _numbers(alignment: Alignment, canvas: float, tolerance: float) -> list[str]:
    """Violations of the numbers: they must follow from the matrix."""
    columns = [column_widths(alignment.words, alignment.cells, number) for number in range(alignment.num_columns)]
    omega, span = math.fsum(error for error, _, _ in columns), math.fsum(width for _, width, _ in columns)
    if not all(exact for _, _, exact in columns):
        span = max(span, canvas)
    exact = _ROUNDING * max(canvas, omega, span)
    violated = [
        f"the error of column {number + 1} is {error}"
        for number, (error, _, _) in enumerate(columns)
        if error > tolerance + exact
    ]
    merged = sum(len(element) - 1 for row in alignment.cells for element in row if element)
    if abs(span - canvas) > tolerance + exact:
        violated.append(f"the span of {span} misses the canvas of {canvas} by more than {tolerance}")
    for name, reported, measured in (("omega", alignment.omega, omega), ("span", alignment.span, span)):
        if abs(reported - measured) > exact:
            violated.append(f"{name} is {measured}, not {reported}")
    if merged != alignment.merged:
        violated.append(f"{merged} letters are merged, not {alignment.merged}")
    return violated


def _spreads(alignment: Alignment, canvas: float, tolerance: float) -> list[str]:
    """Violations of spreads: letters of one symbol without a width of their own cover about the same length."""
    words, cells = alignment.words, alignment.cells
    rows = {word: row for row, word in enumerate(words)}
    occurrences = Counter(letter.symbol for word in rows for letter in word if letter.size is None)
    least: dict[str, list[float]] = {}
    most: dict[str, list[float]] = {}
    for word, row in rows.items():
        split = {index for element in cells[row] for index, part in element if part}
        for index, letter in enumerate(word):
            if not (index in split and letter.size is not None) and (
                letter.size is not None or occurrences[letter.symbol] < 2
            ):
                continue
            low = high = 0.0
            for column, element in enumerate(cells[row]):
                if index not in {other for other, _ in element}:
                    continue
                loose = [other for other, _ in element if other in split or word[other].size is None]
                _, width, exact = column_widths(words, cells, column)
                share = width - math.fsum(word[other].size or 0.0 for other, _ in element if other not in loose)
                low += share if len(loose) == 1 else 0.0
                high += share if exact else math.inf
            preferred = [] if letter.size is None else [letter.size]
            least.setdefault(letter.symbol, list(preferred)).append(low)
            most.setdefault(letter.symbol, list(preferred)).append(high)
    return [
        f"letters {symbol} cover {min(most[symbol])} and {max(least[symbol])}"
        for symbol in least
        if max(least[symbol]) - min(most[symbol]) > tolerance + _ROUNDING * canvas
    ]
