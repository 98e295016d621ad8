"""How a length is divided, by trying every number of repeats.

Fixed sizes are placed first; all floating sizes share the rest, stretched by one common factor k. Where something
floats, the number of repeats is the one whose k is positive and nearest to 1. Where nothing floats, patterns follow
each other for as long as there is room and the last part is cut.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from grammarlab.errors import DerivationError

THINNEST = 1e-9
"""Parts thinner than this are left out, in metres."""
MOST_PIECES = 100_000


@dataclass(frozen=True)
class Size:
    part: int
    """Which part of the block, in the order of the text."""
    value: float
    """Metres."""
    floating: bool = False


@dataclass(frozen=True)
class Repeat:
    sizes: tuple[Size, ...]


@dataclass(frozen=True)
class Piece:
    part: int
    start: float
    extent: float


def divide(length: float, elements: Sequence[Size | Repeat]) -> list[Piece]:
    """The pieces of a length, along it."""
    elements = [_without_empty(element) for element in elements]
    groups = [element for element in elements if isinstance(element, Repeat)]
    row = _laid_out(elements, _best_counts(length, elements, groups))
    stretch = _stretch(length, row)
    pieces: list[Piece] = []
    start = 0.0
    for size in row:
        extent = size.value * max(stretch, 0.0) if size.floating else size.value
        end = min(start + extent, length)
        if length - end <= THINNEST * (1.0 + length):
            end = length
        if end - start > THINNEST:
            pieces.append(Piece(size.part, start, end - start))
        start += extent
    return pieces


def _without_empty(element: Size | Repeat) -> Size | Repeat:
    """Sizes of zero or less take no room."""
    if isinstance(element, Repeat):
        return Repeat(tuple(s for s in element.sizes if s.value > 0.0))
    return Size(element.part, max(element.value, 0.0), element.floating)


def _laid_out(elements: Sequence[Size | Repeat], counts: Sequence[int]) -> list[Size]:
    """All sizes in a row, the repeated groups written out."""
    row: list[Size] = []
    remaining = iter(counts)
    for element in elements:
        row += element.sizes * next(remaining) if isinstance(element, Repeat) else [element]
    return row


def _stretch(length: float, row: Sequence[Size]) -> float:
    """The factor that makes the floating sizes fill what the fixed ones leave; 0 where nothing floats."""
    fixed = sum(size.value for size in row if not size.floating)
    floats = sum(size.value for size in row if size.floating)
    return (length - fixed) / floats if floats > 0.0 else 0.0


def _shared(total: int, groups: int) -> list[int]:
    """A number of repeats shared among groups as evenly as possible, the first ones getting what is over."""
    return [total // groups + (place < total % groups) for place in range(groups)]


def _best_counts(length: float, elements: Sequence[Size | Repeat], groups: Sequence[Repeat]) -> list[int]:
    """How often each repeated group is used."""
    if not groups:
        return []
    outside = [element for element in elements if isinstance(element, Size)]
    room = length - sum(size.value for size in outside if not size.floating)
    smallest = min((sum(s.value for s in g.sizes) for g in groups), default=0.0)
    if room <= THINNEST or all(not g.sizes for g in groups):
        return [0] * len(groups)
    if room / max(smallest, 1e-300) > MOST_PIECES:
        raise DerivationError("the oracle refuses splits into so many pieces")
    most = int(len(groups) * (room / smallest + 2)) + 1
    if not any(size.floating for size in _laid_out(elements, [1] * len(groups))):
        period = sum(s.value for g in groups for s in g.sizes)
        total = 0
        while total * period / len(groups) < room - THINNEST:
            total += 1
        return _shared(total, len(groups))
    least = 0 if any(size.floating for size in outside) else 1
    best, error = least, float("inf")
    for total in range(least, most):
        factor = _stretch(length, _laid_out(elements, _shared(total, len(groups))))
        if factor > 0.0 and abs(factor - 1.0) < error - 1e-12:
            best, error = total, abs(factor - 1.0)
    return _shared(best, len(groups))
