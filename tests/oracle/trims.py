"""Trim planes: where faces met before they were taken apart, and what is inserted on them ends."""

from __future__ import annotations

import math

import numpy as np

from tests.oracle.shape import Mesh, Plane, Shape, Vector, normal, replace

SLACK = 1e-9


def planes_of(whole: Shape, face: int, part: Shape) -> tuple[Plane, ...]:
    """The planes through the edges that a face of a shape shares with others, halfway between the two."""
    mesh = whole.mesh
    planes = []
    for a, b in _edges(mesh.faces[face]):
        others = [i for i, other in enumerate(mesh.faces) if i != face and (b, a) in _edges(other)]
        others += [i for i, other in enumerate(mesh.faces) if i != face and (a, b) in _edges(other)]
        if not others:
            continue
        along = mesh.points[b] - mesh.points[a]
        along = along / np.linalg.norm(along)
        own = normal(mesh.polygon(face))
        across = np.cross(along, own + normal(mesh.polygon(others[0])))
        if np.linalg.norm(across) < 1e-9:
            continue
        across = across / np.linalg.norm(across) * np.sign(np.dot(across, np.cross(along, own)) or 1.0)
        level = np.dot(across, mesh.points[a])
        if any(np.dot(across, p) - level > 1e-7 * (1.0 + np.abs(p).max()) for p in mesh.polygon(face)):
            continue
        world = whole.rotation @ across
        rises = abs(np.dot(whole.rotation @ along, part.rotation[:, 1]))
        is_vertical = rises >= math.sin(math.radians(40.0))
        planes.append(Plane(world, float(level + np.dot(world, whole.position)), bool(is_vertical)))
    return tuple(planes)


def _edges(face: tuple[int, ...]) -> list[tuple[int, int]]:
    return list(zip(face, face[1:] + face[:1], strict=True))


def trimmed(shape: Shape) -> Shape:
    """The shape without what lies beyond its planes; cuts stay open."""
    result = shape
    for plane in shape.planes:
        switch = "trim.vertical" if plane.is_vertical else "trim.horizontal"
        if result.state[switch]:
            result = _cut(result, plane)
    return result


def _cut(shape: Shape, plane: Plane) -> Shape:
    axis = shape.rotation.T @ plane.normal
    level = plane.level - np.dot(plane.normal, shape.position)
    beyond = [np.dot(axis, p) - level for p in shape.mesh.points]
    slack = SLACK * max(1.0, abs(level), max((float(np.abs(p).max()) for p in shape.mesh.points), default=0.0))
    if not beyond or max(beyond) <= slack:
        return shape
    points: list[Vector] = list(shape.mesh.points)
    crossings: dict[tuple[int, int], int] = {}
    faces = []
    for face in shape.mesh.faces:
        if max(beyond[i] for i in face) <= slack:
            faces.append(face)
        elif min(beyond[i] for i in face) < -slack:
            faces.append(_inside(face, points, beyond, slack, crossings))
    kept = sorted({i for face in faces for i in face})
    number = {i: k for k, i in enumerate(kept)}
    mesh = Mesh(tuple(points[i] for i in kept), tuple(tuple(number[i] for i in face) for face in faces))
    return replace(shape, mesh=mesh).fitted()


def _inside(
    face: tuple[int, ...], points: list[Vector], beyond: list[float], slack: float, crossings: dict
) -> tuple[int, ...]:
    """The corners on the kept side, and points where edges pass the plane; for convex faces."""
    corners: list[int] = []
    first = 0
    for place, (a, b) in enumerate(_edges(face)):
        if beyond[a] <= slack:
            corners.append(a)
        if (beyond[a] <= slack) != (beyond[b] <= slack) and min(abs(beyond[a]), abs(beyond[b])) > slack:
            key = (min(a, b), max(a, b))
            if key not in crossings:
                crossings[key] = len(points)
                share = beyond[key[0]] / (beyond[key[0]] - beyond[key[1]])
                points.append(points[key[0]] + share * (points[key[1]] - points[key[0]]))
            corners.append(crossings[key])
        if place == 0:
            first = len(corners)
    # A piece begins with the rest of the first edge of its face, or else with the edge along the plane.
    return tuple(corners) if first else (corners[-1], *corners[:-1])
