"""Building envelopes: prisms whose sides slope inwards above a height of their own."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from manifold3d import Manifold

from grammarlab.arrays import Floats
from grammarlab.geometry.meshes.booleans import faces_of
from grammarlab.geometry.meshes.contact import solid_of
from grammarlab.geometry.meshes.extrude import extrude
from grammarlab.geometry.meshes.measure import face_normals, has_concave_face
from grammarlab.geometry.meshes.mesh import Meshes
from grammarlab.geometry.meshes.vectors import cross, unit

_VERTICAL = 90.0 - 1e-6
"""Degrees from which a side is a wall up to the top."""
_SIDEWAYS = 1e-6
"""Height of a unit normal up to which a face is a wall: a tolerance."""
_MARGIN = 1e-3
"""Metres by which cutting bodies reach beyond what they cut."""


def envelope(face: Meshes, along: Floats, height: float, bases: Floats, angles: Floats) -> Meshes | None:
    """The envelope over one face; None if it has no volume.

    Every side is a wall up to its base height. Above it, a plane through the upper end of the wall rises inwards
    under its angle. The planes of a convex face go on to all sides; on a concave face, each cuts what lies in front of
    its edge, so that planes end at reflex corners at right angles to their edge.

    Args:
        face: one mesh of one face, metres.
        along: [3] unit vector that rises from it.
        height: of the whole, metres, above 0.
        bases: [C] heights of the walls over the edges that leave corners, metres.
        angles: [C] degrees from the ground; 90 for a wall up to the top.
    """
    prism = solid_of(extrude(face, np.array([height]), along[None]))
    if prism is None:
        return None
    corners = face.points[face.corner_points()]
    is_concave = bool(has_concave_face(face)[0])
    ends = np.roll(corners, -1, axis=0)
    middle = corners.mean(axis=0)
    normal = np.cross(corners - middle, ends - middle).sum(axis=0)
    normal /= np.linalg.norm(normal)
    turns = np.einsum("ci,i->c", np.cross(corners - np.roll(corners, 1, axis=0), ends - corners), normal)
    for index, (start, end) in enumerate(zip(corners, ends, strict=True)):
        base, angle, length = float(max(bases[index], 0.0)), float(angles[index]), np.linalg.norm(end - start)
        if not 0.0 < angle < _VERTICAL or base >= height or length == 0.0:
            continue
        direction = (end - start) / length
        inward: Floats = unit(cross(along[None], direction[None]))[0]
        slope = np.tan(np.radians(angle))
        if not is_concave:
            plane = slope * inward - along
            size = float(np.linalg.norm(plane))
            offset = float(plane @ (start + base * along)) / size
            prism = prism.trim_by_plane(tuple(plane / size), offset)
            continue
        depth = (height - base) / slope
        before = depth if turns[index] > 0.0 else 0.0
        after = depth if turns[(index + 1) % len(corners)] > 0.0 else 0.0
        prism = prism - _wedge(
            (start - before * direction, end + after * direction), inward, along, (base, height, depth)
        )
    return None if prism.is_empty() else _in_order(faces_of(prism).mesh, corners, along)


def _in_order(mesh: Meshes, corners: Floats, along: Floats) -> Meshes:
    """One mesh with its faces as the runtime has them: the ground, the wall and the slope of each edge, the top.

    The ground begins with the first edge reversed, walls and slopes with their lower edges, the top over the first
    corner.

    Args:
        mesh: the envelope over a face.
        corners: [C, 3] the corners of the face.
        along: [3] unit vector that rises from it.
    """
    direction = unit(np.roll(corners, -1, axis=0) - corners)
    outward = unit(cross(direction, np.broadcast_to(along, direction.shape)))
    normals = face_normals(mesh)
    ranks: list[tuple[int, int, float]] = []
    faces: list[list[int]] = []
    for number, (begin, end) in enumerate(pairwise(mesh.face_offsets.tolist())):
        ring = mesh.corners[begin:end].tolist()
        points, rise = mesh.points[ring], float(normals[number] @ along)
        height = points @ along
        if rise < -_SIDEWAYS:
            ranks.append((-1, 0, 0.0))
            start = int(np.linalg.norm(points - corners[1], axis=1).argmin())
        elif rise > 1.0 - _SIDEWAYS:
            ranks.append((len(corners), 0, 0.0))
            start = int(np.linalg.norm(points - corners[0], axis=1).argmin())
        else:
            low = height <= height.min() + _MARGIN
            gaps = np.abs(np.einsum("ci,ci->c", outward, points[low].mean(axis=0) - corners))
            facing = outward @ normals[number] > (1.0 - _SIDEWAYS) * np.sqrt(max(1.0 - rise * rise, 0.0))
            edge = int(np.where(facing, gaps, np.inf).argmin())
            ranks.append((edge, int(rise > _SIDEWAYS), float(height.min())))
            start = int(np.where(low, points @ direction[edge], np.inf).argmin())
        faces.append(ring[start:] + ring[:start])
    order = sorted(range(len(faces)), key=ranks.__getitem__)
    return Meshes.single(mesh.points, [faces[index] for index in order])


def _wedge(edge: tuple[Floats, Floats], inward: Floats, along: Floats, size: tuple[float, float, float]) -> Manifold:
    """What lies above a sloping plane over an edge.

    Args:
        edge: ends of the edge.
        inward: direction into the face.
        along: direction upwards.
        size: height of the lower end of the plane, of its upper end, and the depth of the upper end.
    """
    base, height, depth = size
    outside = _MARGIN * inward
    points = []
    for corner in edge:
        low, high = corner + base * along, corner + height * along + depth * inward
        top = _MARGIN * along
        points += [low, low - outside, corner + height * along - outside + top, high, high + top]
    return Manifold.hull_points(np.array(points))
