"""OBJ text with faces that every reader covers alike.

A reader that makes a fan of each face covers the notches of concave ones, such as a wall around its windows; and a
negative number of a corner counts back from the line of its face, not from the end of the file.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from grammarlab.errors import AssetError
from grammarlab.geometry.meshes.measure import is_convex
from grammarlab.geometry.meshes.mesh import Meshes
from grammarlab.geometry.meshes.triangulate import triangulate

MOST_WORK = 10**9
"""Bound on the sum of squared numbers of corners of concave faces, to which the time of ear clipping is proportional
at worst."""
_KINDS = (b"v", b"vt", b"vn")


@dataclass(frozen=True, slots=True)
class _Face:
    line: int
    corners: tuple[tuple[int, ...], ...]
    """Position, texture coordinate and normal of each corner, from 1; 0 for those that are left out."""

    def text(self, corners: NDArray[np.int64] | None = None) -> bytes:
        """The line of the face, or of a triangle of it."""
        chosen = self.corners if corners is None else [self.corners[corner] for corner in corners.tolist()]
        return b"f " + b" ".join(b"/".join(b"%d" % each if each else b"" for each in corner) for corner in chosen)


def plain_faces(content: bytes) -> bytes:
    r"""The text of an OBJ file with triangles instead of concave faces, and without negative numbers of corners.

    Other lines stay as they are; so do faces and points that cannot be read.

    Raises:
        AssetError: If concave faces have too many corners.

    >>> notched = b"v 0 0 0\nv 4 0 0\nv 4 4 0\nv 2 1 0\nv 0 4 0\nf -5 -4 -3 -2 -1"
    >>> plain_faces(notched).splitlines()[5:]
    [b'f 4 5 1', b'f 4 1 2', b'f 4 2 3']
    """
    lines = content.replace(b"\r\n", b"\n").replace(b"\\\n", b"").split(b"\n")
    faces = list(_unusual_faces(lines))
    if not faces:
        return content
    for face in faces:
        lines[face.line] = face.text()
    polygons = [face for face in faces if len(face.corners) > 3]
    corners = _points_of(polygons, lines)
    if corners is None:
        return b"\n".join(lines)
    for face, triangles in _concave(polygons, corners):
        lines[face.line] = b"\n".join(face.text(triangle) for triangle in triangles)
    return b"\n".join(lines)


def _unusual_faces(lines: list[bytes]) -> Iterator[_Face]:
    """Faces of more than three corners, or with a negative number."""
    so_far = dict.fromkeys(_KINDS, 0)
    for number, line in enumerate(lines):
        kind = _kind(line)
        if kind in so_far:
            so_far[kind] += 1
        elif kind == b"f":
            words = line.partition(b"#")[0].split()[1:]
            if len(words) > 3 or b"-" in line:
                try:
                    corners = tuple(_corner(word, tuple(so_far.values())) for word in words)
                except ValueError:
                    continue
                yield _Face(number, corners)


def _kind(line: bytes) -> bytes:
    return line[:3].split(maxsplit=1)[0] if line[:1] in {b"v", b"f"} else b""


def _corner(word: bytes, so_far: tuple[int, ...]) -> tuple[int, ...]:
    """Numbers of a corner from 1, such as `12/-1`.

    Raises:
        ValueError: If it has no such numbers.
    """
    numbers = [int(part) if part else 0 for part in word.split(b"/")]
    found = tuple(each + count + 1 if each < 0 else each for each, count in zip(numbers, so_far, strict=False))
    if found[0] < 1 or min(found) < 0:
        raise ValueError(word)
    return found


def _points_of(faces: list[_Face], lines: list[bytes]) -> NDArray[np.float64] | None:
    """[C, 3] points of the corners of faces; None if some cannot be read."""
    try:
        points = np.array([line.split()[1:4] for line in lines if _kind(line) == b"v"], dtype=np.float64)
        found = points[np.array([corner[0] - 1 for face in faces for corner in face.corners], dtype=np.int64)]
    except (ValueError, IndexError, OverflowError):
        return None
    return found if found.shape[1:] == (3,) and np.isfinite(found).all() else None


def _concave(faces: list[_Face], points: NDArray[np.float64]) -> Iterator[tuple[_Face, NDArray[np.int64]]]:
    """The concave ones of faces with corners at points [C, 3], each with its triangles [T, 3] of its own corners."""
    if not faces:
        return
    counts = np.array([len(face.corners) for face in faces])
    # Near the origin, since products of national coordinates leave no digits for centimetres.
    meshes = Meshes.from_polygons(points - points.mean(axis=0), counts)
    concave = np.flatnonzero(~is_convex(meshes))
    if (counts[concave] ** 2).sum() > MOST_WORK:
        raise AssetError(
            f"its concave faces have too many corners (up to {counts[concave].max():,} each); triangulate it first"
        )
    triangles, face = triangulate(meshes)
    begins, ends = (np.searchsorted(face, concave, side=side).tolist() for side in ("left", "right"))
    for which, begin, end in zip(concave.tolist(), begins, ends, strict=True):
        if end > begin:
            yield faces[which], triangles[begin:end] - meshes.face_offsets[which]
