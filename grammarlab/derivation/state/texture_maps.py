"""Texture coordinates: an affine map from the world to (u, v) for each shape and uv set.

The maps of a derivation lie in a table, and shapes refer to them by id. The ids are columns of `Shapes.state`, one for
each uv set that the grammar mentions: a grammar without texture coordinates carries none of them. Since the maps count
from the world, cutting a shape or giving it another scope leaves them alone; what moves or scales its geometry takes
them along (`carried` in `texture_transfer.py`).
"""

from __future__ import annotations

from typing import cast

import numpy as np
from numpy.typing import NDArray

from grammarlab.derivation.state.shapes import Floats, Ids, Shapes

NUM_SETS = 10
"""How many uv sets there are: one for each map of a material."""

NONE = -1
"""The id of no map."""


class TextureMapTable:
    """The maps met in one derivation: rows (u, v) of a gradient in the world and a value at its origin."""

    def __init__(self) -> None:
        self._rows = np.empty((16, 2, 4))
        self._was_given = np.empty(16, dtype=bool)
        self._used = 0

    def add(self, maps: Floats, was_given: NDArray[np.bool_]) -> Ids:
        """Ids [N] of maps [N, 2, 4]; one for all where all are the same.

        Args:
            maps: [N, 2, 4] their rows.
            was_given: [N] whether shapes came with them, so that no operation has laid an image by them.
        """
        count = len(maps)
        if count > 1 and (maps == maps[0]).all() and (was_given == was_given[0]).all():
            return self.add(maps[:1], was_given[:1]).repeat(count)
        first, end = self._used, self._used + count
        if end > len(self._rows):
            room = max(2 * len(self._rows), end)
            self._rows = np.concatenate([self._rows[:first], np.empty((room - first, 2, 4))])
            self._was_given = np.concatenate([self._was_given[:first], np.empty(room - first, dtype=bool)])
        self._rows[first:end], self._was_given[first:end] = maps, was_given
        self._used = end
        return np.arange(first, end, dtype=np.int32)

    def take(self, ids: Ids) -> Floats:
        """The maps [N, 2, 4] with these ids, none of them `NONE`."""
        return self._rows.take(ids, axis=0)

    def was_given(self, ids: Ids) -> NDArray[np.bool_]:
        """[N] which of these maps shapes came with; none of the ids is `NONE`."""
        return self._was_given.take(ids)

    def used(self, ids: Ids) -> tuple[Floats, Ids]:
        """The maps [K, 2, 4] of a column [N] that operations have made, and where each of the column is among them.

        Maps that shapes came with count as `NONE`, which stays what it is.
        """
        if self._used == 0:
            return self._rows[:0].copy(), ids
        known = np.flatnonzero(ids >= 0)
        known = known[~self._was_given[ids[known]]]
        different, which = np.unique(ids[known], return_inverse=True)
        place = np.full(len(ids), NONE, dtype=np.int32)
        place[known] = which
        return self._rows[different], place


def map_name(uv_set: int) -> str:
    """The name in `Shapes.state` of the ids of the maps of a uv set; no attribute can have it."""
    return f"uv:{uv_set}"


def projection_name(uv_set: int) -> str:
    """The name in `Shapes.state` of the ids of the maps that ``projectUV`` would give a uv set."""
    return f"projection:{uv_set}"


def map_ids(shapes: Shapes, uv_set: int) -> Ids:
    """[N] the maps of one uv set that the grammar mentions."""
    return cast("Ids", shapes.state[map_name(uv_set)])


def with_maps(shapes: Shapes, uv_set: int, ids: Ids) -> Shapes:
    """The same shapes with other maps [N] of one uv set."""
    return shapes._replace(state={**shapes.state, map_name(uv_set): ids})
