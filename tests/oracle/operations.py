"""The operations of CGA that change one shape, each as short as its definition."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from grammarlab.errors import DerivationError
from grammarlab.geometry.meshes.primitives import builtin_asset, natural_size
from grammarlab.language.syntax.syntax_tree import Binary, Expression, Floating, Name, Relative
from tests.oracle.components import unit
from tests.oracle.expressions import Scope, evaluate, number
from tests.oracle.shape import AXES, Mesh, Shape, Value, Vector, newell, normal, outline_then_holes
from tests.oracle.trims import trimmed

KEYWORDS = {
    "center": {"x", "y", "z", "xy", "xz", "yz", "xyz"},
    "r": {"scopeOrigin", "scopeCenter"},
    "translate": {"abs", "rel", "scope", "pivot", "object", "world"},
    "rotate": {"abs", "rel", "scope", "pivot", "object", "world"},
    "extrude": {"world.up", "world.up.flatTop", "face.normal", "vertex.normal", "x", "y", "z", "world.y"},
    "offset": {"all", "inside", "border"},
    "roofGable": {"byAngle", "byHeight"},
    "roofHip": {"byAngle", "byHeight"},
    "roofPyramid": {"byAngle", "byHeight"},
    "alignScopeToAxes": {"x", "y", "z", "world.x", "world.y", "world.z", "world.xyz"},
}
"""Words that are arguments as they stand."""


@dataclass(frozen=True)
class Argument:
    value: Value
    word: bool = False
    """One of the operation's own keywords."""
    relative: bool = False
    """Written ``'x``."""
    floating: bool = False
    """Written ``~x``."""

    def length(self, extent: float) -> float:
        """Metres along an axis of this extent."""
        value = number(self.value)
        if not np.isfinite(value):
            raise DerivationError(f"expected a finite number, found {value}")
        return value * extent if self.relative else value


def argument(node: Expression, scope: Scope, words: set[str] | frozenset[str] = frozenset()) -> Argument:
    """One argument of an operation, or what stands before the colon of a part of a block."""
    if isinstance(node, Name) and node.identifier in words:
        return Argument(node.identifier, word=True)
    prefixes: set[type] = set()
    value = evaluate(_without_prefixes(node, prefixes), scope)
    return Argument(value, False, Relative in prefixes, Floating in prefixes)


def _without_prefixes(node: Expression, found: set[type]) -> Expression:
    """``~`` and ``'`` stand in front of an expression and hold for all of it."""
    if isinstance(node, Floating | Relative):
        found.add(type(node))
        return _without_prefixes(node.operand, found)
    if isinstance(node, Binary):
        return replace(node, left=_without_prefixes(node.left, found))
    return node


@dataclass(frozen=True)
class Call:
    """One operation, about to be carried out."""

    name: str
    shape: Shape
    arguments: Sequence[Argument]
    began: Shape
    """The shape with which the rule, the part or the bracket around the operation began."""
    scope: Scope
    assets: Callable[[str], Mesh]
    """Loads a mesh file."""

    @property
    def words(self) -> list[str]:
        return [str(a.value) for a in self.arguments if a.word]

    @property
    def lengths(self) -> Vector:
        """The three last arguments as metres along the scope's axes."""
        return np.array([a.length(self.shape.size[i]) for i, a in enumerate(self.arguments[-3:])])


def t(call: Call) -> Shape:
    return call.shape.shifted(call.lengths)


def s(call: Call) -> Shape:
    """Sizes grow geometry with them; where the scope had no extent the geometry stays flat."""
    shape, size = call.shape, call.lengths
    if size.min() < -1e-9:
        raise DerivationError(f"negative size {size}")
    size = np.maximum(size, 0.0)
    factor = np.divide(size, shape.size, out=np.ones(3), where=shape.size > 0.0)
    return replace(shape, size=size, mesh=shape.mesh.moved(lambda p: p * factor))


def rotation_matrix(x: float, y: float, z: float) -> np.ndarray:
    """Rz Ry Rx, in degrees: about x, then about y, then about z."""
    (cx, cy, cz), (sx, sy, sz) = np.cos(np.radians([x, y, z])), np.sin(np.radians([x, y, z]))
    about_x = np.array([[1, 0, 0], [0, cx, -sx], [0, sx, cx]])
    about_y = np.array([[cy, 0, sy], [0, 1, 0], [-sy, 0, cy]])
    about_z = np.array([[cz, -sz, 0], [sz, cz, 0], [0, 0, 1]])
    return about_z @ about_y @ about_x


