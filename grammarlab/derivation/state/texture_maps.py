"""Texture coordinates: an affine map from the world to (u, v) for each shape and uv set.

The maps of a derivation are in a table, and shapes refer to them by id. The ids are columns of `Shapes.state`, one for
each uv set that the grammar uses: a grammar without texture coordinates has no such column. Since the maps are relative
to the world, cutting a shape or changing its scope keeps them; operations that move or scale its geometry transform
them (`carried` in `texture_transfer.py`).

Meshes from files have coordinates at their corners (`CornerData`). A shape without a map has these; a map whose source
is a set of the corners is a function of their (u, v) instead of the world.
"""

from __future__ import annotations

from typing import cast

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import Floats
from grammarlab.derivation.state.shapes import Ids, Shapes

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


class TextureMapTable:
    """Maps of one derivation: rows (u, v) of a gradient in their source and a value at its origin."""

    def __init__(self) -> None:
        self._rows = np.empty((16, 2, 4))
        self._was_given = np.empty(16, dtype=bool)
        self._source = np.empty(16, dtype=np.int8)
        self._used = 0
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
        first, end = self._used, self._used + count
        if end > len(self._rows):
            room = max(2 * len(self._rows), end)
            self._rows = np.concatenate([self._rows[:first], np.empty((room - first, 2, 4))])
            self._was_given = np.concatenate([self._was_given[:first], np.empty(room - first, dtype=bool)])
            self._source = np.concatenate([self._source[:first], np.empty(room - first, dtype=np.int8)])
        self._rows[first:end], self._was_given[first:end], self._source[first:end] = maps, was_given, source
        self._used = end
        return np.arange(first, end, dtype=np.int32)

    def take(self, ids: Ids) -> Floats:
        """The maps [N, 2, 4] with these ids, none of them `NONE`."""
        return self._rows.take(ids, axis=0)

    def was_given(self, ids: Ids) -> NDArray[np.bool_]:
        """[N] whether these maps are the initial maps of shapes; none of the ids is `NONE`."""
        return self._was_given.take(ids)

    def source(self, ids: Ids) -> NDArray[np.int8]:
        """[N] sources of these maps, `WORLD` or sets of corners; none of the ids is `NONE`."""
        return self._source.take(ids)

    def used(self, ids: Ids) -> tuple[Floats, Ids]:
        """The maps [K, 2, 4] of a column [N] that operations have made, and the index [N] of each among them.

        Initial maps count as `NONE`, which stays `NONE`. All sources are the world.
        """
        if self._used == 0:
            return self._rows[:0].copy(), ids
        rows = np.flatnonzero(ids >= 0)
        rows = rows[~self._was_given[ids[rows]]]
        different, inverse = np.unique(ids[rows], return_inverse=True)
        index = np.full(len(ids), NONE, dtype=np.int32)
        index[rows] = inverse
        return self._rows[different], index


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
