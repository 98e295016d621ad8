"""Sizes of symbols, and with them places of letters: least squares under an alignment (paper 003, section 5.3)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from grammarlab.facade.layers.alignment import Alignment
from grammarlab.facade.tree import Floats


@dataclass(frozen=True)
class Placed:
    """An alignment with its places, in metres from the start of the canvas."""

    ends: Floats
    """[n + 1] borders of columns: the first is 0, the last is the canvas."""
    lower: tuple[Floats, ...]
    """[m][letters] where each letter of each row begins."""
    upper: tuple[Floats, ...]
    """[m][letters] where it ends."""


@dataclass(frozen=True)
class Sizing:
    """Sizes that deviate least from what is preferred."""

    sizes: Mapping[str, float]
    """Metres of each symbol, the same wherever it stands; in the order of first use."""
    placed: tuple[Placed, ...]
    """One for each alignment."""
    error: float
    """Square metres: the sum of squares of deviations from preferred sizes."""
    residual: float
    """What the places miss of all equations and of optimality, measured on them, metres."""


def size_letters(alignments: Sequence[tuple[Alignment, float]], *, gaps: bool = False) -> Sizing | None:
    """The best sizes for alignments of both axes and all groups, each with its canvas; None where there are none.

    Args:
        alignments: with the length of the canvas that each fills, metres.
        gaps: whether elements with letters that are not opaque keep their size, centred in their column (supplement
            002, section 3.4); else they fill it.
    """
    raise NotImplementedError
