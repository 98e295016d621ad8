"""Bands of a facade and runs of repeated bands.

Bands are its columns and the piers between them, or its rows and the spandrels between them.
"""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import Floats
from grammarlab.facade.looks import is_door, look_of
from grammarlab.facade.tree import Facade

SAME_PLACE = 1e-6
"""Largest difference of equal edges, as a fraction of the facade's size."""


class Band(NamedTuple):
    """A piece of the facade's width or height."""

    start: float
    """Start from the left or from the bottom, metres."""
    end: float
    has_elements: bool
    """Whether it contains something other than wall; otherwise it is flexible."""

    @property
    def size(self) -> float:
        """Size, metres."""
        return self.end - self.start


class Repeat(NamedTuple):
    """Items that are repeated `turns` times."""

    start: int
    period: int
    turns: int

    @property
    def end(self) -> int:
        """The index after the run."""
        return self.start + self.period * self.turns


def bands(facade: Facade, axis: int) -> list[Band]:
    """The whole width (axis 0) or height (axis 1) as bands that cut no window and no door.

    Windows and doors whose extents overlap share a band. Other elements except walls widen the band of the adjacent
    window, or have a band of their own; elements that extend over several bands, such as cornices, are cut.
    """
    labels = [look_of(name) for name in facade.labels]
    leaves = np.array([leaf for leaf in facade.leaves if not _is_flexible(facade, leaf)], dtype=np.int64)
    core = np.array([labels[label].glazed or is_door(facade.labels[label]) for label in facade.label[leaves]], bool)
    if not core.any():
        core[:] = True
    start = facade.position[leaves, axis] - facade.position[0, axis]
    extents = np.stack([start, start + facade.size[leaves, axis]], axis=1)
    least = SAME_PLACE * facade.size[0, axis]
    element_extents = _joined(extents[core], least)
    adjacent = [extent for extent in extents[~core] if _overlaps(element_extents, extent, least) < 2]
    if len(element_extents):
        element_extents = _joined(np.concatenate([element_extents, *(extent[None] for extent in adjacent)]), least)
    return _filled(element_extents, float(facade.size[0, axis]), least)


def repeated_runs(items: Sequence[Hashable]) -> list[Repeat]:
    """Runs that do not overlap, in their order: the one that saves the most items, and others with as many turns.

    A split divides its room evenly among its repeats, so that repeats with different numbers of turns cannot share a
    split.

    >>> repeated_runs("abcbcbcd"), repeated_runs("abc")
    ([Repeat(start=1, period=2, turns=3)], [])
    >>> [run.start for run in repeated_runs("wwdwwdwww")]
    [0, 6]
    """
    numbers = {item: number for number, item in enumerate(dict.fromkeys(items))}
    column = np.array([numbers[item] for item in items], dtype=np.int64)
    best = _longest(column)
    return [] if best is None else _runs_of_turns(column, 0, best.turns)


def _is_flexible(facade: Facade, leaf: int) -> bool:
    return look_of(facade.name_of(leaf)).is_flexible


def _joined(extents: Floats, least: float) -> Floats:
    """[K, 2] disjoint extents with the same union as extents [N, 2]; those that only touch stay separate."""
    joined: list[list[float]] = []
    for start, end in sorted(extents.tolist()):
        if joined and start < joined[-1][1] - least:
            joined[-1][1] = max(joined[-1][1], end)
        else:
            joined.append([start, end])
    return np.array(joined).reshape(-1, 2)


def _overlaps(standing: Floats, extent: Floats, least: float) -> int:
    return int(((standing[:, 0] < extent[1] - least) & (standing[:, 1] > extent[0] + least)).sum())


def _filled(element_extents: Floats, whole: float, least: float) -> list[Band]:
    """Bands of elements, and the bands between them."""
    result, position = [], 0.0
    for start, end in element_extents.tolist():
        if start - position > least:
            result.append(Band(position, start, has_elements=False))
            position = start
        result.append(Band(position, end, has_elements=True))
        position = end
    if whole - position > least:
        result.append(Band(position, whole, has_elements=False))
    return result


def _longest(column: NDArray[np.int64], turns: int = 0) -> Repeat | None:
    """The run that saves the most items [N], with this number of turns if one is given."""
    best = None
    for period in range(1, len(column) // max(turns, 2) + 1):
        equal = np.concatenate([[0], column[period:] == column[:-period], [0]]).astype(np.int8)
        starts, ends = np.flatnonzero(np.diff(equal) == 1), np.flatnonzero(np.diff(equal) == -1)
        if not len(starts):
            continue
        longest = int(np.argmax(ends - starts))
        count = int(ends[longest] - starts[longest]) // period + 1
        if count < max(turns, 2):
            continue
        run = Repeat(int(starts[longest]), period, turns or count)
        if best is None or (run.turns - 1) * period > (best.turns - 1) * best.period:
            best = run
    return best


def _runs_of_turns(column: NDArray[np.int64], start: int, count: int) -> list[Repeat]:
    """The runs with this number of turns in a range of the items."""
    longest = _longest(column, count)
    if longest is None:
        return []
    before = _runs_of_turns(column[: longest.start], start, count)
    after = _runs_of_turns(column[longest.end :], start + longest.end, count)
    return [*before, longest._replace(start=start + longest.start), *after]
