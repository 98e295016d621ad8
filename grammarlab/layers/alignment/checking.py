"""An independent check of alignments: each constraint of section 5.2 (paper 003), stated on the matrix alone."""

from __future__ import annotations

import itertools
import math
from collections import Counter
from collections.abc import Sequence

from grammarlab.layers.alignment.align import Alignment, Element
from grammarlab.layers.design import Letter, Word

_EXACT = 1e-9
"""Largest rounding error of sums of sizes, as a fraction of the canvas."""


def violations(alignment: Alignment, canvas: float, tolerance: float) -> list[str]:
    """Violated constraints of an alignment, in words; empty for a valid one.

    Args:
        alignment: an alignment from any source.
        canvas: metres.
        tolerance: largest difference of the span and the canvas and largest error of a column, metres.
    """
    words, cells = alignment.words, alignment.cells
    if len(words) != len(cells) or len({len(row) for row in cells}) > 1:
        return ["the matrix does not have one row for each word, with the same number of elements in each row"]
    found = [text for word, row in zip(words, cells, strict=True) for text in _row(word, row)]
    if found:
        return found
    for one, word in enumerate(words):
        if cells[words.index(word)] != cells[one]:
            found.append(f"row {one + 1} differs from the row of an equal word above it")
    columns = list(zip(*cells, strict=True))
    for number, column in enumerate(columns):
        found += [f"column {number + 1}: {text}" for text in _column(words, cells, column, number)]
    return found + _numbers(alignment, canvas, tolerance) + _spreads(alignment, canvas, tolerance)


def _row(word: Word, row: Sequence[Element]) -> list[str]:
    """Violations of one row: it spells its word, splits no visible letter and has no gap where none is allowed."""
    found = []
    parts = [part for element in row for part in element]
    order: dict[int, list[int]] = {}
    for at, part in parts:
        order.setdefault(at, []).append(part)
    if [at for at, part in parts if part == 0] != list(range(len(word))) or parts != sorted(parts):
        found.append("a row does not spell its word")
    if any(numbers != list(range(len(numbers))) for numbers in order.values()):
        found.append("parts of a letter are not in order")
    if any(len(numbers) > 1 and not word[at].transparent for at, numbers in order.items() if at < len(word)):
        found.append("a visible letter is split")
    for before, after in itertools.pairwise(row):
        if before and not after and _at_edge(word[before[-1][0]]):
            found.append(f"no gap is allowed after {word[before[-1][0]].symbol}")
        if after and not before and _at_edge(word[after[0][0]]):
            found.append(f"no gap is allowed before {word[after[0][0]].symbol}")
    return found


def _at_edge(letter: Letter) -> bool:
    return letter.attached or letter.transparent


def _letters(word: Word, element: Element) -> list[Letter]:
    return [word[at] for at, _ in element]


def _opaque(letters: Sequence[Letter]) -> bool:
    return bool(letters) and all(letter.hides for letter in letters)


def _column(
    words: Sequence[Word], cells: Sequence[Sequence[Element]], column: Sequence[Element], number: int
) -> list[str]:
    found = []
    letters = [_letters(word, element) for word, element in zip(words, column, strict=True)]
    if not any(_opaque(each) for each in letters):
        found.append("no element is opaque")
    for each in letters:
        if len({letter.transparent for letter in each}) > 1:
            found.append("transparent letters share an element with others")
    for below, each in enumerate(letters):
        if not any(letter.unoccludable and not letter.transparent for letter in each):
            continue
        for at, above in enumerate(letters[:below]):
            seen = above and not all(letter.transparent for letter in above)
            # The same letters on another layer are in the same position, and hide only each other.
            if seen and not _opaque(above) and words[at] != words[below]:
                found.append("an element that covers only a part lies over an unoccludable letter")
    wide = column_widths(words, cells, number)[2]
    if not wide and any(not each and not any(map(_opaque, letters[:at])) for at, each in enumerate(letters)):
        found.append("a column that takes the remaining length has an unexplained gap")
    return found


def column_widths(words: Sequence[Word], cells: Sequence[Sequence[Element]], number: int) -> tuple[float, float, bool]:
    """Error of a column and its width, both in metres, and whether an element fixes its width."""
    exact, least, hidden = [], [0.0], False
    space = []
    for word, row in zip(words, cells, strict=True):
        element = row[number]
        split = {at for other in row for at, part in other if part}
        sizes = [None if at in split else word[at].size for at, _ in element]
        total = math.fsum(size for size in sizes if size is not None)
        least.append(total)
        if not element:
            if not hidden:
                space.append(0.0)
        elif None not in sizes:
            exact.append(total)
        hidden = hidden or _opaque(_letters(word, element))
    smallest = min(exact + space, default=None)
    return (0.0 if smallest is None else max(least) - smallest), max(least), bool(exact)


def _numbers(alignment: Alignment, canvas: float, tolerance: float) -> list[str]:
    """Violations of the numbers: they must follow from the matrix."""
    columns = [column_widths(alignment.words, alignment.cells, at) for at in range(alignment.num_columns)]
    omega, span = math.fsum(error for error, _, _ in columns), math.fsum(width for _, width, _ in columns)
    if not all(exact for _, _, exact in columns):
        span = max(span, canvas)
    exact = _EXACT * max(canvas, omega, span)
    found = [
        f"the error of column {at + 1} is {error}"
        for at, (error, _, _) in enumerate(columns)
        if error > tolerance + exact
    ]
    merged = sum(len(element) - 1 for row in alignment.cells for element in row if element)
    if abs(span - canvas) > tolerance + exact:
        found.append(f"the span of {span} misses the canvas of {canvas} by more than {tolerance}")
    for name, stated, measured in (("omega", alignment.omega, omega), ("span", alignment.span, span)):
        if abs(stated - measured) > exact:
            found.append(f"{name} is {measured}, not {stated}")
    if merged != alignment.merged:
        found.append(f"{merged} letters are merged, not {alignment.merged}")
    return found


def _spreads(alignment: Alignment, canvas: float, tolerance: float) -> list[str]:
    """Violations of spreads: letters of one symbol without a width of their own cover about the same length."""
    words, cells = alignment.words, alignment.cells
    rows = {word: row for row, word in enumerate(words)}
    often = Counter(letter.symbol for word in rows for letter in word if letter.size is None)
    least: dict[str, list[float]] = {}
    most: dict[str, list[float]] = {}
    for word, row in rows.items():
        split = {at for element in cells[row] for at, part in element if part}
        for at, letter in enumerate(word):
            if not (at in split and letter.size is not None) and (letter.size is not None or often[letter.symbol] < 2):
                continue
            low = high = 0.0
            for column, element in enumerate(cells[row]):
                if at not in {other for other, _ in element}:
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
        if max(least[symbol]) - min(most[symbol]) > tolerance + _EXACT * canvas
    ]
