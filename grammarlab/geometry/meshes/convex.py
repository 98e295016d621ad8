"""Concave faces divided into convex ones: CGA's ``convexify``."""

from __future__ import annotations

import numpy as np

from grammarlab.arrays import Floats, offsets_from_counts
from grammarlab.geometry.meshes.measure import area_vectors
from grammarlab.geometry.meshes.mesh import Meshes

MOST_CORNERS = 500
"""Largest number of corners of a face that is divided: a budget, since the time grows with their square or more."""
_STRAIGHT = 1e-9
"""Sine of the largest turn to the right that counts as straight: a tolerance."""
_AT_CORNER = 1e-9
"""Share of an edge up to which a cut that ends on it ends at its corner: a tolerance."""


def convexified(mesh: Meshes, longest: float = np.inf) -> Meshes:
    """A mesh in which cuts divide concave faces: from reflex corners on along one of their edges, shortest first.

    Faces of more than `MOST_CORNERS` corners stay.

    Args:
        mesh: a single mesh.
        longest: metres; faces stay concave where cuts would be longer.
    """
    division = _Division(mesh)
    for face in np.flatnonzero(np.diff(mesh.face_offsets) <= MOST_CORNERS).tolist():
        division.divide(face, longest)
    return division.result()


class _Division:
    """Faces of a mesh being divided; a face is a list of corners, a corner a point and a row of values."""

    def __init__(self, mesh: Meshes) -> None:
        self._mesh = mesh
        self._points = list(mesh.points)
        self._values = [] if mesh.data is None else list(mesh.data.values)
        spans = zip(mesh.face_offsets[:-1].tolist(), mesh.face_offsets[1:].tolist(), strict=True)
        self._faces = [[(int(mesh.corners[c]), c) for c in range(begin, end)] for begin, end in spans]
        self._source = list(range(mesh.num_faces))
        self._normals = area_vectors(mesh)

    def divide(self, face: int, longest: float) -> None:
        """Divide one face and its parts as long as one is concave."""
        pending = [face]
        while pending:
            part = pending.pop()
            cut = self._shortest_cut(part)
            if cut is None or cut[0] > longest:
                continue
            _, corner, edge, share = cut
            far = self._corner_on(part, edge, share)
            near = corner + int(_is_inside(share) and edge < corner)
            ring, (low, high) = self._faces[part], sorted((near, far))
            inner, outer = ring[low : high + 1], ring[: low + 1] + ring[high:]
            # As in the runtime, the part that leads from the end of the cut to the corner takes the place of the face.
            self._faces[part], added = (inner, outer) if far < near else (outer, inner)
            self._faces.append(added)
            self._source.append(self._source[part])
            pending += [part, len(self._faces) - 1]

    def _shortest_cut(self, face: int) -> tuple[float, int, int, float] | None:
        """Length of the shortest cut of a face, the corner and the edge where it ends, and the share along the edge."""
        ring = self._faces[face]
        if len(ring) < 4:
            return None
        flat = self._flat(face)
        following = np.roll(flat, -1, axis=0)
        arriving, leaving = flat - np.roll(flat, 1, axis=0), following - flat
        length = np.linalg.norm(arriving, axis=1) * np.linalg.norm(leaving, axis=1)
        reflex = np.flatnonzero(_cross(arriving, leaving) < -_STRAIGHT * length)
        best: tuple[float, int, int, float] | None = None
        for corner in reflex.tolist():
            for direction in (arriving[corner], -leaving[corner]):
                hit = _first_hit(flat[corner], direction, flat, following, corner)
                if hit is not None and (best is None or hit[0] < best[0] * (1.0 - 1e-9)):
                    best = hit[0], corner, hit[1], hit[2]
        return best

    def _flat(self, face: int) -> Floats:
        """[n, 2] the corners of a face in its plane, counter-clockwise."""
        normal = self._normals[self._source[face]]
        z = normal / np.linalg.norm(normal)
        x = np.cross(z, np.eye(3)[np.abs(z).argmin()])
        x /= np.linalg.norm(x)
        return np.array([self._points[point] for point, _ in self._faces[face]]) @ np.column_stack([x, np.cross(z, x)])

    def _corner_on(self, face: int, edge: int, share: float) -> int:
        """Index of a corner on an edge of a face: one of its ends, or a new one in all faces that have the edge."""
        ring = self._faces[face]
        after = (edge + 1) % len(ring)
        if not _is_inside(share):
            return edge if share <= 0.5 else after
        (start, _), (end, _) = ring[edge], ring[after]
        point = len(self._points)
        self._points.append((1.0 - share) * self._points[start] + share * self._points[end])
        for other in self._faces:
            self._insert(other, start, end, point, share)
        return edge + 1

    def _insert(self, ring: list[tuple[int, int]], start: int, end: int, point: int, share: float) -> None:
        """A new corner on every edge of a face between two points."""
        index = 0
        while index < len(ring):
            (first, a), (second, b) = ring[index], ring[(index + 1) % len(ring)]
            if (first, second) in ((start, end), (end, start)):
                along = share if first == start else 1.0 - share
                if self._values:
                    self._values.append((1.0 - along) * self._values[a] + along * self._values[b])
                ring.insert(index + 1, (point, len(self._values) - 1 if self._values else a))
                index += 1
            index += 1

    def result(self) -> Meshes:
        """The divided mesh, the parts of a face where the face was."""
        order = sorted(range(len(self._faces)), key=lambda face: self._source[face])
        corners = [corner for face in order for corner in self._faces[face]]
        source = np.array([self._source[face] for face in order], dtype=np.int64)
        rows = np.array([row for _, row in corners], dtype=np.int64)
        data = self._mesh.data
        if data is not None:
            data = type(data)(np.array(self._values).take(rows, axis=0), data.slots.take(source))
        return Meshes(
            points=np.array(self._points).reshape(-1, 3),
            corners=np.array([point for point, _ in corners], dtype=np.int64),
            face_offsets=offsets_from_counts(np.array([len(self._faces[face]) for face in order], dtype=np.int64)),
            mesh_faces=np.array([0, len(order)]),
            mesh_points=np.array([0, len(self._points)]),
            tags=self._mesh.tags.take(source),
            data=data,
        )


def _is_inside(share: float) -> bool:
    """Whether a place on an edge is none of its ends."""
    return _AT_CORNER < share < 1.0 - _AT_CORNER


def _first_hit(
    start: Floats, direction: Floats, here: Floats, there: Floats, corner: int
) -> tuple[float, int, float] | None:
    """Where a ray from a corner meets the outline first: its length, the edge and the share along it."""
    along = there - here
    slope = _cross(np.broadcast_to(direction, along.shape), along)
    away = here - start
    with np.errstate(divide="ignore", invalid="ignore"):
        distance = _cross(away, along) / slope
        share = _cross(away, np.broadcast_to(direction, along.shape)) / slope
    size = np.linalg.norm(direction)
    valid = (np.abs(slope) > _STRAIGHT * size * np.linalg.norm(along, axis=1)) & (distance > _AT_CORNER)
    valid &= (share >= -_AT_CORNER) & (share <= 1.0 + _AT_CORNER)
    valid[[corner, corner - 1]] = False
    if not valid.any():
        return None
    edge = int(np.where(valid, distance, np.inf).argmin())
    return float(distance[edge] * size), edge, float(share[edge])


def _cross(first: Floats, second: Floats) -> Floats:
    """[n] z of the cross products of vectors in a plane."""
    return first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]
