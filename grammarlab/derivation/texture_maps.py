"""Texture coordinates: an affine map from the world to (u, v) for each shape and uv set.

The maps of a derivation lie in a pool, and shapes refer to them by id. The ids are columns of `Shapes.state`, one for
each uv set that the grammar mentions: a grammar without texture coordinates carries none of them. Since the maps count
from the world, cutting a shape or giving it another scope leaves them alone; what moves or scales its geometry takes
them along (`carried`).
"""

from __future__ import annotations

from typing import TYPE_CHECKING, cast

import numpy as np
from numpy.typing import NDArray

from grammarlab.derivation.shapes import Floats, Ids, Shapes, Value

if TYPE_CHECKING:
    from grammarlab.derivation.workspace import Workspace

NUM_SETS = 10
"""How many uv sets there are: one for each map of a material."""

NONE = -1
"""The id of no map."""


class TextureMapPool:
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


def without_maps(shapes: Shapes, workspace: Workspace) -> Shapes:
    """The same shapes without texture coordinates."""
    names = [map_name(uv_set) for uv_set in workspace.program.uv_sets]
    if not names:
        return shapes
    nothing = np.full(shapes.num, NONE, dtype=np.int32)
    return shapes._replace(state={**shapes.state, **dict.fromkeys(names, nothing)})


def carried(before: Shapes, after: Shapes, workspace: Workspace) -> Shapes:
    """Shapes that were moved, turned or scaled with their scopes, with the coordinates they had before.

    Along an axis of which the extent is or becomes 0 a map keeps its scale.

    Args:
        before: [N] where they were.
        after: [N] where the same points of the unit cubes of their scopes are now.
        workspace: of the derivation.
    """
    if not workspace.program.uv_sets:
        return after
    state: dict[str, Value] = dict(after.state)
    for uv_set in workspace.program.uv_sets:
        rows = np.flatnonzero(map_ids(after, uv_set) >= 0)
        if len(rows):
            ids = map_ids(after, uv_set).copy()
            ids[rows] = _moved(before.take(rows), after.take(rows), ids[rows], workspace)
            state[map_name(uv_set)] = ids
    return after._replace(state=state)


def _moved(before: Shapes, after: Shapes, ids: Ids, workspace: Workspace) -> Ids:
    """Ids [N] of maps that are after a move what those with given ids were before it."""
    pool, frames = workspace.texture_maps, workspace.frames
    flat = (before.size == 0.0) | (after.size == 0.0)
    shrink = np.where(flat, 1.0, before.size / np.where(flat, 1.0, after.size))
    maps = pool.take(ids)
    local = np.einsum("nai,nij->naj", maps[:, :, :3], frames.rotations(before.frame)) * shrink[:, None, :]
    moved = np.empty_like(maps)
    moved[:, :, :3] = np.einsum("naj,nij->nai", local, frames.rotations(after.frame))
    start = maps[:, :, 3] + np.einsum("nai,ni->na", maps[:, :, :3], before.position)
    moved[:, :, 3] = start - np.einsum("nai,ni->na", moved[:, :, :3], after.position)
    return pool.add(moved, pool.was_given(ids))


def initial_maps(roots: Shapes, uv_sets: frozenset[int], workspace: Workspace) -> dict[str, Value]:
    """The entries of `Shapes.state` of the initial shapes, which come with the coordinates of a straight street.

    u runs along the first edge, v from it across the shape: in set 0 from 0 to 1, in set 1 in metres, in set 2 in
    metres with u from the other end.
    """
    nothing = np.full(roots.num, NONE, dtype=np.int32)
    state: dict[str, Value] = {}
    for uv_set in uv_sets:
        state[projection_name(uv_set)] = nothing
        state[map_name(uv_set)] = nothing
        if uv_set < len(_STREET) and roots.num:
            state[map_name(uv_set)] = workspace.texture_maps.add(
                _street(roots, uv_set, workspace), np.ones(roots.num, dtype=bool)
            )
    return state


_STREET = ((True, False), (False, False), (False, True))
"""For each set that initial shapes come with, whether it runs from 0 to 1, and whether u begins at the other end."""


def _street(roots: Shapes, uv_set: int, workspace: Workspace) -> Floats:
    """[N, 2, 4] the maps of one set of initial shapes."""
    is_unit, is_reversed = _STREET[uv_set]
    x, _, z = np.moveaxis(workspace.frames.rotations(roots.frame), 2, 0)
    width, depth = roots.size[:, 0], roots.size[:, 2]
    u, v = (-x, width) if is_reversed else (x, np.zeros_like(width)), (-z, depth)
    maps = np.empty((roots.num, 2, 4))
    for row, ((gradient, start), extent) in enumerate(zip((u, v), (width, depth), strict=True)):
        share = np.where(extent > 0.0, 1.0 / np.where(extent > 0.0, extent, 1.0), 0.0) if is_unit else 1.0
        maps[:, row, :3] = gradient * np.reshape(share, (-1, 1))
        maps[:, row, 3] = (start - np.einsum("ni,ni->n", gradient, roots.position)) * share
    return maps
