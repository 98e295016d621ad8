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

from grammarlab.arrays import Floats, Ints
from grammarlab.errors import FacadeError
from grammarlab.facade.editing.pieces import take
from grammarlab.facade.editing.variations import Variation
from grammarlab.facade.grid import Grid
from grammarlab.facade.sizes.size_wishes import Wish
from grammarlab.facade.tree import Facade, X


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
        for position, column in enumerate(columns):
            gap = self.gaps[column] if position else ()
            parts += [(position, part) for part in (*gap, *self.columns[column])]
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
    required: tuple[int, ...]
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
            FacadeError: If a band would have less than two parts, or a required column is missing.
        """
        if not set(self.required) <= set(columns):
            raise FacadeError(
                f"Columns {list(self.required)} of grid '{self.grid}' have elements elsewhere: keep them."
            )
        before, facade = self.before, self.before.facade
        source, parent, position = _tree(self, columns)
        target = before.target[source]
        target[:, self.along] *= self._stretch(columns)[source]
        tree = take(facade, parent, facade.axis[source], source, target)
        grids = tuple(new for old in facade.grids if (new := _grid(self, old, columns, source, position)) is not None)
        return replace(
            before,
            facade=replace(tree, grids=grids),
            source=before.source[source],
            target=target,
            visible=before.visible[source],
        )

    def least(self, first: int) -> Ints:
        """[K] least number of columns of each kind if the first column is of this kind."""
        least = np.zeros(int(self.kind.max()) + 1, dtype=np.int64)
        least[[first, *self.kind[self.locked]]] = 1
        # The first column of all has no gap before it.
        least[self.kind[self.gap_locked]] = 1 + (self.kind[self.gap_locked] == first)
        for column in self.required:
            kind = self.kind[column]
            least[kind] = max(least[kind], 1 + np.searchsorted(np.flatnonzero(self.kind == kind), column))
        return least

    def spread(self, counts: Ints) -> tuple[int, ...]:
        """Columns in order for counts [K] of the kinds: copies are next to their originals."""
        columns: list[int] = []
        for column, kind in enumerate(self.kind.tolist()):
            same = np.flatnonzero(self.kind == kind)
            copies, extra = divmod(int(counts[kind]), len(same))
            columns += [column] * (copies + (int(np.searchsorted(same, column)) < extra))
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
    required = tuple(np.unique(column[~inside[grid.node]]).tolist())
    filled = _containing(facade, [node for other in facade.grids for node in other.node.tolist()])
    locked = _locked(locks)
    has_lock = _containing(facade, list(locked))
    signatures = [tuple(_signature(before, band, index, locked) for band in bands) for index in range(num)]
    first = list(dict.fromkeys(signatures))
    kind = np.array([first.index(signature) for signature in signatures])
    return Repeats(
        before=before,
        grid=grid.name,
        along=along,
        bands=tuple(bands),
        strips=tuple(part for part in whole[1:] if not inside[part] and not filled[part]),
        kind=kind,
        required=required,
        locks=tuple(locks),
        locked=np.array([any(has_lock[list(band.columns[index])].any() for band in bands) for index in range(num)]),
        gap_locked=np.array(
            [index > 0 and any(has_lock[list(band.gaps[index])].any() for band in bands) for index in range(num)]
        ),
    )


def counts_in_words(along: int, counts: Sequence[int]) -> str:
    """Numbers of copies in words: of columns from the left, or of rows from the bottom.

    >>> counts_in_words(X, [1, 2, 0])
    'column 2 from the left 2 times, column 3 from the left left out'
    """
    name, side = ("column", "left") if along == X else ("row", "bottom")
    words = [
        f"{name} {column} from the {side} {f'{count} times' if count else 'left out'}"
        for column, count in enumerate(counts, start=1)
        if count != 1
    ]
    return ", ".join(words) or f"every {name} once"


def _columns(grid: Grid, along: int) -> Ints:
    """[E] column of each element from the left, or its row from the bottom."""
    return grid.column if along == X else grid.num_rows - 1 - grid.row


def _band(facade: Facade, grid: Grid, column: Ints, num: int, node: int, along: int) -> RepeatedBand | None:
    """A node as a band; None if it is not divided like one."""
    if facade.axis[node] != along:
        return None
    parts = facade.children[node]
    inside = (grid.node > node) & (grid.node < facade.end[node])
    position = np.searchsorted(parts, grid.node[inside], side="right") - 1
    first, last = np.full(num, len(parts)), np.full(num, -1)
    np.minimum.at(first, column[inside], position)
    np.maximum.at(last, column[inside], position)
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
    node_locks: dict[int, frozenset[Wish]] = {}
    for lock in locks:
        node_locks[lock.node] = node_locks.get(lock.node, frozenset()) | {replace(lock, node=0)}
    return node_locks


def _signature(
    before: Variation, band: RepeatedBand, column: int, locked: Mapping[int, frozenset[Wish]]
) -> tuple[object, ...]:
    """A key that is equal for equal columns with equal locks."""
    facade = before.facade
    nodes = np.concatenate([np.arange(part, facade.end[part]) for part in (*band.gaps[column], *band.columns[column])])
    shape = facade.axis[nodes], facade.label[nodes], np.round(before.target[nodes] / facade.size[0], 9)
    node_locks = frozenset((offset, locked[node]) for offset, node in enumerate(nodes.tolist()) if node in locked)
    return (len(band.gaps[column]), node_locks, *(values.tobytes() for values in shape))


def _tree(repeats: Repeats, columns: Sequence[int]) -> tuple[Ints, Ints, Ints]:
    """[N] sources and parents of a new tree, and the column of each node; -2 outside of bands."""
    facade, bands = repeats.before.facade, {band.node: band for band in repeats.bands}
    whole = [0] if 0 in bands else [-1, *facade.children[0].tolist()]
    source, parent, positions = [np.zeros(0, np.int64)], [np.zeros(0, np.int64)], [np.zeros(0, np.int64)]
    start = 0

    def add(nodes: Ints, above: int, position: int) -> None:
        nonlocal start
        source.append(nodes)
        parent.append(np.append(above, facade.parent[nodes[1:]] - nodes[0] + start))
        positions.append(np.full(len(nodes), position))
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
        for position, part in parts:
            add(np.arange(part, facade.end[part]), top, position)
    return np.concatenate(source), np.concatenate(parent), np.concatenate(positions)


def _grid(repeats: Repeats, grid: Grid, columns: Sequence[int], source: Ints, position: Ints) -> Grid | None:
    """A grid with all copies of its elements, each repetition in separate columns; None if it is empty.

    Args:
        repeats: the repeated bands.
        grid: a grid of the edited facade.
        columns: the sequence of columns.
        source: [N] node of that facade that each new node copies.
        position: [N] index of its column in the sequence.
    """
    element = np.full(len(repeats.before.facade), -1, dtype=np.int64)
    element[grid.node] = np.arange(len(grid.node))
    node = np.flatnonzero(element[source] >= 0)
    if not node.size:
        return None
    elements = element[source[node]]
    old_column, new_column = _columns(grid, repeats.along)[elements], position[node]
    # Elements outside of bands belong to the first repetition of their column.
    for column in np.unique(old_column[new_column == -2]).tolist():
        same = (
            columns.index(column)
            if grid.name == repeats.grid
            else new_column[(old_column == column) & (new_column > -2)].min(initial=len(columns))
        )
        new_column[(new_column == -2) & (old_column == column)] = same
    _, line = np.unique(np.stack([new_column, old_column]), axis=1, return_inverse=True)
    if repeats.along == X:
        return Grid(grid.name, node, np.unique(grid.row[elements], return_inverse=True)[1], line)
    return Grid(grid.name, node, line.max() - line, np.unique(grid.column[elements], return_inverse=True)[1])
