"""Rows and columns of the elements of a wall, and the lines between them: translational symmetry along both axes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from grammarlab.arrays import Flags, Floats, Ints
from grammarlab.facade.editing.grids import lines

_REGULARITY_TOLERANCE = 0.06
"""Largest difference of positions and a multiple of the pitch, as a fraction of the pitch."""
_MAX_CELL_RATIO = 1.25
"""Size relative to most cells from which a cell beside a wide gap is too large: the gap gets its own row or column."""
_MIN_MARGIN_M = 0.02
"""Least width of a margin beside a grid, metres."""


@dataclass(frozen=True, slots=True)
class Lattice:
    """K rows or columns in order."""

    line: Floats
    """[K + 1] lines around and between them, metres, ascending."""
    pitch: float
    """Distance of neighbours, metres, fitted to all; the mean if they are not regular, 0 for a single one."""
    is_regular: bool
    member: Ints
    """[E] row or column of each element."""

    def __len__(self) -> int:
        return len(self.line) - 1


def lattice(low: Floats, high: Floats, first: float, last: float) -> Lattice:
    """The rows or columns of E intervals.

    If the distance of two neighbours is a multiple of the common pitch, units are missing between them: each missing
    one gets an empty row or column.

    Args:
        low: [E] starts, metres, at least one.
        high: [E] ends, metres.
        first: start of the wall, metres.
        last: end of the wall, metres.
    """
    member = lines(low, high)
    num = int(member.max()) + 1
    lows = np.array([np.median(low[member == k]) for k in range(num)])
    highs = np.array([np.median(high[member == k]) for k in range(num)])
    order = np.argsort(lows + highs, kind="stable")
    rank = np.empty(num, dtype=np.int64)
    rank[order] = np.arange(num)
    lows, highs, member = lows[order], highs[order], rank[member]
    middle = (lows + highs) / 2.0
    step = _steps(middle, highs - lows)
    is_gap = _apart(lows, highs) & (step == 1)
    step[is_gap] += 1
    index = np.concatenate([[0], np.cumsum(step)]).astype(np.int64)
    pitch, regular = _pitch(index, middle)
    line = _lines(index, lows, highs, is_gap, first, last)
    line[0] = min(line[0], _edge(float(low.min()), _MIN_MARGIN_M, first, -1.0))
    line[-1] = max(line[-1], _edge(float(high.max()), _MIN_MARGIN_M, last, 1.0))
    return Lattice(line, pitch, regular, index[member])


def _steps(middle: Floats, size: Floats) -> Ints:
    """[K - 1] number of pitches between neighbours: 1, or more if units are missing."""
    gap = np.diff(middle)
    if len(gap) < 3:
        return np.ones(len(gap), dtype=np.int64)
    pitch = float(np.median(gap))
    times = np.rint(gap / pitch)
    fits = (times >= 2) & (np.abs(gap - times * pitch) <= _REGULARITY_TOLERANCE * pitch)
    # Large elements, such as shops, are far from others although no unit is missing.
    fits &= np.maximum(size[:-1], size[1:]) <= 1.25 * np.median(size)
    return np.where(fits, times, 1).astype(np.int64)


def _apart(low: Floats, high: Floats) -> Flags:
    """[K - 1] whether neighbours are so far apart that both of their cells would be larger than others."""
    gap = low[1:] - high[:-1]
    if len(gap) < 3:
        return np.zeros(len(gap), dtype=bool)
    padded = np.concatenate([gap[:1], gap, gap[-1:]])
    cell = high - low + (padded[:-1] + padded[1:]) / 2.0
    large = cell > _MAX_CELL_RATIO * np.median(cell)
    return (
        large[:-1] & large[1:] & (gap > _MAX_CELL_RATIO * np.maximum(padded[:-2], padded[2:])) & (gap > np.median(gap))
    )


def _pitch(index: Ints, middle: Floats) -> tuple[float, bool]:
    if len(index) < 2:
        return 0.0, False
    slope, start = np.polyfit(index, middle, 1)
    regular = bool(np.abs(middle - start - slope * index).max() <= _REGULARITY_TOLERANCE * slope)
    return float(slope), regular


def _lines(index: Ints, low: Floats, high: Floats, is_gap: Flags, first: float, last: float) -> Floats:
    """[K + 1] lines halfway between neighbours; outer ones as far away as inner ones, but within the wall."""
    line = np.zeros(index[-1] + 2)
    for k in range(len(index) - 1):
        midpoint, steps = (high[k] + low[k + 1]) / 2.0, index[k + 1] - index[k]
        if is_gap[k]:
            half = float(np.median(low[1:] - high[:-1])) / 2.0
            line[index[k] + 1 : index[k] + 3] = high[k] + half, low[k + 1] - half
        elif steps == 1:
            line[index[k] + 1] = midpoint
        else:
            pitch = (low[k + 1] + high[k + 1] - low[k] - high[k]) / 2.0 / steps
            line[index[k] + 1 : index[k + 1] + 1] = (low[k] + high[k]) / 2.0 + pitch * (np.arange(steps) + 0.5)
    if len(index) == 1:
        half = min((high[0] - low[0]) / 2.0, max(low[0] - first, 0.0) / 2.0, max(last - high[0], 0.0) / 2.0)
        before = after = half
    else:
        before, after = line[1] - high[0], low[-1] - line[-2]
    line[0] = _edge(low[0], before, first, -1.0)
    line[-1] = _edge(high[-1], after, last, 1.0)
    return line


def _edge(side: float, room: float, end: float, sign: float) -> float:
    """End of the grid: as much room as inside, if the wall has it plus a margin; otherwise half of the room."""
    available = max((end - side) * sign, 0.0)
    if available <= _MIN_MARGIN_M:
        return end
    room = max(room, _MIN_MARGIN_M / 2.0)
    return side + sign * (room if room <= available - _MIN_MARGIN_M else available / 2.0)
