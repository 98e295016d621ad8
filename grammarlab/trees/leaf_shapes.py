"""Outlines of leaves and blossoms as small meshes, at three levels of detail with equal areas.

A leaf lies in the plane y = 0 from its stalk at z = 0 to its tip at z = 1, its blade between x = -1/2 and 1/2, and is
folded along its midrib. Its upper side faces y. A blossom is about z, with petals of length 1.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from grammarlab.arrays import Floats, Ints
from grammarlab.geometry.meshes.mesh import Meshes
from grammarlab.geometry.meshes.triangulate import triangulate

NUM_PETALS = 5
FOLD = 0.2
"""Height of the rim of a blade over its midrib, by the distance from it."""
_STALK_WIDTH = 0.05
"""Width of a stalk by the width of its blade."""
_PETAL_TILT = {1: np.radians(20.0), 2: np.radians(25.0), 3: np.radians(65.0)}
"""Angle of petals from the plane of a blossom: round, pointed, bell."""

Half = tuple[tuple[float, float], ...]
"""Corners (x, z) of a polygon at one side of the midrib, x >= 0."""


@dataclass(frozen=True, slots=True, eq=False)
class LeafMesh:
    """A leaf or a blossom."""

    points: Floats
    """[P, 3] in units of its width, its width and its length; of its length for blossoms."""
    normals: Floats
    """[P, 3] unit vectors, for equal units."""
    coordinates: Floats
    """[P, 2] u across the blade and v along it, 0 to 1."""
    triangles: Ints
    """[T, 3]."""


def _profile(*widths: tuple[float, float]) -> Half:
    """A half blade from its base over points (half width, z) to its tip."""
    return ((0.0, 0.0), *widths, (0.0, 1.0))


def _leaflets(places: Sequence[float], length: float, width: float, forward: float) -> tuple[Half, ...]:
    """Slender leaflets from a midrib at z = places, which point outwards and `forward`."""
    halves = []
    for z in places:
        reach = length * (1.0 - 0.55 * z)
        tip = (reach, min(z + forward * reach, 1.0))
        halves.append(
            (
                (0.0, z),
                (0.45 * reach, z + 0.45 * forward * reach - width / 2),
                tip,
                (0.45 * reach, z + 0.45 * forward * reach + width / 2),
            )
        )
    return tuple(halves)


def _needles(number: int, width: float) -> tuple[Half, ...]:
    """Needles from a twig, which point outwards and forward."""
    halves: list[Half] = [((0.0, 0.0), (width / 2, 0.0), (0.0, 1.0))]
    for place in np.linspace(0.04, 0.86, number).tolist():
        reach = 0.5 * (1.0 - 0.45 * place)
        halves.append(((0.0, place - width), (reach, min(place + 0.55 * reach, 1.0)), (0.0, place + width)))
    return tuple(halves)


_KITE: tuple[Half, ...] = (_profile((0.5, 0.45)),)
_OUTLINES: tuple[tuple[tuple[Half, ...], tuple[Half, ...], tuple[Half, ...]], ...] = (
    # oval
    ((_profile((0.36, 0.2), (0.5, 0.5), (0.34, 0.82)),), (_profile((0.46, 0.35), (0.4, 0.72)),), _KITE),
    # pointed
    ((_profile((0.42, 0.12), (0.5, 0.3), (0.22, 0.7)),), (_profile((0.48, 0.24), (0.2, 0.72)),), _KITE),
    # lance
    ((_profile((0.4, 0.2), (0.5, 0.45), (0.28, 0.78)),), (_profile((0.48, 0.33), (0.28, 0.75)),), _KITE),
    # lobed
    (
        (_profile((0.13, 0.14), (0.3, 0.3), (0.16, 0.36), (0.46, 0.56), (0.24, 0.62), (0.42, 0.82), (0.2, 0.94)),),
        (_profile((0.12, 0.12), (0.36, 0.4), (0.42, 0.72), (0.2, 0.94)),),
        _KITE,
    ),
    # palmate
    (
        (_profile((0.3, -0.04), (0.24, 0.12), (0.5, 0.4), (0.34, 0.42), (0.36, 0.52), (0.14, 0.48), (0.2, 0.72)),),
        (_profile((0.3, 0.0), (0.5, 0.4), (0.16, 0.5)),),
        _KITE,
    ),
    # heart
    (
        (((0.0, 0.08), (0.24, 0.0), (0.48, 0.16), (0.46, 0.4), (0.2, 0.74), (0.0, 1.0)),),
        (((0.0, 0.06), (0.36, 0.04), (0.46, 0.36), (0.0, 1.0)),),
        _KITE,
    ),
    # needle
    ((_profile((0.5, 0.1), (0.4, 0.8)),), _KITE, _KITE),
    # twig of needles
    (_needles(10, 0.04), _needles(4, 0.08), (_profile((0.4, 0.25), (0.3, 0.7)),)),
    # frond
    (
        (*_leaflets(np.linspace(0.06, 0.9, 11).tolist(), 0.5, 0.06, 0.7), ((0.0, 0.0), (0.02, 0.1), (0.0, 1.0))),
        _needles(9, 0.05),
        _needles(3, 0.1),
    ),
    # feather
    (
        (
            *_leaflets((0.12, 0.32, 0.52, 0.7), 0.52, 0.17, 0.45),
            ((0.0, 0.74), (0.1, 0.86), (0.0, 1.0)),
            ((0.0, 0.0), (0.012, 0.1), (0.0, 0.74)),
        ),
        _needles(4, 0.1),
        (_profile((0.4, 0.25), (0.3, 0.7)),),
    ),
)
"""Halves of the blades by leaf shape: at full detail, and with about 40 % and 15 % of its triangles or a few more."""
NUM_SHAPES = len(_OUTLINES)
_PETALS: dict[int, tuple[Half, Half]] = {
    1: (_profile((0.3, 0.35), (0.36, 0.72), (0.16, 0.97)), _profile((0.3, 0.4), (0.3, 0.85))),
    2: (_profile((0.22, 0.35), (0.24, 0.6)), _profile((0.26, 0.5))),
    3: (_profile((0.26, 0.3), (0.32, 0.7)), _profile((0.32, 0.6))),
}
"""Halves of petals by blossom shape, at full and at medium detail."""


@lru_cache(maxsize=64)
def leaf_mesh(shape: int, detail: int) -> LeafMesh:
    """A leaf without a stalk.

    Args:
        shape: 0 to 9, see the parameter ``leaf_shape``.
        detail: 0 full, 1 medium, 2 low. All have the same area.
    """
    halves = _OUTLINES[shape][detail]
    return _blade(halves, _area(_OUTLINES[shape][0]) / _area(halves))


@lru_cache(maxsize=16)
def blossom_mesh(shape: int, detail: int) -> LeafMesh:
    """A blossom.

    Args:
        shape: 1 to 3, see the parameter ``blossom_shape``.
        detail: 0 full, 1 medium, 2 low. All have the same area.
    """
    petal, plain_petal = _PETALS[shape]
    full = _flower(petal, _PETAL_TILT[shape])
    if detail == 0:
        return full
    other = _flower(plain_petal, _PETAL_TILT[shape]) if detail == 1 else _star(_PETAL_TILT[shape])
    scale = np.sqrt(mesh_area(full) / mesh_area(other))
    return LeafMesh(other.points * scale, other.normals, other.coordinates, other.triangles)


def with_stalk(leaf: LeafMesh, stalk: float) -> LeafMesh:
    """A leaf whose blade begins at z = `stalk`, in lengths of the blade; a stalk of positive length is a triangle."""
    points = leaf.points + np.array([0.0, 0.0, stalk])
    if stalk <= 0.0:
        return LeafMesh(points, leaf.normals, leaf.coordinates, leaf.triangles)
    half = _STALK_WIDTH / 2
    corners = np.array([[half, 0.0, 0.0], [0.0, 0.0, stalk + 0.02], [-half, 0.0, 0.0]])
    return LeafMesh(
        np.concatenate([points, corners]),
        np.concatenate([leaf.normals, np.tile([0.0, 1.0, 0.0], (3, 1))]),
        np.concatenate([leaf.coordinates, np.array([[0.52, 0.02], [0.5, 0.04], [0.48, 0.02]])]),
        np.concatenate([leaf.triangles, len(points) + np.array([[0, 2, 1]])]),
    )


def num_leaf_triangles(shape: Ints, detail: int) -> Ints:
    """[N] triangles of leaves of shapes [N], without stalks."""
    return np.array([len(leaf_mesh(number, detail).triangles) for number in range(NUM_SHAPES)])[shape]


def num_blossom_triangles(shape: Ints, detail: int) -> Ints:
    """[N] triangles of blossoms of shapes [N]."""
    return np.array([0, *(len(blossom_mesh(number, detail).triangles) for number in _PETALS)])[shape]


def mesh_area(leaf: LeafMesh) -> float:
    """The area of all triangles, for equal units."""
    a, b, c = leaf.points[leaf.triangles].transpose(1, 0, 2)
    return float(0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum())


def _area(halves: Sequence[Half]) -> float:
    """Area of both halves of a flat blade."""
    area = 0.0
    for half in halves:
        x, z = np.array(half).T
        area += float(np.abs(np.dot(x, np.roll(z, -1)) - np.dot(z, np.roll(x, -1))))
    return area


def _blade(halves: Sequence[Half], width: float) -> LeafMesh:
    """The blade with these right halves and their mirror images, stretched across by a factor."""
    points: list[Floats] = []
    normals: list[Floats] = []
    triangles: list[Ints] = []
    start = 0
    for half in halves:
        x, z = np.array(half).T
        flat = np.stack([x, np.zeros(len(x)), z], axis=1)
        corners, _ = triangulate(Meshes.single(flat, [list(range(len(x)))]))
        a, b, c = flat[corners].transpose(1, 0, 2)
        upside_down = np.cross(b - a, c - a)[:, 1] < 0.0
        corners[upside_down] = corners[upside_down][:, ::-1]
        for side in (1.0, -1.0):
            points.append(np.stack([side * width * x, FOLD * width * x, z], axis=1))
            tilt = np.where(x > 0.0, -side * FOLD, 0.0)
            normal = np.stack([tilt, np.ones(len(x)), np.zeros(len(x))], axis=1)
            normals.append(normal / np.linalg.norm(normal, axis=1)[:, None])
            triangles.append(start + (corners if side > 0 else corners[:, ::-1]))
            start += len(x)
    # Both halves share their midrib.
    rows, vertex = np.unique(np.hstack([np.concatenate(points), np.concatenate(normals)]), axis=0, return_inverse=True)
    coordinates = np.clip(np.stack([0.5 + rows[:, 0] / width, rows[:, 2]], axis=1), 0.0, 1.0)
    return LeafMesh(rows[:, :3], rows[:, 3:], coordinates, vertex.ravel()[np.concatenate(triangles)])


def _flower(half: Half, tilt: float) -> LeafMesh:
    """Petals around the z axis, raised from its plane by an angle in radians."""
    petal = _blade((half,), 1.0)
    # The midrib of a petal lies along x, its upper side faces z, both turned by the tilt.
    cosine, sine = np.cos(tilt), np.sin(tilt)
    x, y, z = petal.points.T
    along, height = cosine * z - sine * y, sine * z + cosine * y
    nx, ny, nz = petal.normals.T
    normal_along, normal_height = cosine * nz - sine * ny, sine * nz + cosine * ny
    parts = []
    for number in range(NUM_PETALS):
        angle = 2.0 * np.pi * number / NUM_PETALS
        c, s = np.cos(angle), np.sin(angle)
        points = np.stack([c * along - s * x, s * along + c * x, height], axis=1)
        normals = np.stack([c * normal_along - s * nx, s * normal_along + c * nx, normal_height], axis=1)
        parts.append((points, normals))
    count = len(petal.points)
    return LeafMesh(
        np.concatenate([points for points, _ in parts]),
        np.concatenate([normals for _, normals in parts]),
        np.tile(petal.coordinates, (NUM_PETALS, 1)),
        np.concatenate([petal.triangles + count * number for number in range(NUM_PETALS)]),
    )


def _star(tilt: float) -> LeafMesh:
    """A blossom of one triangle for each petal."""
    angle = 2.0 * np.pi * np.arange(NUM_PETALS) / NUM_PETALS
    rim = np.stack(
        [np.cos(angle) * np.cos(tilt), np.sin(angle) * np.cos(tilt), np.full(NUM_PETALS, np.sin(tilt))], axis=1
    )
    number = np.arange(NUM_PETALS)
    return LeafMesh(
        np.concatenate([np.zeros((1, 3)), rim]),
        np.tile([0.0, 0.0, 1.0], (NUM_PETALS + 1, 1)),
        np.concatenate([[[0.5, 0.0]], np.stack([number % 2 * 1.0, np.full(NUM_PETALS, 0.8)], axis=1)]),
        np.stack([np.zeros(NUM_PETALS, np.int64), 1 + number, 1 + (number + 1) % NUM_PETALS], axis=1),
    )
