"""``comp``: the faces, edges and vertices of one shape as shapes of their own, and what its selectors pick."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from grammarlab.geometry.meshes.mesh import BORDER, INSIDE
from tests.oracle.shape import Mesh, Shape, Vector, normal, outline_then_holes
from tests.oracle.streets import face_side, segment_side

TIE = 1e-6
NOWHERE = np.zeros(3)


@dataclass(frozen=True)
class Component:
    """One face, edge or vertex."""

    shape: Shape
    direction: Vector
    """Its normal, for edges and vertices the mean normal of the faces around; in the axes of the whole shape."""
    is_border: bool
    kind: str


def components(shape: Shape, kind: str) -> list[Component]:
    """All components of a kind: ``f`` faces, ``e`` edges, ``v`` vertices."""
    if kind == "f":
        return [face_component(shape, face) for face in range(len(shape.mesh.faces))]
    if kind == "fe":
        return face_edge_components(shape)
    return edge_components(shape) if kind == "e" else vertex_components(shape)


def face_component(shape: Shape, face: int) -> Component:
    tag = shape.mesh.tag(face)
    at_border = any(len(faces) == 1 for edge, faces in _faces_by_edge(shape.mesh).items() if face in faces)
    is_border = at_border if tag not in (INSIDE, BORDER) else tag == BORDER
    return Component(joined_faces(shape, [face]), normal(shape.mesh.polygon(face)), is_border, "f")


def joined_faces(shape: Shape, faces: Sequence[int]) -> Shape:
    """Some faces as one shape, in the frame of the first: x along its first edge, z its normal."""
    outline = shape.mesh.polygon(faces[0])
    frame = frame_from_z(normal(outline), outline[1] - outline[0])
    kept = sorted({i for face in faces for i in shape.mesh.faces[face]})
    mesh = Mesh(
        tuple(shape.mesh.points[i] for i in kept),
        tuple(tuple(kept.index(i) for i in shape.mesh.faces[face]) for face in faces),
        tuple(shape.mesh.tag(face) for face in faces),
    )
    return in_frame(shape, mesh, outline[0], frame)


def edge_components(shape: Shape) -> list[Component]:
    """Every edge once, against the direction of its first face; an eave has its slope for a face, not the ceiling."""
    mesh = shape.mesh
    result = []
    for (start, end), faces in _faces_by_edge(mesh).items():
        normals = [normal(mesh.polygon(face)) for face in faces[:2]]
        mean = unit(sum(normals, NOWHERE))
        if not mean.any():
            mean = normals[0]
        first, last = mesh.points[end], mesh.points[start]
        if _is_eave(mesh, first, last, normals):
            mean = max(normals, key=lambda n: n[1])
            first, last = (first, last) if mean is normals[0] else (last, first)
        edge = segment(shape, first, last, mean)
        result.append(Component(edge, mean, len(faces) == 1, "e"))
    return result


def _is_eave(mesh: Mesh, start: Vector, end: Vector, normals: list[Vector]) -> bool:
    """Whether an edge is level, at the bottom, and below a slope that is not closed there or closed by a ceiling."""
    low, high = mesh.bounds()
    at_bottom = max(start[1], end[1]) <= low[1] + 1e-6 * max(high - low)
    is_level = abs(end[1] - start[1]) <= 1e-6 * np.linalg.norm(end - start)
    heights = [n[1] for n in normals]
    is_open = len(normals) == 1 or min(heights) < -1e-6
    return bool(at_bottom and is_level and is_open and max(heights) > 1e-6)


def face_edge_components(shape: Shape) -> list[Component]:
    """Every edge of every face, those of its holes last: x along it, z out of the face in its plane."""
    faces_by_edge = _faces_by_edge(shape.mesh)
    result = []
    for face in shape.mesh.faces:
        up = normal([shape.mesh.points[i] for i in face])
        for a, b in outline_then_holes(face):
            at = faces_by_edge.get((a, b), faces_by_edge.get((b, a)))
            if at is not None:
                start, end = shape.mesh.points[a], shape.mesh.points[b]
                out = unit(np.cross(end - start, up))
                result.append(Component(segment(shape, start, end, out), out, len(at) == 1, "fe"))
    return result


def segment(shape: Shape, start: Vector, end: Vector, z: Vector) -> Shape:
    """An edge of a shape as a shape: x along it, z as near as possible to a direction."""
    along = end - start
    x = unit(along)
    across = unit(z - x * np.dot(z, x))
    frame = np.column_stack([x, np.cross(across, x), across])
    line = Mesh((NOWHERE, np.array([np.linalg.norm(along), 0.0, 0.0])), ((0, 1),))
    return replace(
        shape,
        position=shape.to_world(start),
        rotation=shape.rotation @ frame,
        pivot=shape.rotation @ frame,
        pivot_position=shape.to_world(start),
        size=line.points[1],
        mesh=line,
    )


def vertex_components(shape: Shape) -> list[Component]:
    """Every point that a face uses, in the order of the points."""
    mesh = shape.mesh
    border = {i for edge, faces in _faces_by_edge(mesh).items() if len(faces) == 1 for i in edge}
    result = []
    for i in sorted({i for face in mesh.faces for i in face}):
        mean = unit(sum((normal(mesh.polygon(f)) for f, face in enumerate(mesh.faces) if i in face), NOWHERE))
        point = Mesh((NOWHERE,), ((0,),))
        vertex = replace(
            shape,
            position=shape.to_world(mesh.points[i]),
            rotation=shape.rotation @ frame_from_z(mean, np.cross(mean, [1.0, 0.0, 0.0])),
            pivot=shape.rotation @ frame_from_z(mean, np.cross(mean, [1.0, 0.0, 0.0])),
            pivot_position=shape.to_world(mesh.points[i]),
            size=NOWHERE,
            mesh=point,
        )
        result.append(Component(vertex, mean, i in border, "v"))
    return result


def in_frame(shape: Shape, mesh: Mesh, origin: Vector, frame: np.ndarray) -> Shape:
    """A mesh that lies in a shape's scope as a shape with other axes, its scope fitted around it."""
    moved = replace(
        shape,
        position=shape.to_world(origin),
        rotation=shape.rotation @ frame,
        pivot=shape.rotation @ frame,
        pivot_position=shape.to_world(origin),
        mesh=mesh.moved(lambda p: without_dust(frame.T @ (p - origin), mesh)),
    )
    return moved.fitted()


