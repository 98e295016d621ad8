"""Facades whose columns (or rows) are parts of bands, and can be repeated by repeating parts.

A band is divided along the edited axis and extends over the whole facade along it: the facade itself, or a storey of it
if columns are repeated. If the parts of a band contain one column each, a column is repeated with the gap before it,
and the first one with the gap after it; the parts before the first and after the last column are fixed. Strips of wall
beside the bands are as long as the bands for any number of columns.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from grammarlab.errors import FacadeError
from grammarlab.facade.editing.pieces import take
from grammarlab.facade.editing.variations import Variation
from grammarlab.facade.grid import Grid
from grammarlab.facade.sizes.size_wishes import Wish
from grammarlab.facade.tree import Facade, Floats, Ints, X


@dataclass(frozen=True, slots=True)
class RepeatedBand:
    """A node whose parts are, in order: a margin, columns with gaps between them, and a margin."""

    node: int
    before: tuple[int, ...]
    """Parts of the first margin."""
    gaps: tuple[tuple[int, ...], ...]
    """[C] parts of the gap before each column if it is not the first."""
    columns: tuple[tuple[int, ...], ...]
    """[C] parts of each column."""
    after: tuple[int, ...]
    """Parts of the last margin."""

    def sequence(self, columns: Sequence[int]) -> list[tuple[int, int]]:
        """The parts of a band with these columns, each with the index of its column; -1 for the first margin."""
        parts = [(-1, part) for part in self.before]
        for place, column in enumerate(columns):
            gap = self.gaps[column] if place else ()
            parts += [(place, part) for part in (*gap, *self.columns[column])]
        return parts + [(len(columns), part) for part in self.after]


@dataclass(frozen=True, eq=False)
class Repeats:
    """The columns of a grid along x, or its rows along y from the bottom; both are called columns here."""

    before: Variation
    """The edited variation."""
    grid: str
    along: int
    bands: tuple[RepeatedBand, ...]
    """Bands with all columns, at least one."""
    strips: tuple[int, ...]
    """Parts of the facade beside the bands that contain no elements."""
    kind: Ints
    """[C] kind of each column; columns of one kind are equal with equal locks, and kinds are numbered by first
    occurrence."""
    needed: tuple[int, ...]
    """Columns with elements in other parts of the facade, of which one each has to stay."""
    locks: tuple[Wish, ...]
    """Locks of nodes of the edited variation."""
    locked: NDArray[np.bool_]
    """[C] whether a part of each column is locked; one column of its kind has to stay."""
    gap_locked: NDArray[np.bool_]
    """[C] whether a part of the gap between the column before and each is locked; one such gap has to stay."""

    def variation(self, columns: Sequence[int]) -> Variation:
        """The facade with these of its columns, in this order, repeated any number of times.

        Raises:
            FacadeError: If a band would have less than two parts, or a needed column is missing.
        """
        if not set(self.needed) <= set(columns):
            raise FacadeError(f"Columns {list(self.needed)} of grid '{self.grid}' have elements elsewhere: keep them.")
        before, facade = self.before, self.before.facade
        source, parent, place = _tree(self, columns)
        wanted = before.wanted[source]
        wanted[:, self.along] *= self._stretch(columns)[source]
        tree = take(facade, parent, facade.axis[source], source, wanted)
        grids = tuple(new for old in facade.grids if (new := _grid(self, old, columns, source, place)) is not None)
        return replace(
            before,
            facade=replace(tree, grids=grids),
            source=before.source[source],
            wanted=wanted,
            shown=before.shown[source],
        )

    def least(self, first: int) -> Ints:
        """[K] least number of columns of each kind if the first column is of this kind."""
        least = np.zeros(int(self.kind.max()) + 1, dtype=np.int64)
        least[[first, *self.kind[self.locked]]] = 1
        # The first column of all has no gap before it.
        least[self.kind[self.gap_locked]] = 1 + (self.kind[self.gap_locked] == first)
        for column in self.needed:
            kind = self.kind[column]
            least[kind] = max(least[kind], 1 + np.searchsorted(np.flatnonzero(self.kind == kind), column))
        return least

    def spread(self, counts: Ints) -> tuple[int, ...]:
        """Columns in order for counts [K] of the kinds: copies are next to their originals."""
        columns: list[int] = []
        for column, kind in enumerate(self.kind.tolist()):
            same = np.flatnonzero(self.kind == kind)
            every, more = divmod(int(counts[kind]), len(same))
            columns += [column] * (every + (int(np.searchsorted(same, column)) < more))
        return tuple(columns)

    def _stretch(self, columns: Sequence[int]) -> Floats:
        """[N] factor of the target of each node: strips are as long as the longest band with these columns."""
        facade = self.before.facade
        size, factor = facade.size[:, self.along], np.ones(len(facade))
        longest = max(size[[part for _, part in band.sequence(columns)]].sum() for band in self.bands)
        for strip in self.strips:
            factor[strip : facade.end[strip]] = longest / size[strip]
        return factor


def find_repeats(before: Variation, grid: Grid, along: int, locks: Sequence[Wish] = ()) -> Repeats | None:
    """The repetition of the columns of a grid; None if no band contains all of them side by side.

    Args:
        before: the edited variation.
        grid: one of its grids.
        along: X to repeat columns, Y to repeat rows.
        locks: locks of nodes of the variation.
    """
    facade = before.facade
    column = _columns(grid, along)
    num, whole = int(column.max(initial=-1)) + 1, [0, *(facade.children[0].tolist() if facade.axis[0] != along else ())]
    bands = [band for node in whole if (band := _band(facade, grid, column, num, node, along)) is not None]
    if not bands or not num:
        return None
    inside = np.zeros(len(facade), dtype=bool)
    for band in bands:
        inside[band.node : facade.end[band.node]] = True
    needed = tuple(np.unique(column[~inside[grid.node]]).tolist())
    filled = _containing(facade, [node for other in facade.grids for node in other.node.tolist()])
    locked = _locked(locks)
    held = _containing(facade, list(locked))
    looks = [tuple(_look(before, band, each, locked) for band in bands) for each in range(num)]
    first = list(dict.fromkeys(looks))
    kind = np.array([first.index(look) for look in looks])
    return Repeats(
        before=before,
        grid=grid.name,
        along=along,
        bands=tuple(bands),
        strips=tuple(part for part in whole[1:] if not inside[part] and not filled[part]),
        kind=kind,
        needed=needed,
        locks=tuple(locks),
        locked=np.array([any(held[list(band.columns[each])].any() for band in bands) for each in range(num)]),
        gap_locked=np.array(
            [each > 0 and any(held[list(band.gaps[each])].any() for band in bands) for each in range(num)]
        ),
    )


def _columns(grid: Grid, along: int) -> Ints:
    """[E] column of each element from the left, or its row from the bottom."""
    return grid.column if along == X else grid.num_rows - 1 - grid.row


def _band(facade: Facade, grid: Grid, column: Ints, num: int, node: int, along: int) -> RepeatedBand | None:
    """A node as a band; None if it is not divided like one."""
    if facade.axis[node] != along:
        return None
    parts = facade.children[node]
    inside = (grid.node > node) & (grid.node < facade.end[node])
    at = np.searchsorted(parts, grid.node[inside], side="right") - 1
    first, last = np.full(num, len(parts)), np.full(num, -1)
    np.minimum.at(first, column[inside], at)
    np.maximum.at(last, column[inside], at)
    if (last < 0).any() or (first[1:] <= last[:-1]).any():
        return None
    part, ends = tuple(parts.tolist()), [0, *(last + 1).tolist()]
    columns = tuple(part[low : high + 1] for low, high in zip(first.tolist(), last.tolist(), strict=True))
    gaps = [part[end:low] for end, low in zip(ends, first.tolist(), strict=False)]
    before, after = gaps[0], part[ends[-1] :]
    gaps[0] = gaps[1] if num > 1 else after
    return RepeatedBand(node, before, tuple(gaps), columns, after)


def _containing(facade: Facade, nodes: Sequence[int]) -> NDArray[np.bool_]:
    """[N] whether each node is one of these, or contains one."""
    before = np.zeros(len(facade) + 1, dtype=np.int64)
    before[1 + np.array(nodes, dtype=np.int64)] = 1
    before = before.cumsum()
    return before[facade.end] > before[:-1]


def _locked(locks: Sequence[Wish]) -> dict[int, frozenset[Wish]]:
    """The locks of each locked node, without the number of the node."""
    found: dict[int, frozenset[Wish]] = {}
    for lock in locks:
        found[lock.node] = found.get(lock.node, frozenset()) | {replace(lock, node=0)}
    return found


def _look(
    before: Variation, band: RepeatedBand, column: int, locked: Mapping[int, frozenset[Wish]]
) -> tuple[object, ...]:
    """A key that is equal for equal columns with equal locks."""
    facade = before.facade
    nodes = np.concatenate([np.arange(part, facade.end[part]) for part in (*band.gaps[column], *band.columns[column])])
    shape = facade.axis[nodes], facade.label[nodes], np.round(before.wanted[nodes] / facade.size[0], 9)
    held = frozenset((place, locked[node]) for place, node in enumerate(nodes.tolist()) if node in locked)
    return (len(band.gaps[column]), held, *(each.tobytes() for each in shape))


def _tree(repeats: Repeats, columns: Sequence[int]) -> tuple[Ints, Ints, Ints]:
    """[N] sources and parents of a new tree, and the column of each node; -2 outside of bands."""
    facade, bands = repeats.before.facade, {band.node: band for band in repeats.bands}
    whole = [0] if 0 in bands else [-1, *facade.children[0].tolist()]
    source, parent, place = [np.zeros(0, np.int64)], [np.zeros(0, np.int64)], [np.zeros(0, np.int64)]
    start = 0

    def add(nodes: Ints, above: int, at: int) -> None:
        nonlocal start
        source.append(nodes)
        parent.append(np.append(above, facade.parent[nodes[1:]] - nodes[0] + start))
        place.append(np.full(len(nodes), at))
        start += len(nodes)

    for node in whole:
        if node not in bands:
            add(np.arange(node, facade.end[node]) if node > 0 else np.zeros(1, np.int64), 0 if node > 0 else -1, -2)
            continue
        parts = bands[node].sequence(columns)
        if len(parts) < 2:
            raise FacadeError("A band needs at least two parts: keep more columns.")
        top = start
        add(np.array([node]), 0 if node else -1, -2)
        for at, part in parts:
            add(np.arange(part, facade.end[part]), top, at)
    return np.concatenate(source), np.concatenate(parent), np.concatenate(place)


def _grid(repeats: Repeats, grid: Grid, columns: Sequence[int], source: Ints, place: Ints) -> Grid | None:
    """A grid with all copies of its elements, each repetition in separate columns; None if it is empty.

    Args:
        repeats: the repeated bands.
        grid: a grid of the edited facade.
        columns: the sequence of columns.
        source: [N] node of that facade that each new node copies.
        place: [N] index of its column in the sequence.
    """
    element = np.full(len(repeats.before.facade), -1, dtype=np.int64)
    element[grid.node] = np.arange(len(grid.node))
    node = np.flatnonzero(element[source] >= 0)
    if not node.size:
        return None
    which = element[source[node]]
    old, at = _columns(grid, repeats.along)[which], place[node]
    # Elements outside of bands belong to the first repetition of their column.
    for each in np.unique(old[at == -2]).tolist():
        same = (
            columns.index(each)
            if grid.name == repeats.grid
            else at[(old == each) & (at > -2)].min(initial=len(columns))
        )
        at[(at == -2) & (old == each)] = same
    _, line = np.unique(np.stack([at, old]), axis=1, return_inverse=True)
    if repeats.along == X:
        return Grid(grid.name, node, np.unique(grid.row[which], return_inverse=True)[1], line)
    return Grid(grid.name, node, line.max() - line, np.unique(grid.column[which], return_inverse=True)[1])
