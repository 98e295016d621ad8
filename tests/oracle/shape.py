"""One shape of the oracle: a scope, a polygon mesh in metres along the scope's axes, and what it carries."""

from __future__ import annotations

import itertools
from dataclasses import dataclass, field, replace

import numpy as np

from grammarlab.geometry.meshes.mesh import Meshes

Vector = np.ndarray
"""Three numbers."""
Value = float | bool | str

AXES = "xyz"
FRESH_MATERIAL: dict[str, float | str] = {
    "color.r": 1.0,
    "color.g": 1.0,
    "color.b": 1.0,
    "opacity": 1.0,
    "metallic": 0.0,
    "roughness": 0.8,
    "emissive.r": 0.0,
    "emissive.g": 0.0,
    "emissive.b": 0.0,
    "texture": "",
}
FRESH_STATE: dict[str, Value] = {
    "split.index": 0.0,
    "split.total": 0.0,
    "comp.index": 0.0,
    "comp.total": 0.0,
    "comp.sel": "",
    "trim.vertical": True,
    "trim.horizontal": False,
}


@dataclass(frozen=True)
class Mesh:
    """A polygon mesh: points, and faces as lists of point numbers, counter-clockwise seen from outside."""

    points: tuple[Vector, ...]
    faces: tuple[tuple[int, ...], ...]
    tags: tuple[int, ...] = ()
    """One number a face: what ``offset`` left for the selectors ``inside`` and ``border``."""

    def polygon(self, face: int) -> list[Vector]:
        return [self.points[i] for i in self.faces[face]]

    def polygons(self) -> list[list[Vector]]:
        return [self.polygon(face) for face in range(len(self.faces))]

    def tag(self, face: int) -> int:
        return self.tags[face] if self.tags else 0

    def moved(self, move) -> Mesh:
        """The mesh with a function applied to every point."""
        return replace(self, points=tuple(np.asarray(move(p), dtype=float) for p in self.points))

    def bounds(self) -> tuple[Vector, Vector]:
        if not self.points:
            return np.zeros(3), np.zeros(3)
        return np.min(self.points, axis=0), np.max(self.points, axis=0)

    def to_columns(self) -> Meshes:
        """The mesh as a batch of one, for the geometry library."""
        points = np.array(self.points).reshape(-1, 3)
        return Meshes.single(points, self.faces, self.tags or None)

    @staticmethod
    def from_columns(meshes: Meshes) -> Mesh:
        """The only mesh of a batch of one."""
        assert len(meshes) == 1
        corners = [
            tuple(meshes.corners[a:b].tolist())
            for a, b in zip(meshes.face_offsets[:-1], meshes.face_offsets[1:], strict=True)
        ]
        return Mesh(tuple(meshes.points.copy()), tuple(corners), tuple(meshes.tags.tolist()))


@dataclass(frozen=True)
class Edge:
    """An edge of a lot in its plan, with x and z in metres; outside is on the right of who walks along it."""

    start: Vector
    end: Vector
    side: str
    """``front``, ``back``, ``left`` or ``right``."""


@dataclass(frozen=True)
class Lot:
    """A lot whose streets are known."""

    edges: tuple[Edge, ...]
    front: Vector
    """Where the front looks to, in the plan."""
    extent: float
    """Metres of its longer side."""


@dataclass(frozen=True)
class Place:
    """Where the points of a shape were before anything moved them, and the edges of the lot that it still has."""

    matrix: np.ndarray
    offset: Vector
    edges: tuple[Edge, ...]

    def was(self, point: Vector) -> Vector:
        """A point of the world in the axes of the initial shape, from its origin."""
        return self.matrix @ point + self.offset


@dataclass(frozen=True)
class Plane:
    """A trim plane: what has ``normal @ point > level`` in the world lies beyond it."""

    normal: Vector
    level: float
    is_vertical: bool


