"""Meshes repeated and bent along the texture coordinates of faces: CGA's ``insertAlongUV``."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import Floats, Ints
from grammarlab.geometry.meshes.clip import slabs
from grammarlab.geometry.meshes.edges import joined
from grammarlab.geometry.meshes.measure import face_normals, is_closed
from grammarlab.geometry.meshes.mesh import Meshes, Soup
from grammarlab.geometry.meshes.ragged import max_rows

_FLAT = 1e-9
"""Share of a unit of texture coordinates up to which lengths and areas count as 0: a tolerance."""
_DECIMALS = 6
"""Decimals of metres up to which points of neighbouring repeats are equal."""
_STEPS = 30
"""Largest number of Newton steps from texture coordinates to shares of a quadrilateral."""


class Patches(NamedTuple):
    """K triangles and quadrilaterals with texture coordinates."""

    owner: Ints
    """[K] mesh of each, ascending."""
    sides: Ints
    """[K] 3 or 4."""
    points: Floats
    """[K, 4, 3] corners in metres; the fourth of a triangle is its third."""
    up: Floats
    """[K, 4, 3] what a height of one metre adds at each corner."""
    coordinates: Floats
    """[K, 4, 2] u and v at the corners."""

    def take(self, rows: Ints) -> Patches:
        """The patches at these rows."""
        return Patches(self.owner[rows], self.sides[rows], self.points[rows], self.up[rows], self.coordinates[rows])

    def is_turned(self) -> NDArray[np.bool_]:
        """[K] whether u and v run clockwise on the face, as in a mirror."""
        return _area(self.coordinates) < 0.0


def patches(meshes: Meshes, coordinates: Floats, along_normals: bool) -> Patches:
    """The convex triangles and quadrilaterals of meshes on which u and v span an area.

    Args:
        meshes: M meshes in metres.
        coordinates: [C, 2] u and v of corners.
        along_normals: whether heights are along the mean normals of the faces at each corner instead of y.
    """
    sides = np.diff(meshes.face_offsets)
    faces = np.flatnonzero((sides == 3) | (sides == 4))
    corner = meshes.face_offsets[faces][:, None] + np.minimum(np.arange(4), sides[faces][:, None] - 1)
    point = meshes.corner_points()[corner]
    up = np.zeros((*point.shape, 3))
    up[..., 1] = 1.0
    if along_normals:
        sums = np.zeros_like(meshes.points)
        np.add.at(sums, meshes.corner_points(), face_normals(meshes)[meshes.face_of_corner()])
        length = np.linalg.norm(sums, axis=1, keepdims=True)
        up = (sums / np.where(length > 0.0, length, 1.0))[point]
    uv = coordinates[corner]
    found = Patches(meshes.mesh_of_face()[faces], sides[faces], meshes.points[point], up, uv)
    return found.take(np.flatnonzero(np.isfinite(uv).all(axis=(1, 2)) & _is_convex(uv) & (np.abs(_area(uv)) > _FLAT)))


def num_tiles(surface: Patches) -> Floats:
    """[K] how many repeats of the unit square each patch may touch."""
    low, high = _tile_range(surface)
    return np.prod(high - low, axis=1)


def bent(asset: Meshes, surface: Patches, height: Floats, num_meshes: int) -> Meshes:
    """A mesh in each unit of u and v, cut to each patch and bent to its place.

    Closed meshes are closed where they are cut, and have no faces between two repeats.

    Args:
        asset: a single mesh; x is u, -z is v, both in 0..1, and y is multiplied by the height.
        surface: K patches.
        height: [K] metres; a negative one leaves faces looking outwards.
        num_meshes: M, the number of meshes that own patches.

    Returns:
        M meshes in metres.
    """
    low, high = _tile_range(surface)
    count = np.prod(high - low, axis=1).astype(np.int64)
    patch = np.repeat(np.arange(len(count)), count)
    number = np.arange(len(patch)) - np.repeat(np.cumsum(count) - count, count)
    wide = (high - low)[patch, 0].astype(np.int64)
    tile = low[patch] + np.stack((number % wide, number // wide), axis=1)
    one = asset.points
    copies = asset.take(np.zeros(len(patch), np.int64))
    place = np.repeat(np.stack((tile[:, 0], np.zeros(len(tile)), tile[:, 1] + 1.0), axis=1), len(one), axis=0)
    copies = copies.with_points(place + np.tile(one * [1.0, 1.0, -1.0], (len(patch), 1)))
    uv, sides = surface.coordinates[patch], surface.sides[patch]
    turned = surface.is_turned()[patch]
    for side in range(4):
        copies = _cut(copies, uv[:, side], _ends(uv, sides, side), turned, side < sides)
    if is_closed(asset)[0]:
        copies = _without_joints(copies, tile, uv, sides)
    flip = turned ^ (height[patch] < 0.0)
    copies = copies.reversed(flip[copies.mesh_of_face()])
    row = patch[copies.mesh_of_point()]
    lifted = _lifted(copies.points, surface.take(row), height[row])
    return _gathered(copies.with_points(lifted), surface.owner[patch], num_meshes)


def _area(uv: Floats) -> Floats:
    """[K] twice the signed area of quadrilaterals [K, 4, 2]."""
    a, b = uv[:, 2] - uv[:, 0], uv[:, 3] - uv[:, 1]
    return a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]


def _is_convex(uv: Floats) -> NDArray[np.bool_]:
    """[K] whether quadrilaterals [K, 4, 2], of which two corners may be equal, turn to one side only."""
    step = np.roll(uv, -1, axis=1) - uv
    following = np.roll(step, -1, axis=1)
    turn = step[..., 0] * following[..., 1] - step[..., 1] * following[..., 0]
    to_left, to_right = np.all(turn >= -_FLAT, axis=1), np.all(turn <= _FLAT, axis=1)
    return np.logical_or(to_left, to_right)


def _tile_range(surface: Patches) -> tuple[Floats, Floats]:
    """[K, 2] first units of u and v that patches reach into, and the ones after the last."""
    low, high = surface.coordinates.min(axis=1), surface.coordinates.max(axis=1)
    first = np.floor(low + _FLAT)
    return first, np.maximum(np.ceil(high - _FLAT), first + 1.0)


def _ends(uv: Floats, sides: Ints, side: int) -> Floats:
    """[K, 2] where an edge of patches ends."""
    return uv[np.arange(len(uv)), np.where(side + 1 < sides, side + 1, 0)]


def _cut(copies: Meshes, start: Floats, end: Floats, turned: NDArray[np.bool_], has_side: NDArray[np.bool_]) -> Meshes:
    """Meshes [K] without what lies outside of an edge of their patches, closed if they were closed."""
    along = end - start
    length = np.linalg.norm(along, axis=1)
    used = has_side & (length > _FLAT)
    along = np.where(used[:, None], along, [1.0, 0.0]) / np.where(used, length, 1.0)[:, None]
    out = np.stack((along[:, 1], -along[:, 0]), axis=1) * np.where(turned, -1.0, 1.0)[:, None]
    rotation = np.zeros((len(out), 3, 3))
    rotation[:, 0, 0], rotation[:, 0, 2] = out.T
    rotation[:, 1, 1] = 1.0
    rotation[:, 2, 0], rotation[:, 2, 2] = -out[:, 1], out[:, 0]
    of_point = copies.mesh_of_point()
    turned_points = np.einsum("pij,pj->pi", rotation[of_point], copies.points)
    level = np.einsum("ki,ki->k", out, start)
    lowest, highest = np.full(len(copies), -1.0), np.full(len(copies), 1.0)
    if len(of_point):
        filled = np.diff(copies.mesh_points) > 0
        lowest[filled] = -max_rows(-turned_points[:, 0], copies.mesh_points, -np.inf)[filled] - 1.0
        highest[filled] = max_rows(turned_points[:, 0], copies.mesh_points, -np.inf)[filled] + 1.0
    high = np.where(used, np.maximum(level, lowest), highest)
    result = slabs(copies.with_points(turned_points), np.arange(len(copies)), 0, lowest, high)
    back = np.einsum("pji,pj->pi", rotation[result.mesh_of_point()], result.points)
    return result.with_points(back)


def _without_joints(copies: Meshes, tile: Floats, uv: Floats, sides: Ints) -> Meshes:
    """Meshes [K] without faces on the border of their units, where the next repeat goes on, inside the patch."""
    plan = copies.points[copies.corner_points()][:, [0, 2]]
    mesh = copies.mesh_of_corner()
    face = copies.face_of_corner()

    def all_on(is_on: NDArray[np.bool_]) -> NDArray[np.bool_]:
        return np.bincount(face, ~is_on, copies.num_faces) == 0

    at_joint = np.zeros(copies.num_faces, bool)
    for axis in range(2):
        for end in (0.0, 1.0):
            at_joint |= all_on(np.abs(plan[:, axis] - tile[mesh, axis] - end) < _FLAT)
    for side in range(4):
        start, along = uv[:, side], _ends(uv, sides, side) - uv[:, side]
        length = np.maximum(np.linalg.norm(along, axis=1), _FLAT)
        offset = plan - start[mesh]
        distance = (offset[:, 0] * along[mesh, 1] - offset[:, 1] * along[mesh, 0]) / length[mesh]
        at_joint &= ~(all_on(np.abs(distance) < 1e3 * _FLAT) & (side < sides)[copies.mesh_of_face()])
    faces = Soup.of_faces(copies, np.arange(copies.num_faces))
    return faces.where(~at_joint).meshes(copies.points, copies.mesh_of_point(), len(copies))


def _lifted(points: Floats, surface: Patches, height: Floats) -> Floats:
    """[P, 3] where points (u, y, v) [P, 3] are on their patches [P]."""
    wanted = points[:, [0, 2]]
    share = np.full((len(points), 2), 0.5)
    is_triangle = surface.sides == 3
    a, b, c, d = np.moveaxis(surface.coordinates, 1, 0)
    for _ in range(_STEPS):
        weights = _weights(share, is_triangle)
        miss = np.einsum("pk,pki->pi", weights, surface.coordinates) - wanted
        s, t = share[:, :1], share[:, 1:]
        by_s = np.where(is_triangle[:, None], b - a, (1.0 - t) * (b - a) + t * (c - d))
        by_t = np.where(is_triangle[:, None], c - a, (1.0 - s) * (d - a) + s * (c - b))
        area = by_s[:, 0] * by_t[:, 1] - by_s[:, 1] * by_t[:, 0]
        area = np.where(area == 0.0, 1.0, area)
        step = np.stack(
            (miss[:, 0] * by_t[:, 1] - miss[:, 1] * by_t[:, 0], miss[:, 1] * by_s[:, 0] - miss[:, 0] * by_s[:, 1]),
            axis=1,
        )
        step /= area[:, None]
        share = share - np.clip(step, -1.0, 1.0)
        if np.abs(step).max(initial=0.0) < 1e-13:
            break
    weights = _weights(share, is_triangle)
    base = np.einsum("pk,pki->pi", weights, surface.points)
    up = np.einsum("pk,pki->pi", weights, surface.up)
    length = np.linalg.norm(up, axis=1)
    return base + (height * points[:, 1] / np.where(length > 0.0, length, 1.0))[:, None] * up


def _weights(share: Floats, is_triangle: NDArray[np.bool_]) -> Floats:
    """[P, 4] weights of the corners of patches at shares [P, 2] of them."""
    s, t = share.T
    zero = 0.0 * s
    of_triangles = np.stack((1.0 - s - t, s, t, zero), axis=1)
    of_quadrilaterals = np.stack(((1.0 - s) * (1.0 - t), s * (1.0 - t), s * t, (1.0 - s) * t), axis=1)
    return np.where(is_triangle[:, None], of_triangles, of_quadrilaterals)


def _gathered(copies: Meshes, owner: Ints, num_meshes: int) -> Meshes:
    """[num_meshes] meshes of all copies of each owner, which share their points; owners ascend."""
    corners = copies.corner_points()
    ends = np.searchsorted(owner, np.arange(num_meshes + 1))
    mesh_points = copies.mesh_points[ends]
    mesh_faces = copies.mesh_faces[ends]
    faces_of = np.repeat(np.arange(num_meshes), np.diff(mesh_faces))
    base = mesh_points[:-1][faces_of].repeat(np.diff(copies.face_offsets))
    together = replace(copies, corners=corners - base, mesh_points=mesh_points, mesh_faces=mesh_faces)
    exact = together.points
    return joined(replace(together, points=np.round(exact, _DECIMALS))).with_points(exact)
