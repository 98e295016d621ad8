"""Scans and meshes of facades: PLY, LAS and LAZ, OBJ, STL, GLB, OFF."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO

import numpy as np
import trimesh

from grammarlab.assets.parts import joined
from grammarlab.assets.reading import read_parts, without_neighbours
from grammarlab.errors import AssetError, FacadeError
from grammarlab.extras import require
from grammarlab.facade.templates.elements import FARTHEST, MOST_POINTS, Floats
from grammarlab.facade.templates.reading.boxes import FacadePlane
from grammarlab.facade.templates.reading.plane import facades
from grammarlab.facade.templates.reading.up import plane_of, up_axes
from grammarlab.facade.units import UP_AXES
from grammarlab.facade.values import read_bounded
from grammarlab.files import open_regular

MESHES = (".ply", ".obj", ".stl", ".glb", ".off")
SCANS = (".las", ".laz")
_EDGE = np.radians(20.0)
_SPACING = 0.02
"""Distance of sample points on meshes and their edges, metres."""
_MOST_SAMPLES = 2_000_000
_MOST_BYTES = 256 * 2**20
"""Largest size of a mesh."""
_MOST_SCAN_BYTES = 1 << 31
"""Largest size of a scan, and of a PLY file, which may be one."""
_BYTES_PER_POINT = 0.01
"""Least size of a point in a file: LAZ stores a million equal points in 12 kB."""
_COARSEST = 0.02
"""Largest rounding step of coordinates, metres."""


def read_surfaces(path: Path, unit: float = 1.0, up: str = "") -> Iterator[tuple[str, FacadePlane]]:
    """The facades of a scan, or of a sampled mesh, the one with the most points first; each with its up axis.

    Args:
        path: the file.
        unit: length of a unit of its coordinates, metres.
        up: a key of `UP_AXES`; if empty, the likely one as `up_axes`, then the other one.

    Raises:
        FacadeError: If a file cannot be read, has too many points, or numbers that are not finite.
    """
    suffix = path.suffix.lower()
    points, num_edges = (_las(path, unit), 0) if suffix in SCANS else _mesh(path, unit)
    complaints = []
    axes = (up,) if up else up_axes(points, num_edges, suffix)
    for axis in axes:
        try:
            for found in facades(points[:, UP_AXES[axis]]):
                yield axis, plane_of(found, num_edges)
        except FacadeError as error:
            complaints.append(error)
    if len(complaints) == len(axes):
        raise FacadeError(f"{path.name}: {complaints[0]}") from complaints[0]


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
    count = int(np.clip(loaded.area / _SPACING**2, 1_000, _MOST_SAMPLES))
    surface = np.asarray(trimesh.sample.sample_surface(loaded, count, seed=0)[0])
    sharp = loaded.face_adjacency_edges[loaded.face_adjacency_angles > _EDGE]
    border = loaded.edges_sorted[trimesh.grouping.group_rows(loaded.edges_sorted, require_count=1)]
    edges = _along(np.asarray(loaded.vertices)[np.vstack([sharp, border])])
    return np.vstack([surface, edges]), len(edges)


def _along(segments: Floats) -> Floats:
    """Points every two centimetres along segments [S, 2, 3]."""
    length = np.linalg.norm(segments[:, 1] - segments[:, 0], axis=1)
    spacing = max(_SPACING, float(length.sum()) / _MOST_SAMPLES)
    counts = np.maximum(np.ceil(length / spacing).astype(np.int64), 1)
    own = np.repeat(np.arange(len(segments)), counts)
    part = (np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts) + 0.5) / counts[own]
    return segments[own, 0] + part[:, None] * (segments[own, 1] - segments[own, 0])


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
    if step > _COARSEST and (points == points.astype(np.float32)).all():
        raise FacadeError(
            f"{path.name}: its coordinates are only exact to {step:.2g} m (32 bits, far from the origin). "
            "Write them with 64 bits, or move the scan to the origin before it is written."
        )
    return points * unit
