"""``splitArea``: flat shapes cut into parts of given areas."""

from __future__ import annotations

import numpy as np

from grammarlab.arrays import Floats
from grammarlab.derivation.calls.calls import BlockOperation, BoundCall, BoundPart, Head
from grammarlab.derivation.functions.shape_measures import local_meshes
from grammarlab.derivation.operations.split import AXES, cut_in_slabs, elements_of, pieces_of, whole_turned
from grammarlab.derivation.split_sizes import SplitPieces
from grammarlab.derivation.state.face_tags import with_changed_tags
from grammarlab.geometry.meshes.measure import areas
from grammarlab.geometry.meshes.mesh import Indices, Meshes
from grammarlab.geometry.meshes.ragged import sum_rows
from grammarlab.geometry.meshes.triangulate import triangulate

_STEPS = 60
"""Bisections of an interval until it is as short as numbers of 64 bits can tell apart."""


def split_area(call: BoundCall, heads: tuple[Head, ...]) -> list[BoundPart]:
    """``splitArea(x|y|z, adjust|noAdjust) { area : ... | ... }*``: slabs that contain the given areas, in m².

    ``'x`` is a share of the area of the shape. Areas are those of all faces, so that it is meant for flat shapes.
    """
    words = call.words
    axis = AXES.get(words[0] if words else "")
    if axis is None:
        raise call.error("splitArea expects x, y or z first", "for example splitArea(x) { 100 : A | ~1 : B }")
    call = whole_turned(call, axis)
    meshes = local_meshes(call.shapes, call.workspace)
    total = areas(meshes)
    elements = elements_of(call, heads, total)
    of_area = pieces_of(call, total, elements)
    profile = _Profile(meshes, axis, call.shapes.size[:, axis])
    pieces = [_along_axis(piece, profile) for piece in of_area]
    untagged = with_changed_tags(call.shapes, call.workspace, lambda names: ())
    return cut_in_slabs(call._replace(shapes=untagged), axis, pieces)


class _Profile:
    """Areas of meshes below planes across one axis."""

    def __init__(self, meshes: Meshes, axis: int, length: Floats) -> None:
        triangles, face = triangulate(meshes)
        corners = meshes.points[triangles]
        normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        self._area = 0.5 * np.linalg.norm(normal, axis=1)
        self._low, self._middle, self._high = np.sort(corners[:, :, axis], axis=1).T
        mesh = meshes.mesh_of_face()[face]
        self._offsets = np.searchsorted(mesh, np.arange(len(meshes) + 1))
        self._length = length

    def positions(self, mesh: Indices, area: Floats) -> Floats:
        """[K] where planes have given areas [K] of meshes [K] below them, metres from the origins of the scopes."""
        low, high = np.zeros(len(mesh)), self._length[mesh].copy()
        counts = np.diff(self._offsets)[mesh]
        offsets = np.append(0, np.cumsum(counts))
        rows = np.arange(offsets[-1]) - np.repeat(offsets[:-1] - self._offsets[:-1][mesh], counts)
        for _ in range(_STEPS):
            middle = 0.5 * (low + high)
            is_less = sum_rows(self._below(rows, np.repeat(middle, counts)), offsets) < area
            low, high = np.where(is_less, middle, low), np.where(is_less, high, middle)
        return 0.5 * (low + high)

    def _below(self, rows: Indices, level: Floats) -> Floats:
        """Areas of triangles below levels."""
        low, middle, high, area = self._low[rows], self._middle[rows], self._high[rows], self._area[rows]
        with np.errstate(divide="ignore", invalid="ignore"):
            first = (level - low) ** 2 / ((middle - low) * (high - low))
            last = 1.0 - (high - level) ** 2 / ((high - middle) * (high - low))
        share = np.where(level <= low, 0.0, np.where(level >= high, 1.0, np.where(level < middle, first, last)))
        return area * share


def _along_axis(piece: SplitPieces, profile: _Profile) -> SplitPieces:
    """Pieces between areas as pieces between positions along the axis; those without area have no extent."""
    start = profile.positions(piece.row, piece.start)
    end = profile.positions(piece.row, piece.start + piece.extent)
    return piece._replace(start=start, extent=end - start)


BLOCKS: dict[str, BlockOperation] = {
    "splitArea": BlockOperation(split_area, frozenset({*AXES, "adjust", "noAdjust"}), (1, 2))
}
