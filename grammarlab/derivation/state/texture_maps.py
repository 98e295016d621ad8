"""Texture coordinates: an affine map from the world to (u, v) for each shape and uv set.

The maps of a derivation are in a table, and shapes refer to them by id. The ids are columns of `Shapes.state`, one for
each uv set that the grammar uses: a grammar without texture coordinates has no such column. Since the maps are relative
to the world, cutting a shape or changing its scope keeps them; operations that move or scale its geometry transform
them (`carried` in `texture_transfer.py`), which is done when a map is read.

Meshes from files have coordinates at their corners (`CornerData`). A shape without a map has these; a map whose source
is a set of the corners is a function of their (u, v) instead of the world.
"""

from __future__ import annotations

from collections import OrderedDict
from typing import NamedTuple, TypeVar, cast

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import Floats, Ints, distinct_rows, ranked
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
_ROOM = 16
"""Number of maps that a new table has room for."""
_MOST_PENDING = 1 << 19
"""Largest number of moved maps that are kept to be computed later, a budget: about 60 MB."""
_MOVE_AS_MAPS = 16
"""Number of moved maps that take the memory of a move's own objects."""


class Scopes(NamedTuple):
    """Scopes of N shapes."""

    position: Floats
    """[N, 3]"""
    size: Floats
    """[N, 3]"""
    frame: Ids
    """[N]"""

    def take(self, rows: Ints) -> Scopes:
        """The scopes at ascending rows, each at most once."""
        if len(rows) == len(self.frame):
            return self
        return Scopes(self.position.take(rows, axis=0), self.size.take(rows, axis=0), self.frame.take(rows))


class Move(NamedTuple):
    """Shapes [N] that were moved, rotated or scaled with their texture coordinates.

    Points of the unit cubes of both scopes of a shape correspond.
    """

    before: Scopes
    after: Scopes

    @classmethod
    def of(cls, before: Shapes, after: Shapes) -> Move:
        """The move from shapes [N] to shapes [N]."""
        return cls(*(Scopes(shapes.position, shapes.size, shapes.frame) for shapes in (before, after)))

    def take(self, rows: Ints) -> Move:
        """The move of the shapes at ascending rows, each at most once."""
        return Move(self.before.take(rows), self.after.take(rows))

    def is_of_one_kind(self) -> bool:
        """Whether all shapes have the same sizes and axes, before and after."""
        return all(bool((column == column[:1]).all()) for scopes in self for column in (scopes.frame, scopes.size))

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


class _Pending(NamedTuple):
    """Maps [N] of moved shapes that are not computed yet; their ids are consecutive."""

    before: Ids
    """[N] the maps before the move."""
    move: Move
    """The move of N shapes."""


class TextureMapTable:
    """Maps of one derivation: rows (u, v) of a gradient in their source and a value at its origin.

    The maps of moved shapes are kept as moves, since most shapes get other maps before anything reads them. When
    something does during the derivation, the moves that led to it are applied, each to all its shapes, and when they
    are too many, the oldest: so each is applied at most once whatever is read, and what is kept is bounded. At the end
    only the maps of leaves are computed.
    """

    def __init__(self, frames: FrameTable) -> None:
        self._frames = frames
        self._rows = np.empty((_ROOM, 2, 4))
        self._num_rows = 0
        self._row = np.empty(_ROOM, dtype=np.int32)
        """Row of each map; until it is computed, ``~first`` with the first id of its move, which is negative."""
        self._was_given = np.empty(_ROOM, dtype=bool)
        self._source = np.empty(_ROOM, dtype=np.int8)
        self._used = 0
        self._pending: OrderedDict[int, _Pending] = OrderedDict()
        """By first id, in ascending order."""
        self._num_pending = 0
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
        rows = np.flatnonzero(is_moved)
        if len(rows) == 0:
            return ids
        before, move = ids.take(rows), move.take(rows)
        is_cheap = self._row[before[0]] >= 0 and _are_alike(before, move)
        new = self._moved_alike(before, move) if is_cheap else self._moved_later(before, move)
        if len(rows) == len(ids):
            return new
        result = ids.copy()
        result[rows] = new
        return result

    def take(self, ids: Ids) -> Floats:
        """The maps [N, 2, 4] with these ids, none of them `NONE`."""
        for first in self._moves_before(ids):
            self._apply(first, self._pending.pop(first))
        return self._rows.take(self._row.take(ids), axis=0)

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
        self._compute(ids.take(chosen))
        different, rank = ranked(self._row.take(ids.take(chosen)), self._num_rows)
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

    def _moved_alike(self, before: Ids, move: Move) -> Ids:
        """Maps [N] of shapes that had the same map; often they have the same again, which is kept once."""
        return self.add(move.applied(self.take(before), self._frames), self.was_given(before))

    def _moved_later(self, before: Ids, move: Move) -> Ids:
        """New ids [N] of maps that are computed later."""
        new = self._new_ids(len(before), ~self._used, self.was_given(before), WORLD)
        self._pending[int(new[0])] = _Pending(before, move)
        self._num_pending += len(before) + _MOVE_AS_MAPS
        self._compute_oldest(_MOST_PENDING)
        return new

    def _compute_oldest(self, most: int) -> None:
        """Compute the oldest pending maps until at most so many are left."""
        while self._num_pending > most:
            self._apply(*self._pending.popitem(last=False))

    def _moves_before(self, ids: Ids) -> list[int]:
        """First ids, ascending, of the pending moves that maps [N] are made by."""
        moves: set[int] = set()
        rest = self._moves_of(ids)
        while rest:
            moves |= rest
            rest = set().union(*(self._moves_of(self._pending[first].before) for first in rest)) - moves
        return sorted(moves)

    def _moves_of(self, ids: Ids) -> set[int]:
        """First ids of the pending moves that maps [N] are the last of."""
        row = self._row.take(ids)
        return set((~row[row < 0]).tolist())

    def _apply(self, first: int, pending: _Pending) -> None:
        """Compute all maps of a move, after those that they are made of."""
        self._num_pending -= len(pending.before) + _MOVE_AS_MAPS
        self._compute_rows(first, pending, np.arange(len(pending.before)))

    def _compute(self, ids: Ids) -> None:
        """Compute the maps [N] that are pending, after those that they are made of."""
        if not self._pending:
            return
        is_wanted = np.zeros(self._used, dtype=bool)
        is_wanted[ids] = True
        steps: list[tuple[int, _Pending, Ints]] = []
        for first, pending in reversed(self._pending.items()):
            end = first + len(pending.before)
            rows = np.flatnonzero(is_wanted[first:end] & (self._row[first:end] < 0))
            if len(rows):
                is_wanted[pending.before.take(rows)] = True
                steps.append((first, pending, rows))
        for first, pending, rows in reversed(steps):
            self._compute_rows(first, pending, rows)

    def _compute_rows(self, first: int, pending: _Pending, shapes: Ints) -> None:
        """Compute the maps of some shapes of a move, whose maps before it are known."""
        maps = self._rows.take(self._row.take(pending.before.take(shapes)), axis=0)
        self._row[first + shapes] = self._append(pending.move.take(shapes).applied(maps, self._frames))


def _are_alike(before: Ids, move: Move) -> bool:
    """Whether all moved shapes [N] had one map, and have the same sizes and axes."""
    return len(before) == 1 or (bool((before == before[0]).all()) and move.is_of_one_kind())


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
