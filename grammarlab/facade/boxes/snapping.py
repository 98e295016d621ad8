"""Snapping: nearly equal coordinates of sides become equal, so that boxes touch and are aligned."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from grammarlab.facade.tree import Floats, Ints


@dataclass(frozen=True, slots=True)
class Snapped:
    """N boxes with sides on few lines."""

    low: Ints
    """[N, 2] line of the left and of the lower side of each box."""
    high: Ints
    """[N, 2] line of the right and of the upper side; greater than that of `low`."""
    lines: tuple[Floats, Floats]
    """Coordinates of the lines across x and across y, ascending."""
    moved: float
    """Largest move of a side, in the units of the boxes."""


def snap(low: Floats, high: Floats, frame: Floats, tolerance: float) -> Snapped:
    """Boxes with sides on few lines: all sides of a line lie within the tolerance, and the line is at their median.

    Coordinates are divided recursively at their largest gap, until those of each part lie within the tolerance and no
    box has both of its sides there; so even a thin box keeps a size above 0. Boxes that touch exactly and lines with
    distances above the tolerance are unchanged, to the last bit.

    Args:
        low: [N, 2] lower left corners, inside the frame.
        high: [N, 2] upper right corners, larger than `low`.
        frame: [2, 2] lower left and upper right corner of the facade, which do not move.
        tolerance: in the units of the boxes, >= 0.
    """
    low, high = np.vstack([low, frame[:1]]), np.vstack([high, frame[1:]])
    sides = [_snapped_axis(low[:, axis], high[:, axis], tolerance) for axis in (0, 1)]
    lows, highs = np.stack([side[0] for side in sides], axis=1), np.stack([side[1] for side in sides], axis=1)
    lines = sides[0][2], sides[1][2]
    moved = max(
        float(np.abs(lines[axis][lines_of[:, axis]] - before[:, axis]).max())
        for axis in (0, 1)
        for lines_of, before in ((lows, low), (highs, high))
    )
    return Snapped(lows[:-1], highs[:-1], lines, moved)


def _snapped_axis(low: Floats, high: Floats, tolerance: float) -> tuple[Ints, Ints, Floats]:
    """Lines of the lower [N] and higher [N] sides along one axis, and their coordinates; the last box is the frame."""
    sides = np.concatenate([low, high])
    order = np.argsort(sides, kind="stable")
    values, box = sides[order], order % len(low)
    starts = _starts(values, _other_side_before(box), tolerance)
    lines = np.array([np.median(part) for part in np.split(values, starts[1:])])
    lines[0], lines[-1] = low[-1], high[-1]
    line = np.empty(len(sides), dtype=np.int64)
    line[order] = np.searchsorted(starts, np.arange(len(sides)), side="right") - 1
    return line[: len(low)], line[len(low) :], lines


def _other_side_before(box: Ints) -> Ints:
    """[2 N] place of the other side of the same box if it comes first, else -1."""
    places = np.argsort(box, kind="stable").reshape(-1, 2)
    before = np.full(len(box), -1)
    before[places[:, 1]] = places[:, 0]
    return before


def _starts(values: Floats, before: Ints, tolerance: float) -> Ints:
    """Index of the first value of each line, for ascending values [K]."""
    gaps = np.diff(values)
    wide = np.concatenate([[0], 1 + np.flatnonzero(gaps > tolerance), [len(values)]])
    starts, parts = [], list(zip(wide[:-1].tolist(), wide[1:].tolist(), strict=True))
    while parts:
        first, end = parts.pop()
        if values[end - 1] - values[first] <= tolerance and before[first:end].max() < first:
            starts.append(first)
            continue
        inside = gaps[first : end - 1]
        largest = np.flatnonzero(inside == inside.max())
        middle = first + 1 + int(largest[len(largest) // 2])
        parts += [(first, middle), (middle, end)]
    return np.sort(np.array(starts))
