"""Texture coordinates: an affine map from the world to (u, v) for each shape and uv set.

The maps of a derivation are in a table, and shapes refer to them by id. The ids are columns of `Shapes.state`, one for
each uv set that the grammar uses: a grammar without texture coordinates has no such column. Since the maps are relative
to the world, cutting a shape or changing its scope keeps them; operations that move or scale its geometry transform
them (`carried` in `texture_transfer.py`), which is done when a map is read.

Meshes from files have coordinates at their corners (`CornerData`). A shape without a map has these; a map whose source
is a set of the corners is a function of their (u, v) instead of the world.
"""

from __future__ import annotations

from collections.abc import Iterator
from heapq import heappop, heappush
from typing import NamedTuple, TypeVar, cast

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import Flags, Floats, Ints, distinct_rows, ranked, rows_of_groups
from grammarlab.derivation.frames import FrameTable
from grammarlab.derivation.state.shapes import Ids, Shapes

_Entry = TypeVar("_Entry", bound=np.generic)

NUM_SETS = 10
"""Number of uv sets: one for each map of a material."""

NONE = -1
"""Id for the absence of a map: the coordinates are those of the corners of the mesh, if it has some."""
DELETED = -2
"""Id for no coordinates, also if the corners of the mesh have some."""
WORLD = -1
"""Source of maps from the world; other maps have the number of a set of the corners, or `FACES`."""
FACES = -2
"""Source of maps from each rectangular face: u from 0 to 1 along its first edge, v from 0 to 1 away from it."""
_UNKNOWN = -1
"""Row of a map that is not computed yet."""
_ROOM = 16
"""Number of maps that a new table has room for."""


class _Scopes(NamedTuple):
    """Scopes of N shapes."""

    position: Floats
    """[N, 3]"""
    size: Floats
    """[N, 3]"""
    frame: Ids
    """[N]"""

    def take(self, rows: Ints) -> _Scopes:
        """The scopes at ascending rows, each at most once."""
        if len(rows) == len(self.frame):
            return self
        return _Scopes(self.position.take(rows, axis=0), self.size.take(rows, axis=0), self.frame.take(rows))


class Move(NamedTuple):
    """Shapes [N] that were moved, rotated or scaled with their texture coordinates.

    Points of the unit cubes of both scopes of a shape correspond.
    """

    before: _Scopes
    after: _Scopes

    @classmethod
    def of(cls, before: Shapes, after: Shapes) -> Move:
        """The move from shapes [N] to shapes [N]."""
        return cls(*(_Scopes(shapes.position, shapes.size, shapes.frame) for shapes in (before, after)))

    def take(self, rows: Ints) -> Move:
        """The move of the shapes at ascending rows, each at most once."""
        return Move(self.before.take(rows), self.after.take(rows))

    def applied(self, maps: Floats, frames: FrameTable) -> Floats:
        """Maps [N, 2, 4] that give points after the move the coordinates that the given ones gave before it.

        A map keeps its scale along an axis whose extent is or becomes 0.
        """
        (place, size, frame), (next_place, next_size, next_frame) = self
        flat = (size == 0.0) | (next_size == 0.0)
        shrink = np.where(flat, 1.0, size / np.where(flat, 1.0, next_size))
        # Of many shapes few have different gradients, axes and factors.
        first, number = distinct_rows(maps[:, :, :3], frame, next_frame, shrink)
        gradients, factors = maps.take(first, axis=0)[:, :, :3], shrink.take(first, axis=0)
        local = np.einsum("nai,nij->naj", gradients, frames.rotations(frame.take(first))) * factors[:, None, :]
        turned = np.einsum("naj,nij->nai", local, frames.rotations(next_frame.take(first)))
        moved = np.empty_like(maps)
        moved[:, :, :3] = turned.take(number, axis=0)
        start = maps[:, :, 3] + np.einsum("nai,ni->na", maps[:, :, :3], place)
        moved[:, :, 3] = start - np.einsum("nai,ni->na", moved[:, :, :3], next_place)
        return moved


