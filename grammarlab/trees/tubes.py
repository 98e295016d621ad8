"""Closed tubes around the axes of stems, with normals and texture coordinates.

The tube of a stem is a chain of rings, closed by a tip at its end and a polygon at its base. The first point of a ring
is repeated at its end with its own texture coordinate, so that a picture goes around a whole number of times.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from grammarlab.arrays import Floats, Ints, index_in_row, offsets_from_counts, row_of_value, take_rows
from grammarlab.geometry.meshes.mesh import Meshes
from grammarlab.scene.instances import PointSurface

PICTURE_WIDTH = 1.0
"""Width of a picture of bark in metres on the trunk."""
_THINNEST_PICTURE = 0.08
"""Smallest width of a picture of bark in metres, on twigs."""
_MOST_REPEATS = 1000.0
"""Largest number of repeats of a picture along a stem, whose fractions fit 32 bits."""
TIP_SHARE = 0.04
"""Largest share of the first radius of a stem that is drawn as a point at its end."""


@dataclass(frozen=True, slots=True, eq=False)
class Rings:
    """Cross-sections of S stems, ragged by `offsets`; the last one of a stem is its end."""

    tree: Ints
    """[S] tree of each stem."""
    offsets: Ints
    """[S + 1] into rings, at least two per stem."""
    sides: Ints
    """[S] corners of a cross-section, at least 3."""
    centre: Floats
    """[R, 3] metres."""
    tangent: Floats
    """[R, 3] unit vectors."""
    side: Floats
    """[R, 3] unit vectors at right angles to the tangents: direction of the first corner."""
    radius: Floats
    """[R] metres, > 0 but at ends."""
    lobes: Ints
    """[S] lobes around each stem, 0 for none."""
    lobe_depth: Floats
    """[S] depth of the lobes by the radius."""

    def take(self, stems: Ints) -> Rings:
        """Selected stems."""
        rows, offsets = take_rows(self.offsets, stems)
        return Rings(
            tree=self.tree[stems],
            offsets=offsets,
            sides=self.sides[stems],
            centre=self.centre[rows],
            tangent=self.tangent[rows],
            side=self.side[rows],
            radius=self.radius[rows],
            lobes=self.lobes[stems],
            lobe_depth=self.lobe_depth[stems],
        )


def joined_rings(parts: list[Rings]) -> Rings:
    """The stems of several levels, ordered by tree."""
    counts = np.concatenate([np.diff(part.offsets) for part in parts])

    def column(name: str) -> np.ndarray:
        return np.concatenate([getattr(part, name) for part in parts])

    rings = Rings(
        tree=column("tree"),
        offsets=offsets_from_counts(counts),
        sides=column("sides"),
        centre=column("centre"),
        tangent=column("tangent"),
        side=column("side"),
        radius=column("radius"),
        lobes=column("lobes"),
        lobe_depth=column("lobe_depth"),
    )
    ascending = bool((rings.tree[1:] >= rings.tree[:-1]).all())
    return rings if ascending else rings.take(np.argsort(rings.tree, kind="stable"))


def num_triangles(num_rings: Ints, sides: Ints) -> Ints:
    """[S] triangles of tubes of `num_rings` [S] cross-sections, the pointed end not counted, of `sides` [S] corners."""
    return sides * (2 * num_rings - 1) + sides - 2


def tubes(rings: Rings, num_trees: int) -> tuple[Meshes, PointSurface]:
    """One mesh of bark for each tree, of the tubes of its stems.

    Args:
        rings: the stems, ordered by tree.
        num_trees: number of trees.
    """
    last = rings.offsets[1:] - 1
    pointed = rings.radius[last] <= TIP_SHARE * rings.radius[rings.offsets[:-1]]
    is_ring = np.ones(len(rings.radius), dtype=bool)
    is_ring[last[pointed]] = False
    ring = np.flatnonzero(is_ring)
    per_stem = np.diff(rings.offsets) - pointed
    stem_of_ring = row_of_value(per_stem)
    around = rings.sides[stem_of_ring] + 1
    # The points of a stem are those of its rings, then its tip.
    stem_points = offsets_from_counts(per_stem * (rings.sides + 1) + 1)
    first_point = offsets_from_counts(around)[:-1] + stem_of_ring
    points = np.empty((stem_points[-1], 3))
    normals, coordinates = np.empty_like(points), np.empty((len(points), 2))

    row = row_of_value(around)
    corner = index_in_row(around)
    target = np.arange(len(row)) + stem_of_ring[row]
    points[target], normals[target] = _surface(rings, ring, stem_of_ring, row, corner)
    u, v = _coordinates(rings, ring, stem_of_ring)
    coordinates[target, 0] = corner * (u / rings.sides)[stem_of_ring[row]]
    coordinates[target, 1] = v[ring][row]
    tip = stem_points[1:] - 1
    # A blunt end is a low dome.
    bulge = np.where(pointed, 0.0, 0.4 * rings.radius[last])
    points[tip] = rings.centre[last] + bulge[:, None] * rings.tangent[last]
    normals[tip] = rings.tangent[last]
    coordinates[tip] = np.stack([u / 2, v[last]], axis=1)

    triangles, stem = _triangles(rings, per_stem, stem_of_ring, first_point, tip)
    tree = rings.tree[stem]
    if num_trees > 1:
        order = np.argsort(tree.astype(np.int32), kind="stable")
        triangles, tree = triangles[order], tree[order]
    mesh_points = stem_points[np.searchsorted(rings.tree, np.arange(num_trees + 1))]
    corners = (triangles - mesh_points[tree][:, None]).ravel() if num_trees > 1 else triangles.ravel()
    meshes = Meshes(
        points=points,
        corners=corners,
        face_offsets=3 * np.arange(len(triangles) + 1),
        mesh_faces=np.searchsorted(tree, np.arange(num_trees + 1)),
        mesh_points=mesh_points,
        tags=np.zeros(len(triangles), np.int8),
    )
    return meshes, PointSurface(normals, coordinates)


def _surface(rings: Rings, ring: Ints, stem_of_ring: Ints, row: Ints, corner: Ints) -> tuple[Floats, Floats]:
    """Points and normals [P, 3] of corners [P] of rings [P]."""
    tangent, side = rings.tangent[ring], rings.side[ring]
    other = np.cross(tangent, side)
    start, cosine, sine = _corner_table(int(rings.sides.max(initial=3)))
    entry = start[rings.sides[stem_of_ring]][row] + corner
    x, y = cosine[entry], sine[entry]
    out = x[:, None] * side[row] + y[:, None] * other[row]
    radius = rings.radius[ring][row]
    normals = out - (_widening(rings)[ring][:, None] * tangent)[row]
    lobed = np.flatnonzero((rings.lobes[stem_of_ring] > 0)[row])
    if len(lobed):
        radius = radius.copy()
        stem = stem_of_ring[row[lobed]]
        angle = rings.lobes[stem] * np.arctan2(y[lobed], x[lobed])
        factor = 1.0 + rings.lobe_depth[stem] * np.sin(angle)
        rise = rings.lobe_depth[stem] * rings.lobes[stem] * np.cos(angle) / factor
        around = x[lobed][:, None] * other[row[lobed]] - y[lobed][:, None] * side[row[lobed]]
        normals[lobed] -= rise[:, None] * around
        radius[lobed] *= factor
    normals /= np.sqrt(np.einsum("ni,ni->n", normals, normals))[:, None]
    return rings.centre[ring][row] + radius[:, None] * out, normals


def _corner_table(most: int) -> tuple[Ints, Floats, Floats]:
    """Cosines and sines of the corners 0..k of polygons of k = 0..most corners, and where those of each k begin."""
    counts = np.arange(most + 1) + 1
    corners = np.maximum(counts - 1, 1).repeat(counts)
    angle = (index_in_row(counts) % corners) * (2.0 * np.pi / corners)
    return offsets_from_counts(counts), np.cos(angle), np.sin(angle)


def _widening(rings: Rings) -> Floats:
    """[R] change of the radius per metre along the stem."""
    step = np.zeros(len(rings.radius))
    step[1:] = np.sqrt(np.einsum("ni,ni->n", *[np.diff(rings.centre, axis=0)] * 2))
    change = np.zeros(len(rings.radius))
    change[1:] = np.diff(rings.radius)
    first = rings.offsets[:-1]
    step[first], change[first] = 0.0, 0.0
    after = np.append(step[1:], 0.0), np.append(change[1:], 0.0)
    # Half a turn at most: the slope at an end would otherwise point along the stem.
    return np.clip((change + after[1]) / np.maximum(step + after[0], 1e-9), -4.0, 4.0)


def _coordinates(rings: Rings, ring: Ints, stem_of_ring: Ints) -> tuple[Floats, Floats]:
    """Repeats [S] of a picture around stems, and its repeats [R] along them from the base of each."""
    circumference = 2.0 * np.pi * rings.radius[rings.offsets[:-1]]
    repeats = np.clip(np.rint(circumference / PICTURE_WIDTH), 1.0, _MOST_REPEATS)
    step = np.zeros(len(rings.radius))
    step[1:] = np.sqrt(np.einsum("ni,ni->n", *[np.diff(rings.centre, axis=0)] * 2))
    step[rings.offsets[:-1]] = 0.0
    distance = np.cumsum(step)
    distance -= distance[rings.offsets[:-1]].repeat(np.diff(rings.offsets))
    longest = np.maximum(distance[rings.offsets[1:] - 1], 1e-9)
    scale = np.minimum(repeats / np.maximum(circumference, _THINNEST_PICTURE), _MOST_REPEATS / longest)
    return repeats, distance * scale.repeat(np.diff(rings.offsets))


def _triangles(rings: Rings, per_stem: Ints, stem_of_ring: Ints, first_point: Ints, tip: Ints) -> tuple[Ints, Ints]:
    """Triangles [T, 3] of all stems, counter-clockwise seen from outside, and the stem [T] of each."""
    ring_offsets = offsets_from_counts(per_stem)
    is_last = np.zeros(len(stem_of_ring), dtype=bool)
    is_last[ring_offsets[1:] - 1] = True
    lower = np.flatnonzero(~is_last)
    counts = rings.sides[stem_of_ring[lower]]
    row = lower.repeat(counts)
    a = first_point[row] + index_in_row(counts)
    c = a + (counts + 1).repeat(counts)
    walls = np.empty((len(a), 6), np.int64)
    walls[:, 0] = walls[:, 3] = a
    walls[:, 1] = a + 1
    walls[:, 2] = walls[:, 4] = c + 1
    walls[:, 5] = c
    wall_stem = stem_of_ring[row].repeat(2)

    stem = row_of_value(rings.sides)
    a = first_point[ring_offsets[1:] - 1][stem] + index_in_row(rings.sides)
    ends = np.stack([a, a + 1, tip[stem]], axis=1)

    base_stem = row_of_value(rings.sides - 2)
    start = first_point[ring_offsets[:-1]][base_stem]
    a = start + index_in_row(rings.sides - 2) + 1
    bases = np.stack([start, a + 1, a], axis=1)
    return (
        np.concatenate([walls.reshape(-1, 3), ends, bases]),
        np.concatenate([wall_stem, stem, base_stem]),
    )