def r(call: Call) -> Shape:
    shape = call.shape
    turn = rotation_matrix(*(number(a.value) for a in call.arguments[-3:]))
    fixed = 0.5 * shape.size if "scopeCenter" in call.words else np.zeros(3)
    turned = replace(shape, rotation=shape.pivot @ turn @ shape.pivot.T @ shape.rotation)
    return replace(turned, position=shape.to_world(fixed) - turned.rotation @ fixed)


def center(call: Call) -> Shape:
    shape, began = call.shape, call.began
    target = began.to_world(0.5 * began.size)
    offset = shape.rotation.T @ (target - shape.to_world(0.5 * shape.size))
    return shape.shifted(np.array([offset[i] if AXES[i] in call.words[0] else 0.0 for i in range(3)]))


def axes_of(system: str, call: Call) -> tuple[Vector, np.ndarray]:
    """Origin and axes of a coordinate system that ``translate`` and ``rotate`` name."""
    root = call.scope.model.root
    if system == "world":
        return np.zeros(3), np.eye(3)
    shape = call.shape
    systems = {
        "scope": (shape.position, shape.rotation),
        "pivot": (shape.pivot_position, shape.pivot),
        "object": (root.position, root.rotation),
    }
    return systems[system]


def translate(call: Call) -> Shape:
    mode, system = call.words
    origin, axes = axes_of(system, call)
    start = origin if mode == "abs" else call.shape.position
    return replace(call.shape, position=start + axes @ call.lengths)


def rotate(call: Call) -> Shape:
    mode, system = call.words
    _, axes = axes_of(system, call)
    turn = rotation_matrix(*(number(a.value) for a in call.arguments[-3:]))
    before = np.eye(3) if mode == "abs" else axes.T @ call.shape.rotation
    return replace(call.shape, rotation=axes @ turn @ before)


def extrude(call: Call) -> Shape:
    """A solid over every face. The scope's y axis follows the first face's normal, x stays as near as it can."""
    shape, height = call.shape, number(call.arguments[-1].value)
    if not np.isfinite(height):
        raise DerivationError(f"expected a finite height, found {height}")
    if not shape.mesh.faces or height == 0.0:
        return shape
    up = unit(newell(shape.mesh.polygon(0)))
    direction = up
    if call.words and call.words[0].startswith("world"):
        direction = shape.rotation.T @ np.array([0.0, 1.0, 0.0])
    frame = frame_from_y(direction, np.array([1.0, 0.0, 0.0]))
    prism = extruded(shape.mesh, direction * height)
    turned = replace(shape, rotation=shape.rotation @ frame, mesh=prism.moved(lambda p: frame.T @ p))
    return turned.fitted()


def frame_from_y(y: Vector, x: Vector) -> np.ndarray:
    """The frame with this y axis, whose x axis is as near as possible to the given one; else it lies across z."""
    across = unit(x - y * np.dot(x, y))
    if np.linalg.norm(x - y * np.dot(x, y)) < 1e-6:
        across = unit(np.cross(y, np.array([0.0, 0.0, 1.0])))
    return np.column_stack([across, y, np.cross(across, y)])


def extruded(mesh: Mesh, shift: Vector) -> Mesh:
    """The faces, the moved faces and walls over border edges, all looking outwards; turned over, first edges stay."""
    count = len(mesh.points)
    edges = [edge for face in mesh.faces for edge in outline_then_holes(face)]
    border = [(a, b) for a, b in edges if (b, a) not in edges]
    outwards = np.dot(normal(mesh.polygon(0)), shift) > 0.0
    walls = [(a, b, b + count, a + count) if outwards else (b, a, a + count, b + count) for a, b in border]
    if not outwards:
        walls = [(b, a, a + count, b + count) for a, b in border]
    tops = [tuple(i + count for i in face) for face in mesh.faces]
    bottoms = [turned_over(face) for face in mesh.faces]
    if not outwards:
        tops = [turned_over(face) for face in tops]
        bottoms = list(mesh.faces)
    points = (*mesh.points, *(p + shift for p in mesh.points))
    return Mesh(points, (*bottoms, *tops, *walls))