class TextureMapTable:
    """Maps of one derivation: rows (u, v) of a gradient in their source and a value at its origin.

    The maps of moved shapes are computed when they are read: most shapes get other maps before anything reads them.
    """

    def __init__(self, frames: FrameTable) -> None:
        self._frames = frames
        self._rows = np.empty((_ROOM, 2, 4))
        self._num_rows = 0
        self._row = np.empty(_ROOM, dtype=np.int32)
        """Row of each map, `_UNKNOWN` until it is computed."""
        self._was_given = np.empty(_ROOM, dtype=bool)
        self._source = np.empty(_ROOM, dtype=np.int8)
        self._used = 0
        self._moves: list[tuple[Move, Ids]] = []
        """Moves of shapes [N] and their maps [N] before it; they got one new id each."""
        self._first_moved: list[int] = []
        """First new id of each move."""
        self._is_of_world = True
        """Whether the world is the source of all maps."""
        self.has_faces = False
        """Whether the source of a map is `FACES`."""

    def add(self, maps: Floats, was_given: NDArray[np.bool_], source: NDArray[np.int8] | None = None) -> Ids:
        """Ids [N] of maps [N, 2, 4]; one for all where all are the same.

        Args:
            maps: [N, 2, 4] their rows.
            was_given: [N] whether they are the initial maps of shapes, not made by an operation.
            source: [N] `WORLD`, the default, or the set of corners, or `FACES`, whose (u, v, 0) they map.
        """
        count = len(maps)
        if source is None:
            source = np.full(count, WORLD, dtype=np.int8)
        if count > 1 and (maps == maps[0]).all() and (was_given == was_given[0]).all() and (source == source[0]).all():
            return self.add(maps[:1], was_given[:1], source[:1]).repeat(count)
        self.has_faces |= bool((source == FACES).any())
        self._is_of_world &= bool((source == WORLD).all())
        return self._new_ids(count, self._append(maps), was_given, source)

    def moved(self, ids: Ids, move: Move) -> Ids:
        """Maps [N] of moved shapes that had maps `ids` [N]; what is no map from the world stays."""
        is_moved = ids >= 0
        if not self._is_of_world:
            is_moved &= self.source(ids) == WORLD
        if not is_moved.any():
            return ids
        self._moves.append((move, ids))
        self._first_moved.append(self._used)
        new = self._new_ids(len(ids), _UNKNOWN, self.was_given(ids), WORLD)
        return new if is_moved.all() else np.where(is_moved, new, ids)

    def take(self, ids: Ids) -> Floats:
        """The maps [N, 2, 4] with these ids, none of them `NONE`."""
        row = self._known_rows(ids)
        return self._rows.take(row, axis=0)

    def was_given(self, ids: Ids) -> NDArray[np.bool_]:
        """[N] whether maps are the initial maps of shapes; for ids that are no maps, anything."""
        return self._was_given.take(ids, mode="clip")

    def source(self, ids: Ids) -> NDArray[np.int8]:
        """[N] sources of maps, `WORLD` or sets of corners; for ids that are no maps, anything."""
        return self._source.take(ids, mode="clip")

    def used(self, ids: Ids) -> tuple[Floats, Ids]:
        """The different maps [K, 2, 4] of a column [N] that operations have made, and the index [N] of each among them.

        Initial maps count as `NONE`, which stays `NONE`. All sources are the world.
        """
        if self._used == 0:
            return self._rows[:0].copy(), ids
        chosen = np.flatnonzero((ids >= 0) & ~self.was_given(ids))
        different, rank = ranked(self._known_rows(ids.take(chosen)), self._num_rows)
        maps = self._rows.take(different, axis=0)
        first, number = distinct_rows(maps)
        index = np.full(len(ids), NONE, dtype=np.int32)
        index[chosen] = number.take(rank)
        return maps if len(first) == len(maps) else maps.take(first, axis=0), index

    def _new_ids(self, count: int, row: Ids | int, was_given: NDArray[np.bool_], source: NDArray[np.int8] | int) -> Ids:
        """New ids [N] of maps in rows [N]."""
        first, end = self._used, self._used + count
        self._row = _with_room(self._row, first, end)
        self._was_given = _with_room(self._was_given, first, end)
        self._source = _with_room(self._source, first, end)
        self._row[first:end], self._was_given[first:end], self._source[first:end] = row, was_given, source
        self._used = end
        return np.arange(first, end, dtype=np.int32)

    def _append(self, maps: Floats) -> Ids:
        """Rows [N] where maps [N, 2, 4] are stored."""
        first, end = self._num_rows, self._num_rows + len(maps)
        self._rows = _with_room(self._rows, first, end)
        self._rows[first:end] = maps
        self._num_rows = end
        return np.arange(first, end, dtype=np.int32)

    def _known_rows(self, ids: Ids) -> Ids:
        """Rows [N] of maps, computed where they are not known yet."""
        row = self._row.take(ids)
        unknown = np.flatnonzero(row == _UNKNOWN)
        if len(unknown) == 0:
            return row
        self._compute(ids.take(unknown))
        return self._row.take(ids)

    def _compute(self, ids: Ids) -> None:
        """Compute maps [N] that are not known, after those that they are made of."""
        steps: list[tuple[int, Ints]] = []
        wanted: dict[int, Flags] = {}
        latest: list[int] = []

        def want(unknown: Ids) -> None:
            for number, chunk in self._by_move(unknown):
                if number not in wanted:
                    wanted[number] = np.zeros(len(self._moves[number][1]), dtype=bool)
                    heappush(latest, -number)
                wanted[number][chunk - self._first_moved[number]] = True

        want(ids)
        while latest:
            number = -heappop(latest)
            shapes = np.flatnonzero(wanted.pop(number))
            steps.append((number, shapes))
            before = self._moves[number][1].take(shapes)
            want(before.take(np.flatnonzero(self._row.take(before) == _UNKNOWN)))
        for number, shapes in reversed(steps):
            move, before = self._moves[number]
            maps = self._rows.take(self._row.take(before.take(shapes)), axis=0)
            self._row[shapes + self._first_moved[number]] = self._append(move.take(shapes).applied(maps, self._frames))

    def _by_move(self, ids: Ids) -> Iterator[tuple[int, Ids]]:
        """Numbers of the moves that made ids [N], and the ids of each."""
        if len(ids) == 0:
            return
        low, high = (np.searchsorted(self._first_moved, (ids.min(), ids.max()), side="right") - 1).tolist()
        if low == high:
            yield low, ids
            return
        number = np.searchsorted(self._first_moved[low : high + 1], ids, side="right") - 1
        for index, rows in enumerate(rows_of_groups(number, high - low + 1)):
            if len(rows):
                yield low + index, ids.take(rows)


def _with_room(column: NDArray[_Entry], used: int, needed: int) -> NDArray[_Entry]:
    """A column with room for a number of entries, the used ones kept."""
    if needed <= len(column):
        return column
    # What is not used is not written: so it takes no memory yet.
    larger = np.empty((max(2 * len(column), needed), *column.shape[1:]), dtype=column.dtype)
    larger[:used] = column[:used]
    return larger


def map_name(uv_set: int) -> str:
    """Name in `Shapes.state` of the ids of the maps of a uv set; no attribute can have it."""
    return f"uv:{uv_set}"


def projection_name(uv_set: int) -> str:
    """The name in `Shapes.state` of the ids of the maps that ``projectUV`` would give a uv set."""
    return f"projection:{uv_set}"


def map_ids(shapes: Shapes, uv_set: int) -> Ids:
    """[N] maps of one uv set that the grammar uses."""
    return cast("Ids", shapes.state[map_name(uv_set)])


def with_maps(shapes: Shapes, uv_set: int, ids: Ids) -> Shapes:
    """The same shapes with other maps [N] of one uv set."""
    return shapes._replace(state={**shapes.state, map_name(uv_set): ids})
