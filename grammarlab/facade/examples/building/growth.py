"""Places in the buildings of a family as CGA: each axis grows between two planes with the size of the main wall."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from grammarlab.facade.examples.building.assembly import Tiling
from grammarlab.facade.examples.mesh.surface import Floats
from grammarlab.facade.writing.family import HEIGHT, WIDTH
from grammarlab.facade.writing.rule_text import number
from grammarlab.facade.writing.structure.kinds import KindSequence
from grammarlab.facade.writing.structure.storeys import Storeys

_DIGITS, _RATE_DIGITS = 6, 9


@dataclass(frozen=True, slots=True)
class Growth:
    """Growth along an axis: what is between two planes is stretched, what is beyond the higher one moves."""

    axis: int
    low: float
    """Coordinates of the planes in the building that the family is made from, metres."""
    high: float
    attribute: str
    """Attribute with the size of the main wall."""
    usual: float
    """Size of the main wall in that building, metres."""

    def rate(self, at: float) -> float:
        """Movement of a place per metre of growth, 0 to 1."""
        return min(max((at - self.low) / (self.high - self.low), 0.0), 1.0)


@dataclass(frozen=True, slots=True)
class Grown:
    """Growth of a building relative to the lower left corner of its main wall."""

    corner: Floats
    """[3] metres."""
    growths: tuple[Growth, ...]

    def place(self, at: Floats) -> tuple[str, str, str]:
        """CGA of a place [3], relative to the corner."""
        x, y, z = (self._text(axis, float(at[axis] - self.corner[axis]), self._rate(axis, at)) for axis in range(3))
        return x, y, z

    def size(self, low: Floats, high: Floats) -> tuple[str, str, str]:
        """CGA of the distances [3] between two places."""
        x, y, z = (
            self._text(axis, float(high[axis] - low[axis]), self._rate(axis, high) - self._rate(axis, low))
            for axis in range(3)
        )
        return x, y, z

    def _rate(self, axis: int, at: Floats) -> float:
        return next((each.rate(float(at[axis])) for each in self.growths if each.axis == axis), 0.0)

    def _text(self, axis: int, value: float, rate: float) -> str:
        factor = number(rate, _RATE_DIGITS)
        if factor == "0":
            return number(value, _DIGITS)
        growth = next(each for each in self.growths if each.axis == axis)
        start = number(value - rate * growth.usual, _DIGITS)
        return f"{start} + {'' if factor == '1' else f'{factor} * '}{growth.attribute}"


def grown(main: Tiling, rows: KindSequence, storeys: Storeys) -> Grown:
    """The growth of a building with the columns and rows of its main wall, which faces z.

    The two lowest rows and the highest one keep their sizes, as far as they occur in every facade.

    Args:
        main: the main wall of the building that the family is made from.
        rows: its rows in kinds.
        storeys: the possible numbers of turns of its runs of rows.
    """
    lowest, highest = _kept(rows, storeys)
    columns, lines = main.columns, main.rows
    return Grown(
        np.array([columns[0], lines[0], main.plane]),
        (
            Growth(0, float(columns[0]), float(columns[-1]), WIDTH, float(columns[-1] - columns[0])),
            Growth(1, float(lines[lowest]), float(lines[-1 - highest]), HEIGHT, float(lines[-1] - lines[0])),
        ),
    )


def _kept(rows: KindSequence, storeys: Storeys) -> tuple[int, int]:
    """Number of lowest and of highest rows that are the same in every facade."""
    num, fewest = len(rows.kind), len(rows.kind)
    below, above = num, num
    if storeys.runs:
        turns = [
            min(run.turns, *times) for run, times in zip(storeys.runs, zip(*storeys.times, strict=True), strict=True)
        ]
        first, last = storeys.runs[0], storeys.runs[-1]
        below = first.start + turns[0] * first.period
        above = num - last.end + turns[-1] * last.period
        fewest -= sum((run.turns - least) * run.period for run, least in zip(storeys.runs, turns, strict=True))
    lowest = max(0, min(2, below, fewest // 2))
    return lowest, max(0, min(1, above, fewest - 1 - lowest))
