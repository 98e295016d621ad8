"""Which side of its lot a face or an edge is on: the front along streets, then back, left and right.

A shape knows where its points were before anything moved them (`Place`), and which edges of the lot it still has.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from tests.oracle.shape import Edge, Lot, Place, Shape, Vector, normal

TIE = 1e-6
QUARTER = math.cos(math.pi / 4)


def plan(point: Vector) -> Vector:
    """x and z."""
    return np.array([point[0], point[2]])


def outward(start: Vector, end: Vector) -> Vector:
    """The unit normal on the right of who walks along an edge, seen from above; zero without a length."""
    along = end - start
    length = math.hypot(*along)
    return np.array([-along[1], along[0]]) / length if length > 0.0 else np.zeros(2)


def lot_of(polygon: Sequence[Vector], widths: Sequence[float], extent: float) -> Lot:
    """The lot with this outline, in the axes of its initial shape, and the widths of the streets along its edges."""
    corners = [plan(point) for point in polygon]
    pairs = list(zip(corners, corners[1:] + corners[:1], strict=True))

    def is_passed_back(start: Vector, end: Vector) -> bool:
        return any((a == end).all() and (b == start).all() for a, b in pairs)

    edges = [
        (start, end, width)
        for (start, end), width in zip(pairs, widths, strict=True)
        if not is_passed_back(start, end) and (start != end).any()
    ]
    streets = [(start, end) for start, end, width in edges if width > 0.0]
    total = sum((outward(a, b) * math.dist(a, b) for a, b in streets), np.zeros(2))
    front = outward(*(streets or pairs)[0])
    if math.hypot(*total) > 0.1 * sum(math.dist(a, b) for a, b in streets):
        front = total / math.hypot(*total)
    sides = tuple(
        Edge(start, end, "front" if width > 0.0 else side_of(outward(start, end), front)) for start, end, width in edges
    )
    return Lot(sides, front, extent)


def side_of(direction: Vector, front: Vector) -> str:
    """Back, left or right, for someone who looks at the front."""
    if np.dot(direction, front) < -QUARTER - TIE:
        return "back"
    return "left" if direction[0] * front[1] - direction[1] * front[0] < -TIE else "right"


def begun(shape: Shape, widths: Sequence[float] | None) -> Shape:
    """The initial shape on a lot with streets of these widths along its edges, None if nothing is known of them."""
    if widths is None:
        return shape
    lot = lot_of(shape.mesh.polygon(0), widths, float(shape.size.max()))
    place = Place(shape.rotation.T, -shape.rotation.T @ shape.position, lot.edges)
    return replace(shape, lot=lot, place=place)


def carried(before: Shape, after: Shape) -> Shape:
    """A shape that an operation moved, rotated or scaled with its scope; its points were where they were."""
    if before.place is None:
        return after
    factor = [a / b if a != 0.0 and b != 0.0 else 1.0 for a, b in zip(before.size, after.size, strict=True)]
    turn = before.rotation @ np.diag(factor) @ after.rotation.T
    matrix = before.place.matrix @ turn
    offset = before.place.was(before.position) - matrix @ after.position
    return replace(after, place=Place(matrix, offset, before.place.edges))


def nearest_edge(shape: Shape, a: Vector, b: Vector, out: Vector) -> tuple[float, float, Edge] | None:
    """The edge behind a segment of the world: its distance, minus how much of it is covered, and the edge itself."""
    assert shape.place is not None
    assert shape.lot is not None
    slack = 1e-6 * shape.lot.extent
    start, end = plan(shape.place.was(a)), plan(shape.place.was(b))
    looks = plan(shape.place.matrix @ out)
    is_point = math.dist(start, end) <= slack
    if is_point:
        looks = looks / max(math.hypot(*looks), TIE)
    else:
        across = outward(start, end)
        turn = float(np.dot(across, looks))
        looks = across * math.copysign(1.0, turn) if abs(turn) > TIE else np.zeros(2)
    found: list[tuple[float, float, Edge]] = []
    for edge in shape.place.edges:
        out_of_lot, length = outward(edge.start, edge.end), math.dist(edge.start, edge.end)
        along = np.array([out_of_lot[1], -out_of_lot[0]])
        far = [float(np.dot(point - edge.start, out_of_lot)) for point in (start, end)]
        low, high = sorted(float(np.dot(point - edge.start, along)) for point in (start, end))
        covered = min(high, length) - max(low, 0.0)
        is_parallel = np.dot(looks, out_of_lot) > (1.0 - TIE if is_point else 0.0) and abs(far[0] - far[1]) <= slack
        if is_parallel and far[0] >= -slack and (covered >= -slack if is_point else covered > slack):
            distance = round((far[0] if far[0] > slack else 0.0) / slack)
            found.append((distance, 0.0 if is_point else -covered, edge))
    return min(found, key=lambda place: place[:2], default=None)


def lateral(shape: Shape, root: Shape, out: Vector) -> Vector | None:
    """Where a vector of the world looks to in the plan of the lot; None if it looks up or down."""
    x, y, z = root.rotation.T @ out
    if not out.any() or abs(y) >= max(abs(x), abs(z)) - TIE:
        return None
    return np.array([x, z]) / math.hypot(x, z)


def by_direction(shape: Shape, root: Shape, out: Vector) -> str:
    """The side of what is on no edge of the lot."""
    assert root.lot is not None
    looks = lateral(shape, root, out)
    if looks is None:
        return ""
    if shape.place is not None:
        return side_of(looks, root.lot.front)
    return alike(looks, root.lot.edges, -1.0)


def alike(looks: Vector, edges: Sequence[Edge], least: float) -> str:
    """The side of the first edge that looks most nearly in a direction."""
    cosines = [float(np.dot(outward(edge.start, edge.end), looks)) for edge in edges]
    best = max(cosines, default=-2.0)
    near = [edge for edge, cosine in zip(edges, cosines, strict=True) if cosine >= best - TIE and cosine >= least - TIE]
    return near[0].side if near else ""


def face_side(shape: Shape, root: Shape, polygon: list[Vector]) -> str:
    """The side of a face, whose corners are in the axes of a shape."""
    out = shape.rotation @ normal(polygon)
    if lateral(shape, root, out) is None:
        return ""
    corners = [shape.to_world(point) for point in polygon]
    found = []
    if shape.place is not None:
        pairs = zip(corners, corners[1:] + corners[:1], strict=True)
        found = [place for a, b in pairs if (place := nearest_edge(shape, a, b, out)) and place[1] < 0.0]
    return min(found, key=lambda place: place[:2])[2].side if found else by_direction(shape, root, out)


def segment_side(shape: Shape, root: Shape, a: Vector, b: Vector, out: Vector) -> str:
    """The side of an edge or point of the world that looks outwards."""
    place = nearest_edge(shape, a, b, out) if shape.place is not None else None
    return place[2].side if place else by_direction(shape, root, out)


def borders(polygon: list[Vector]) -> list[tuple[Vector, Vector, Vector]]:
    """The edges of a polygon, and the vectors that point out of it within its plane."""
    up = normal(polygon)
    result = []
    for a, b in zip(polygon, polygon[1:] + polygon[:1], strict=True):
        across = np.cross(b - a, up)
        length = float(np.linalg.norm(across))
        result.append((a, b, across / length if length > 0.0 else across))
    return result


def remembering(
    part: Shape, shape: Shape, root: Shape, distances: Sequence[float], everything: list[list[Vector]]
) -> Shape:
    """A part of a shape with those edges of the lot of which it has something.

    Args:
        part: the part.
        shape: the shape that it was cut off, which lies flat.
        root: the initial shape.
        distances: how far each edge of each face of the shape moved inwards.
        everything: the faces of the part in the axes of the shape.
    """
    if shape.place is None or lateral(shape, root, shape.rotation @ normal(shape.mesh.polygon(0))) is not None:
        return part
    edges = [border for polygon in shape.mesh.polygons() for border in borders(polygon)]
    old: list[Edge] = []
    for (a, b, out), distance in zip(edges, distances, strict=True):
        place = nearest_edge(shape, shape.to_world(a), shape.to_world(b), shape.rotation @ out)
        if place is not None:
            old += [_in_plan(shape, a, b, out, place[2].side)]
            old += [_in_plan(shape, a - out * distance, b - out * distance, out, place[2].side)]
    reference = replace(shape, place=replace(shape.place, edges=tuple(old)))
    new: list[Edge] = []
    for polygon in everything:
        for a, b, out in borders(polygon):
            place = nearest_edge(reference, shape.to_world(a), shape.to_world(b), shape.rotation @ out)
            if place is not None and place[0] == 0:
                new.append(_in_plan(shape, a, b, out, place[2].side))
    assert part.place is not None
    return replace(part, place=replace(part.place, edges=tuple(new)))


def _in_plan(shape: Shape, a: Vector, b: Vector, out: Vector, side: str) -> Edge:
    """An edge in the plan of the lot, in the direction that has the outer side where it should be."""
    assert shape.place is not None
    start, end = (plan(shape.place.was(shape.to_world(point))) for point in (a, b))
    looks = plan(shape.place.matrix @ shape.rotation @ out)
    return Edge(start, end, side) if np.dot(outward(start, end), looks) >= 0.0 else Edge(end, start, side)