def turned_over(face: tuple[int, ...]) -> tuple[int, ...]:
    return (face[1], face[0], *reversed(face[2:]))


def primitive(mesh: Mesh, call: Call, own: Vector | None = None) -> Shape:
    """Fit a mesh to the scope; axes of no extent follow the others, in proportion to its own size."""
    shape = call.shape
    low, high = mesh.bounds()
    own = high - low if own is None else own
    size = shape.size.copy()
    empty = size <= 0.0
    with np.errstate(all="ignore"):
        factors = np.where(own > 0.0, size / own, 1.0)[~empty]
    scale = 1.0 if empty.all() else float(np.mean(factors))
    size = np.where(empty, own * scale, size)
    stretch = np.divide(size, high - low, out=np.zeros(3), where=high > low)
    filled = replace(shape, size=size, mesh=mesh.moved(lambda p: (p - low) * stretch))
    # With two or three dimensions to choose, the mesh also keeps its place along them.
    return trimmed(filled.shifted(np.where(empty, scale * low, 0.0)) if empty.sum() >= 2 else filled)


def insert(call: Call) -> Shape:
    """``i(name)``: a built-in primitive or an asset."""
    name = str(call.arguments[0].value)
    if name.startswith("builtin:"):
        name = name.removesuffix(":notex")
        own = natural_size(name.removeprefix("builtin:"))
        return primitive(Mesh.from_columns(builtin_asset(name)), call, own)
    return primitive(call.assets(name), call)


def reverse_normals(call: Call) -> Shape:
    """Every face seen from the other side; the first edge stays the first."""
    mesh = call.shape.mesh
    faces = tuple(turned_over(face) for face in mesh.faces)
    return replace(call.shape, mesh=replace(mesh, faces=faces))


def color(call: Call) -> Shape:
    values = [a.value for a in call.arguments]
    if isinstance(values[0], str):
        digits = values[0].removeprefix("#")
        numbers = [int(digits[i : i + 2], 16) / 255.0 for i in range(0, len(digits), 2)]
    else:
        numbers = [min(max(number(v), 0.0), 1.0) for v in values]
    return painted(call.shape, dict(zip(("color.r", "color.g", "color.b", "opacity"), numbers, strict=False)))


def painted(shape: Shape, changes: dict[str, float | str]) -> Shape:
    return replace(shape, material={**shape.material, **changes})


def texture(call: Call) -> Shape:
    return painted(call.shape, {"texture": str(call.arguments[0].value)})


def set_attribute(call: Call) -> Shape:
    name, value = str(call.arguments[0].value), call.arguments[1].value
    if name in call.scope.model.attribute_definitions:
        return replace(call.shape, attributes={**call.shape.attributes, name: value})
    if name in call.shape.state:
        return replace(call.shape, state={**call.shape.state, name: value})
    channel = name.removeprefix("material.")
    if channel in ("color.rgb", "color"):
        return color(replace(call, arguments=call.arguments[1:]))
    if channel == "colormap":
        return texture(replace(call, arguments=call.arguments[1:]))
    channel = {"color.a": "opacity"}.get(channel, channel)
    if name.startswith("material.") and channel in call.shape.material:
        return painted(call.shape, {channel: min(max(number(value), 0.0), 1.0)})
    return call.shape


def report(call: Call) -> Shape:
    key, value = (a.value for a in call.arguments)
    call.scope.model.reports.append((call.shape.node, str(key), value))
    return call.shape


def unchanged(call: Call) -> Shape:
    return call.shape


def _primitive_named(name: str) -> Callable[[Call], Shape]:
    return lambda call: primitive(Mesh.from_columns(builtin_asset(name)), call)


OPERATIONS: dict[str, Callable[[Call], Shape]] = {
    "center": center,
    "color": color,
    "extrude": extrude,
    "i": insert,
    "label": unchanged,
    "primitiveCube": _primitive_named("cube"),
    "print": unchanged,
    "r": r,
    "report": report,
    "reverseNormals": reverse_normals,
    "rotate": rotate,
    "s": s,
    "scale": s,
    "set": set_attribute,
    "t": t,
    "texture": texture,
    "translate": translate,
}