@dataclass(frozen=True)
class Shape:
    """A shape under derivation. A local point p lies in the world at ``position + rotation @ p``."""

    position: Vector
    rotation: np.ndarray
    """3x3; columns are the scope's axes in the world."""
    size: Vector
    mesh: Mesh
    pivot: np.ndarray
    """3x3; columns are the axes in the world that the angles of ``r`` are about."""
    pivot_position: Vector
    """Where the pivot stands in the world."""
    material: dict[str, float | str] = field(default_factory=lambda: dict(FRESH_MATERIAL))
    state: dict[str, Value] = field(default_factory=lambda: dict(FRESH_STATE))
    """``split.index`` and its like."""
    attributes: dict[str, Value] = field(default_factory=dict)
    """Attributes that ``set`` changed above this shape."""
    key: np.ndarray = field(default_factory=lambda: np.zeros(1, np.uint64))
    """The random key, a column of length 1."""
    node: int = 0
    """The node whose rule is being carried out."""
    lot: Lot | None = None
    """None where nothing is known of streets."""
    planes: tuple[Plane, ...] = ()
    """Trim planes of the face that the shape is or comes from."""
    place: Place | None = None
    """None where nothing is known of streets, and for geometry that is not of the lot."""

    def to_world(self, point: Vector) -> Vector:
        return self.position + self.rotation @ point

    def world_polygons(self) -> list[np.ndarray]:
        return [np.array([self.to_world(p) for p in polygon]) for polygon in self.mesh.polygons()]

    def shifted(self, offset: Vector) -> Shape:
        """Moved along its own axes, the geometry with it."""
        return replace(self, position=self.to_world(offset))

    def fitted(self) -> Shape:
        """The same geometry in the scope that just holds it, axes unchanged."""
        low, high = self.mesh.bounds()
        return replace(self.shifted(low), size=high - low, mesh=self.mesh.moved(lambda p: p - low))


def newell(polygon: list[Vector]) -> Vector:
    """The vector area of a polygon: direction of the normal, length of the area."""
    first = polygon[0]
    total = np.zeros(3)
    for a, b in itertools.pairwise(polygon):
        total = total + np.cross(a - first, b - first)
    return 0.5 * total


def area(polygon: list[Vector]) -> float:
    return float(np.linalg.norm(newell(polygon)))


def normal(polygon: list[Vector]) -> Vector:
    """The unit normal; zero for a polygon without area."""
    vector = newell(polygon)
    length = np.linalg.norm(vector)
    return vector / length if length > 1e-12 else np.zeros(3)


def rectangle(width: float, depth: float) -> Mesh:
    """A lot at y = 0 seen from above; the first edge runs along +x at the front, z = depth."""
    corners = [(0.0, 0.0, depth), (width, 0.0, depth), (width, 0.0, 0.0), (0.0, 0.0, 0.0)]
    return Mesh(tuple(np.array(c) for c in corners), ((0, 1, 2, 3),))


def initial_shape(footprint: tuple[float, float] | np.ndarray, key: np.ndarray) -> Shape:
    """The shape that a derivation starts from.

    A polygon gives the x axis by its first edge, y is up, z points out over the first edge.
    """
    if isinstance(footprint, tuple):
        width, depth = footprint
        size = np.array([width, 0.0, depth])
        return Shape(np.zeros(3), np.eye(3), size, rectangle(width, depth), np.eye(3), np.zeros(3), key=key)
    x = footprint[1] - footprint[0]
    x = x / np.linalg.norm(x)
    up = np.array([0.0, 1.0, 0.0])
    rotation = np.column_stack([x, up, np.cross(x, up)])
    visited = [tuple(p) for p in footprint.tolist()]
    points = list(dict.fromkeys(visited))  # both ends of a bridge to a hole are passed twice
    local = Mesh(tuple(np.array(p) @ rotation for p in points), (tuple(points.index(p) for p in visited),))
    fitted = Shape(np.zeros(3), rotation, np.zeros(3), local, rotation, np.zeros(3), key=key).fitted()
    return replace(fitted, pivot_position=fitted.position)


def outline_then_holes(face: tuple[int, ...]) -> list[tuple[int, int]]:
    """The edges of a face without the bridges to its holes, those of its outline first."""
    passed = list(zip(face, face[1:] + face[:1], strict=True))
    rest = [(a, b) for a, b in passed if (b, a) not in passed]
    edges: list[tuple[int, int]] = []
    while rest:
        first = rest.pop(0)
        edges.append(first)
        while edges[-1][1] != first[0]:
            following = next(edge for edge in rest if edge[0] == edges[-1][1])
            rest.remove(following)
            edges.append(following)
    return edges
