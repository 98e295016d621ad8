"""Setbacks by the area that remains (``setbackToArea``) and along the perimeter (``splitAndSetbackPerimeter``)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import Floats
from grammarlab.derivation.calls.calls import Argument, BlockOperation, BoundCall, BoundPart, Head
from grammarlab.derivation.functions.shape_measures import local_meshes
from grammarlab.derivation.functions.street_sides import EdgeMoves
from grammarlab.derivation.operations.outlines import EDGES, Rows, edge_groups, edge_values, parts_of, strips_of
from grammarlab.derivation.operations.split import elements_of, pieces_of
from grammarlab.derivation.split_sizes import SplitPieces
from grammarlab.derivation.state.array_table import is_table
from grammarlab.derivation.state.shapes import take_value
from grammarlab.geometry.meshes.measure import areas, face_areas
from grammarlab.geometry.meshes.mesh import Meshes
from grammarlab.geometry.meshes.ragged import sum_rows

_MOST_STEPS = 60
"""Largest number of attempts to find a distance."""
_PRECISION = 1e-12
"""Share of its area up to which a shape has a given area."""


def setback_to_area(call: BoundCall, heads: tuple[Head, ...]) -> list[BoundPart]:
    """``setbackToArea(area, min, max) { selector : ... | remainder : ... }``: strips such that an area remains, in m².

    All selected edges move by the same distance, or by the same distance more than their minimum in an array, up to
    their maximum. If no distance gives the area, it is the nearest possible one.
    """
    meshes = local_meshes(call.shapes, call.workspace)
    mesh = meshes.mesh_of_face()[meshes.face_of_corner()]
    bounds = [argument for argument in call.values[1:] if is_table(argument.value)]
    least = edge_values(call, bounds[0], meshes, mesh) if bounds else np.zeros(len(mesh))
    most = edge_values(call, bounds[1], meshes, mesh, np.inf) if len(bounds) > 1 else np.full(len(mesh), np.inf)
    groups = edge_groups(call, heads, meshes)
    whole = areas(meshes)
    target = call.column(call.values[0]) * (whole if call.values[0].relative else 1.0)
    problem = _Remainders(meshes, groups, np.maximum(least, 0.0), np.maximum(most, least), mesh)
    distance = _solved(problem, target, whole)
    return strips_of(call, heads, meshes, groups, problem.distances(distance))


class _Remainders(NamedTuple):
    """What remains of meshes when their edges move."""

    meshes: Meshes
    groups: Rows
    least: Floats
    most: Floats
    mesh: Rows

    def distances(self, offset: Floats) -> Floats:
        """[C] setbacks of edges for offsets [N] of meshes."""
        return np.clip(self.least + offset[self.mesh], self.least, self.most)

    def areas(self, offset: Floats, rows: Rows) -> Floats:
        """[R] areas of the remainders of meshes at rows, for offsets [N] of all meshes."""
        from grammarlab.geometry.outlines import setback as strips  # noqa: PLC0415

        part = self.meshes.take(rows)
        chosen = np.flatnonzero(np.isin(self.mesh, rows))
        result = strips.setback(part, self.distances(offset)[chosen], self.groups[chosen])
        remaining = np.where(result.group == strips.REMAINDER, face_areas(result.meshes), 0.0)
        return sum_rows(remaining, result.meshes.mesh_faces)


def _solved(problem: _Remainders, target: Floats, whole: Floats) -> Floats:
    """[N] offsets at which areas [N] remain, by false position with bisection (Illinois)."""
    count = len(whole)
    everything = np.arange(count)
    low = np.zeros(count)
    points = problem.meshes.bounds()
    high = np.linalg.norm(points[1] - points[0], axis=1) + 1.0
    low_value = problem.areas(low, everything) - target if count else low
    high_value = problem.areas(high, everything) - target if count else low
    # Below the smallest or above the largest possible area, the nearest distance is the solution.
    result = np.where(low_value <= 0.0, low, high)
    rows = np.flatnonzero((low_value > 0.0) & (high_value < 0.0))
    for step in range(_MOST_STEPS):
        if len(rows) == 0:
            break
        span = high[rows] - low[rows]
        share = low_value[rows] / (low_value[rows] - high_value[rows])
        trial = low.copy()
        trial[rows] += span * (0.5 if step % 3 == 2 else np.clip(share, 0.01, 0.99))
        value = problem.areas(trial, rows) - target[rows]
        result[rows] = trial[rows]
        is_low = value > 0.0
        low[rows[is_low]], low_value[rows[is_low]] = trial[rows[is_low]], value[is_low]
        high[rows[~is_low]], high_value[rows[~is_low]] = trial[rows[~is_low]], value[~is_low]
        rows = rows[(np.abs(value) > _PRECISION * whole[rows]) & (span > _PRECISION)]
    return result


def split_and_setback_perimeter(call: BoundCall, heads: tuple[Head, ...]) -> list[BoundPart]:
    """``splitAndSetbackPerimeter(offset, first, mask) { length : depth : ... | ... }* { remainder : ... }``.

    The perimeter of each face is divided from its edge number ``first`` on, counter-clockwise, and each section is set
    back by its depth. ``mask`` tells for each edge of each face whether it is part of this perimeter.
    """
    meshes = local_meshes(call.shapes, call.workspace)
    sections = [head for head in heads if head.argument.value != "remainder"]
    perimeter = _Perimeter.of(call, meshes)
    mesh = meshes.mesh_of_face()
    of_faces = [head._replace(argument=_of_rows(head.argument, mesh)) for head in sections]
    elements = elements_of(call.rows(mesh), of_faces, perimeter.length)
    pieces = pieces_of(call, perimeter.length, elements)
    depths = [call.column(head.depth) if head.depth is not None else np.zeros(call.shapes.num) for head in sections]
    cut, groups, distances, origin = perimeter.cut(pieces, depths)
    from grammarlab.geometry.outlines import setback as strips  # noqa: PLC0415

    result = strips.setback(cut, distances, groups)
    moved = EdgeMoves(cut, np.where(groups == strips.REMAINDER, 0.0, distances))
    # Groups are numbered section by section; a part has all groups of its section.
    section = np.append(origin, strips.REMAINDER)[np.where(result.group >= 0, result.group, len(origin))]
    by_section = replace(result, group=section)
    index = {id(head): number for number, head in enumerate(sections)}
    part_groups = [index.get(id(head), strips.REMAINDER) for head in heads]
    return parts_of(call, by_section, heads, part_groups, moved)


def _of_rows(argument: Argument, rows: Rows) -> Argument:
    return argument._replace(value=take_value(argument.value, rows))


class _Perimeter(NamedTuple):
    """The outlines of F faces that are divided, each from a first edge on."""

    meshes: Meshes
    length: Floats
    """[F] metres of all edges that belong to it."""
    start: Floats
    """[C] metres along it at which the edge that leaves each corner begins; NaN for edges that do not belong to it."""
    edge_length: Floats
    """[C] metres."""
    shift: Floats
    """[F] metres along it at which the pattern begins."""

    @classmethod
    def of(cls, call: BoundCall, meshes: Meshes) -> _Perimeter:
        """The perimeters that a call divides."""
        from grammarlab.geometry.meshes.measure import corner_edges  # noqa: PLC0415

        face = meshes.face_of_corner()
        mesh = meshes.mesh_of_face()
        counts = np.diff(meshes.face_offsets)
        lengths = np.linalg.norm(corner_edges(meshes), axis=1)
        pattern, *values = call.values
        first = np.rint(call.column(values[0])).astype(np.int64) if values else np.zeros(len(meshes), int)
        is_member = _mask(call, values[1], meshes) if len(values) > 1 else np.ones(len(face), dtype=bool)
        place = np.arange(len(face)) - meshes.face_offsets[:-1][face]
        turn = (place - first[mesh][face]) % np.maximum(counts[face], 1)
        order = np.lexsort((turn, face))
        along = np.where(is_member, lengths, 0.0)[order]
        ends = np.cumsum(along)
        begins = np.append(ends - along, 0.0)
        base = begins[meshes.face_offsets[:-1]]
        start = np.empty(len(face))
        start[order] = ends - along - base[face[order]]
        total = sum_rows(np.where(is_member, lengths, 0.0), meshes.face_offsets)
        offset = call.column(pattern)[mesh] * (total if pattern.relative else 1.0)
        return cls(meshes, total, np.where(is_member, start, np.nan), lengths, offset)

    def cut(self, pieces: Sequence[SplitPieces], depths: Sequence[Floats]) -> tuple[Meshes, Rows, Floats, Rows]:
        """The faces with corners at the ends of all pieces.

        Returns:
            The meshes, for each of their edges a group (one for each piece, -1 for none) and a depth in metres, and
            for each group the index of its size.
        """
        meshes, mesh = self.meshes, self.meshes.mesh_of_face()
        points, sizes, groups, distances = [], [], [], []
        section: list[int] = []
        ranges: list[list[tuple[float, float, int, float]]] = [[] for _ in range(meshes.num_faces)]
        for size, piece in enumerate(pieces):
            for row, start, extent in zip(piece.row.tolist(), piece.start.tolist(), piece.extent.tolist(), strict=True):
                begin = start + float(self.shift[row])
                ranges[row].append((begin, begin + extent, len(section), float(depths[size][mesh[row]])))
                section.append(size)
        corners = meshes.points[meshes.corner_points()]
        offsets = meshes.face_offsets.tolist()
        for row, (begin, end) in enumerate(pairwise(offsets)):
            total, count = float(self.length[row]), 0
            for corner in range(begin, end):
                following = corner + 1 if corner + 1 < end else begin
                for share, group, depth in self._sections(corner, total, ranges[row]):
                    points.append(corners[corner] + share * (corners[following] - corners[corner]))
                    groups.append(group)
                    distances.append(depth)
                    count += 1
            sizes.append(count)
        cut = Meshes.from_polygons(
            np.array(points).reshape(-1, 3), np.array(sizes, dtype=np.int64), np.diff(meshes.mesh_faces)
        )
        return cut, np.array(groups, dtype=np.int64), np.array(distances), np.array(section, dtype=np.int64)

    def _sections(
        self, corner: int, total: float, ranges: Sequence[tuple[float, float, int, float]]
    ) -> list[tuple[float, int, float]]:
        """Where sections begin along the edge that leaves a corner, as shares of it, with their group and depth."""
        start, length = float(self.start[corner]), float(self.edge_length[corner])
        result = [(0.0, -1, 0.0)]
        if not np.isfinite(start) or length <= 0.0 or total <= 0.0:
            return result
        least = 1e-9 * total
        for begin, end, group, depth in ranges:
            for turn in (-1.0, 0.0, 1.0):  # a shifted pattern passes the first corner
                wrapped = begin % total + turn * total
                low, high = max(wrapped, start), min(wrapped + end - begin, start + length)
                if high - low > least:
                    result += [((low - start) / length, group, depth), ((high - start) / length, -1, 0.0)]
        return _without_repeats(sorted(result, key=lambda entry: (entry[0], entry[1])))


def _without_repeats(entries: Sequence[tuple[float, int, float]]) -> list[tuple[float, int, float]]:
    """Beginnings of sections in order; where several begin at one place the last counts, and none begins at the end."""
    result: list[tuple[float, int, float]] = []
    for entry in entries:
        if result and entry[0] - result[-1][0] < 1e-12:
            result[-1] = (result[-1][0], *entry[1:])
        elif entry[0] < 1.0 - 1e-12:
            result.append(entry)
    return result


def _mask(call: BoundCall, argument: Argument, meshes: Meshes) -> NDArray[np.bool_]:
    """[C] whether edges belong to the perimeter, from an array of truth values; edges beyond its end do not."""
    value = argument.value
    if not is_table(value):
        raise call.error("splitAndSetbackPerimeter expects an array of truth values last")
    mesh = meshes.mesh_of_face()[meshes.face_of_corner()]
    first = np.searchsorted(mesh, np.arange(len(meshes)))
    position = np.arange(len(mesh)) - np.append(first, 0)[mesh]
    result = np.zeros(len(mesh), dtype=bool)
    table = np.asarray(value)[mesh]
    for number in np.unique(table).tolist():
        cells = np.array([bool(cell) for cell in call.workspace.tables[number].cells])
        rows = np.flatnonzero((table == number) & (position < len(cells)))
        result[rows] = cells[position[rows]]
    return result


BLOCKS: dict[str, BlockOperation] = {
    "setbackToArea": BlockOperation(setback_to_area, frozenset(), (1, 4), EDGES),
    "splitAndSetbackPerimeter": BlockOperation(
        split_and_setback_perimeter, frozenset(), (1, 3), frozenset({"remainder"})
    ),
}
