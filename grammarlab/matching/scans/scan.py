"""Scans and meshes of facades (PLY, LAS and LAZ, OBJ, STL, GLB, OFF), with the up axis that their points show.

A wall is vertical for two axes if it faces the third one, and the ground is a wall for the wrong axis; so vertical
planes alone do not decide. Elements do: walls have windows that repeat, and the ground has none.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import BinaryIO

import numpy as np
import trimesh

from grammarlab.arrays import Floats, index_in_row, row_of_value
from grammarlab.assets.mesh_files import read_parts, without_neighbours
from grammarlab.assets.mesh_parts import joined
from grammarlab.errors import AssetError, FacadeError
from grammarlab.extras import require
from grammarlab.facade.values import UP_AXES, read_bounded
from grammarlab.files import open_regular
from grammarlab.matching.elements import FARTHEST, MOST_POINTS
from grammarlab.matching.scans.repetition import repeated
from grammarlab.matching.scans.scan_boxes import FacadePlane, find_boxes
from grammarlab.matching.scans.wall_cells import facades

MESHES = (".ply", ".obj", ".stl", ".glb", ".off")
"""Suffixes of files of meshes; a PLY file may also be a scan."""
SCANS = (".las", ".laz")
"""Suffixes of files of scans."""
_MIN_WALL_RATIO = 0.05
"""Least number of points of a wall, as a share of those of the wall for another axis."""
_MAX_DISTANCE_M = 0.02
"""Largest distance of points of a wall from its plane, metres."""
_MAX_PLANES = 2
"""Largest number of planes whose elements are compared."""
_MIN_COUNT_RATIO = 1.5
"""Least ratio of numbers of elements that is more than an accident of noise."""
_TOLERANCE_M = 0.05
"""Least tolerance of equal elements, metres."""
_GROUND_SHARE = 0.1
"""Part of the height, at the bottom, in which the ground lies."""
_MIN_GROUND_SHARE = 0.05
"""Least share of the points on the ground."""
_LEVEL_M = 0.05
"""Thickness of the ground, metres."""
_MIN_EDGE_ANGLE = np.radians(20.0)
"""Least angle between faces at a sharp edge, radians."""
_SPACING_M = 0.02
"""Distance of sample points on meshes and their edges, metres."""
_MAX_SAMPLES = 2_000_000
"""Largest number of sample points on faces, and on edges."""
_MOST_BYTES = 256 * 2**20
"""Largest size of a mesh, bytes."""
_MOST_SCAN_BYTES = 1 << 31
"""Largest size of a scan, and of a PLY file, which may be one, bytes."""
_BYTES_PER_POINT = 0.01
"""Least size of a point in a file: LAZ stores a million equal points in 12 kB."""
_MAX_ROUNDING_M = 0.02
"""Largest rounding step of coordinates, metres."""


def read_surfaces(path: Path, unit: float = 1.0, up: str = "") -> Iterator[tuple[str, FacadePlane]]:
    """The facades of a scan, or of a sampled mesh, the one with the most points first; each with its up axis.

    Args:
        path: the file.
        unit: length of a unit of its coordinates, metres.
        up: a key of `UP_AXES`; if empty, the likely one as `_up_axes`, then the other one.

    Raises:
        FacadeError: If a file cannot be read, has too many points, or numbers that are not finite.
    """
    suffix = path.suffix.lower()
    points, num_edges = (_las(path, unit), 0) if suffix in SCANS else _mesh(path, unit)
    complaints = []
    axes = (up,) if up else _up_axes(points, num_edges, suffix)
    for axis in axes:
        try:
            for facade in facades(points[:, UP_AXES[axis]]):
                yield axis, _plane_of(facade, num_edges)
        except FacadeError as error:
            complaints.append(error)
    if len(complaints) == len(axes):
        raise FacadeError(f"{path.name}: {complaints[0]}") from complaints[0]


def _las(path: Path, unit: float) -> Floats:
    """[P, 3] points of a LAS or LAZ file, metres.

    Raises:
        AssetError: If it is a pipe or a device.
        FacadeError: If it is broken or too large.
    """
    require("laspy")
    with open_regular(path) as file:
        size = os.fstat(file.fileno()).st_size
        if size > _MOST_SCAN_BYTES:
            raise FacadeError(f"{path.name}: expected at most {_MOST_SCAN_BYTES:,} bytes. Thin out the points.")
        try:
            points = _las_points(file, size)
        except Exception as error:  # laspy and its decoders raise any exception
            raise FacadeError(f"{path.name} cannot be read: {error}.") from error
    return _checked(points, path, unit)


def _las_points(file: BinaryIO, size: int) -> Floats:
    """[P, 3] points of an open LAS or LAZ file of a size in bytes; at most one more than may be read."""
    import laspy  # noqa: PLC0415 an extra

    with laspy.open(file, closefd=False) as reader:
        count = reader.header.point_count
        if count * _BYTES_PER_POINT > size:  # memory is taken for all of them at once
            raise ValueError(f"its header announces {count:,} points, too many for its size")
        read = reader.read_points(min(count, MOST_POINTS + 1))
        return np.stack([np.asarray(read.x), np.asarray(read.y), np.asarray(read.z)], axis=1).astype(np.float64)


def _checked(points: Floats, path: Path, unit: float) -> Floats:
    """The points in metres."""
    if len(points) > MOST_POINTS:
        raise FacadeError(f"{path.name}: expected at most {MOST_POINTS:,} points, found {len(points):,}.")
    if points.ndim != 2 or points.shape[1] != 3 or not (np.abs(points) <= FARTHEST).all():
        raise FacadeError(f"{path.name}: expected points of three finite coordinates within {FARTHEST:g}.")
    step = unit * float(np.spacing(np.float32(np.abs(points).max(initial=0.0))))
    if step > _MAX_ROUNDING_M and (points == points.astype(np.float32)).all():
        raise FacadeError(
            f"{path.name}: its coordinates are only exact to {step:.2g} m (32 bits, far from the origin). "
            "Write them with 64 bits, or move the scan to the origin before it is written."
        )
    return points * unit


def _mesh(path: Path, unit: float) -> tuple[Floats, int]:
    """[P, 3] points of a scan, or on the faces of a mesh; and the number of points at the end that are on its edges."""
    try:
        content = read_bounded(path, _MOST_SCAN_BYTES if path.suffix.lower() == ".ply" else _MOST_BYTES)
        parts = read_parts(content, path.suffix.lower(), without_neighbours, MOST_POINTS // 3)
    except AssetError as error:
        raise FacadeError(f"{path.name} cannot be read: {error}") from error
    points, faces = joined(parts)
    vertices = _checked(points, path, unit)
    if not len(faces):
        return vertices, 0
    loaded = trimesh.Trimesh(vertices, faces, process=False)
    loaded.merge_vertices()
    count = int(np.clip(loaded.area / _SPACING_M**2, 1_000, _MAX_SAMPLES))
    surface = np.asarray(trimesh.sample.sample_surface(loaded, count, seed=0)[0])
    sharp = loaded.face_adjacency_edges[loaded.face_adjacency_angles > _MIN_EDGE_ANGLE]
    border = loaded.edges_sorted[trimesh.grouping.group_rows(loaded.edges_sorted, require_count=1)]
    edges = _along(np.asarray(loaded.vertices)[np.vstack([sharp, border])])
    return np.vstack([surface, edges]), len(edges)


def _along(segments: Floats) -> Floats:
    """Points every two centimetres along segments [S, 2, 3]."""
    length = np.linalg.norm(segments[:, 1] - segments[:, 0], axis=1)
    spacing = max(_SPACING_M, float(length.sum()) / _MAX_SAMPLES)
    counts = np.maximum(np.ceil(length / spacing).astype(np.int64), 1)
    segment = row_of_value(counts)
    part = (index_in_row(counts) + 0.5) / counts[segment]
    return segments[segment, 0] + part[:, None] * (segments[segment, 1] - segments[segment, 0])


def _up_axes(points: Floats, num_edges: int, suffix: str) -> tuple[str, ...]:
    """The axes that may be up, the likely one first.

    Args:
        points: [P, 3] points of the file, metres.
        num_edges: number of points at the end that are on edges of a mesh.
        suffix: suffix of the file. LAS and LAZ define that z is up, and glTF that y is; others define nothing.
    """
    if suffix in (".glb", ".gltf"):
        return "y", "z"
    if suffix in SCANS:
        return "z", "y"
    planes = {axis: _planes(points[:, columns]) for axis, columns in UP_AXES.items()}
    y, z = (_num_on_wall(planes[axis]) for axis in "yz")
    if min(y, z) <= _MIN_WALL_RATIO * max(y, z):
        return ("y", "z") if y > z else ("z", "y")
    other, usual = (_reading(planes[axis], points[:, UP_AXES[axis][2]], num_edges) for axis in "yz")
    return ("y", "z") if _is_likelier(other, usual) else ("z", "y")


def _planes(points: Floats) -> list[Floats]:
    """The first facades if the third coordinate is up; none without a vertical plane."""
    try:
        return list(islice(facades(points), _MAX_PLANES))
    except FacadeError:
        return []


def _num_on_wall(planes: list[Floats]) -> int:
    return int((np.abs(planes[0][:, 2]) < _MAX_DISTANCE_M).sum()) if planes else 0


def _reading(planes: list[Floats], height: Floats, num_edges: int) -> _Reading:
    """Evidence of facades and of the heights [P] of all points that an axis is up."""
    num_repeated, sizes = 0, [np.zeros((0, 2))]
    for plane in planes:
        detection = find_boxes(_plane_of(plane, num_edges))
        num_repeated += int(repeated(detection.box, max(_TOLERANCE_M, detection.spacing)).sum())
        sizes.append(detection.box[:, 2:] - detection.box[:, :2])
    across, up = np.vstack(sizes).T
    return _Reading(num_repeated, 2 * int((up > across).sum()) > len(up), _ground(height))


@dataclass(frozen=True, slots=True)
class _Reading:
    """Evidence in the facades of a scan that an axis is up."""

    num_repeated: int
    """Number of elements that repeat."""
    is_upright: bool
    """Whether most elements are higher than wide."""
    ground: float
    """Share of all points on one level at the bottom."""


def _plane_of(points: Floats, num_edges: int) -> FacadePlane:
    """A facade with its points and the points on edges apart."""
    return FacadePlane(points[: len(points) - num_edges], points[len(points) - num_edges :])


def _ground(height: Floats) -> float:
    """Share of the points on one level at the bottom."""
    low, high = np.quantile(height, [0.001, 0.999])
    near = height[(height > low - _LEVEL_M) & (height < low + _GROUND_SHARE * (high - low))]
    counts = np.unique(np.floor((near - low) / _LEVEL_M), return_counts=True)[1]
    return float(counts.max(initial=0)) / len(height)


def _is_likelier(other: _Reading, usual: _Reading) -> bool:
    """Whether the other axis is up rather than the usual one."""
    if (
        other.num_repeated > _MIN_COUNT_RATIO * usual.num_repeated
        or usual.num_repeated > _MIN_COUNT_RATIO * other.num_repeated
    ):
        return other.num_repeated > usual.num_repeated
    # The wall is vertical for both axes: the ground, and windows that stand.
    return other.ground > usual.ground + _MIN_GROUND_SHARE and other.is_upright and not usual.is_upright