def without_dust(point: Vector, mesh: Mesh) -> Vector:
    """A point with coordinates that only rounding made different from zero set to zero."""
    low, high = mesh.bounds()
    dust = 1e-9 * float(np.linalg.norm(high - low))
    return np.where(np.abs(point) <= dust, 0.0, point)


def frame_from_z(z: Vector, x: Vector) -> np.ndarray:
    """The frame with this z axis, whose x axis is as near as possible to the given direction."""
    across = unit(x - z * np.dot(x, z))
    if not across.any():
        across = unit(np.cross(z, np.eye(3)[int(np.argmin(np.abs(z)))]))
    return np.column_stack([across, np.cross(z, across), z])


def unit(vector: Vector) -> Vector:
    length = np.linalg.norm(vector)
    return vector / length if length > 1e-12 else NOWHERE


def _faces_by_edge(mesh: Mesh) -> dict[tuple[int, int], list[int]]:
    """The faces at each edge, edges in the order and direction in which a walk around the faces meets them."""
    result: dict[tuple[int, int], list[int]] = {}
    for f, face in enumerate(mesh.faces):
        for a, b in zip(face, face[1:] + face[:1], strict=True):
            edge = (b, a) if (b, a) in result else (a, b)
            result.setdefault(edge, []).append(f)
    # A face that passes an edge in both directions has a bridge to a hole there.
    return {edge: faces for edge, faces in result.items() if len(set(faces)) == len(faces)}


def nearest_axis(direction: Vector) -> int:
    """Up and down win over front and back in a tie, these over the rest."""
    x, y, z = (abs(c) for c in direction)
    if y >= max(x, z) - TIE:
        return 1
    return 2 if z >= x - TIE else 0


def _quadrant(axis: int, sign: int) -> Callable[[Vector], bool]:
    return lambda d: bool(d.any()) and d[axis] * sign >= np.abs(d).max() - TIE


def _elevation(above: float, up_to: float) -> Callable[[Vector], bool]:
    """Normals whose angle over the ground lies in a range of degrees."""
    low, high = math.sin(math.radians(above)), math.sin(math.radians(up_to))
    return lambda d: bool(d.any()) and low < d[1] <= high


QUADRANTS = {
    "top": _quadrant(1, 1),
    "bottom": _quadrant(1, -1),
    "front": _quadrant(2, 1),
    "back": _quadrant(2, -1),
    "right": _quadrant(0, 1),
    "left": _quadrant(0, -1),
    "side": lambda d: bool(d.any()) and max(abs(d[0]), abs(d[2])) >= np.abs(d).max() - TIE,
}
WORLD = {"up": "top", "down": "bottom", "south": "front", "north": "back", "east": "right", "west": "left"}
SLOPES = {
    "vertical": _elevation(-11.25, 11.25),
    "aslant": _elevation(11.25, 78.75),
    "nutant": _elevation(-78.75, -11.25),
    "horizontal": lambda d: bool(d.any()) and abs(d[1]) > math.sin(math.radians(78.75)),
    "side": lambda d: bool(d.any()) and abs(d[1]) <= math.sin(math.radians(78.75)),
}
SELECTORS = {
    *QUADRANTS,
    *SLOPES,
    "all",
    "border",
    "inside",
    *(f"object.{word}" for word in QUADRANTS),
    *(f"street.{word}" for word in ("front", "back", "left", "right", "side")),
    *(f"world.{word}" for word in (*WORLD, "side")),
}
"""Words that ``picks`` knows."""


def picks(selector: str, component: Component, shape: Shape, root: Shape) -> bool:
    """Whether a keyword picks a component of a shape; ``root`` gives the axes of ``object.`` selectors."""
    family, _, word = selector.rpartition(".")
    if selector == "all":
        return True
    if selector in ("border", "inside"):
        return component.is_border == (selector == "border")
    if family == "world":
        return QUADRANTS[WORLD.get(word, word)](shape.rotation @ component.direction)
    if family == "street" and shape.lot is not None:
        side = street_side(component, shape, root)
        return side in ("left", "right") if word == "side" else side == word
    if family in ("object", "street"):
        return QUADRANTS[word](root.rotation.T @ shape.rotation @ component.direction)
    return (SLOPES if selector in SLOPES else QUADRANTS)[selector](component.direction)


def street_side(component: Component, shape: Shape, root: Shape) -> str:
    """The side of the lot that a component is on; empty for what looks up or down."""
    own = component.shape
    if component.kind == "f":
        return face_side(own, root, own.mesh.polygon(0))
    out = component.direction
    start, end = own.position, own.to_world(own.size * [1.0, 0.0, 0.0])
    if component.kind == "e" and component.is_border and nearest_axis(root.rotation.T @ shape.rotation @ out) == 1:
        out = np.cross(out, shape.rotation.T @ (end - start))
    return segment_side(shape, root, start, end, shape.rotation @ unit(out))
