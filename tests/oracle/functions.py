"""The built-in functions and shape attributes of CGA, for one shape at a time."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from tests.oracle.shape import AXES, FRESH_STATE, Shape, Value, area, newell, normal

if TYPE_CHECKING:
    from tests.oracle.expressions import Scope


def through_array(function: Callable[..., np.ndarray], *arguments: float) -> float:
    """A NumPy function on columns of length 1: on single numbers it may give other last bits."""
    return float(function(*(np.array([float(a)]) for a in arguments))[0])


def in_degrees(function: Callable[..., np.ndarray]) -> Callable[..., float]:
    return lambda *arguments: through_array(lambda *x: np.degrees(function(*x)), *arguments)


def of_degrees(function: Callable[..., np.ndarray]) -> Callable[..., float]:
    return lambda x: through_array(lambda a: function(np.radians(a)), x)


def number_text(value: Value) -> str:
    """A value as CGA writes it into strings."""
    if isinstance(value, bool):
        return "true" if value else "false"
    return value if isinstance(value, str) else f"{value:.6g}"


def to_number(value: Value) -> float:
    try:
        return float(value)
    except ValueError:
        return math.nan


def items(text: str) -> list[str]:
    """The items of a list: a string with a semicolon after each, which the last may lack."""
    return text.removesuffix(";").split(";") if text else []


def item(text: str, index: float) -> str:
    known = items(text)
    return known[int(index)] if 0 <= index < len(known) else ""


def found(text: str, sought: str, nth: float = 0.0) -> float:
    places = [i for i in range(len(text)) if text.startswith(sought, i)]
    return float(places[int(nth)]) if nth < len(places) else -1.0


PLAIN: dict[str, Callable[..., Any]] = {
    "abs": abs,
    "acos": in_degrees(np.arccos),
    "asin": in_degrees(np.arcsin),
    "atan": in_degrees(np.arctan),
    "atan2": in_degrees(np.arctan2),
    "ceil": lambda x: float(math.ceil(x)),
    "clamp": lambda x, low, high: min(max(x, low), high),
    "cos": of_degrees(np.cos),
    "exp": lambda x: through_array(np.exp, x),
    "floor": lambda x: float(math.floor(x)),
    "isinf": math.isinf,
    "isnan": math.isnan,
    "ln": lambda x: through_array(np.log, x),
    "log10": lambda x: through_array(np.log10, x),
    "max": max,
    "min": min,
    "pow": lambda x, y: through_array(np.power, x, y),
    "rint": lambda x: float(round(x)),
    "sin": of_degrees(np.sin),
    "sqrt": math.sqrt,
    "tan": of_degrees(np.tan),
    "bool": lambda v: v.strip().lower() not in {"", "0", "f", "false"} if isinstance(v, str) else bool(v),
    "float": to_number,
    "str": number_text,
    "len": lambda text: float(len(text)),
    "count": lambda text, sought: float(text.count(sought)),
    "find": found,
    "substring": lambda text, first, last: text[max(0, int(first)) : max(0, int(last))],
    "replace": lambda text, old, new: text.replace(old, new),
    "getPrefix": lambda text, mark: text.split(mark)[0],
    "getSuffix": lambda text, mark: text.split(mark)[-1] if mark in text else "",
    "listItem": item,
    "listFirst": lambda text: item(text, 0),
    "listLast": lambda text: items(text)[-1] if items(text) else "",
    "listSize": lambda text: float(len(items(text))),
    "listIndex": lambda text, sought: float(items(text).index(sought)) if sought in items(text) else -1.0,
    "listAdd": lambda text, new: "".join(f"{i};" for i in [*items(text), new]),
}
"""Functions of values alone."""


def volume(shape: Shape) -> float:
    """By the divergence theorem, over the corners as they are."""
    apex = shape.mesh.points[0]
    return sum(float(np.dot(polygon[0] - apex, newell(polygon))) for polygon in shape.mesh.polygons()) / 3.0


def world_height(shape: Shape) -> float:
    heights = [shape.to_world(p)[1] for p in shape.mesh.points]
    return float(max(heights) - min(heights)) if heights else 0.0


def is_rectangular(shape: Shape, tolerance: float = 0.0) -> bool:
    """Whether every face has four corners of 90 degrees."""
    for polygon in shape.mesh.polygons():
        if len(polygon) != 4:
            return False
        for i in range(4):
            one, other = polygon[i - 1] - polygon[i], polygon[(i + 1) % 4] - polygon[i]
            cosine = np.dot(one, other) / (np.linalg.norm(one) * np.linalg.norm(other))
            if abs(cosine) > math.sin(math.radians(tolerance)) + 1e-9:
                return False
    return bool(shape.mesh.faces)


def is_concave(shape: Shape) -> bool:
    """Whether some face turns to the right somewhere."""
    for polygon in shape.mesh.polygons():
        up = normal(polygon)
        for i, corner in enumerate(polygon):
            turn = np.cross(corner - polygon[i - 1], polygon[(i + 1) % len(polygon)] - corner)
            if np.dot(turn, up) < -1e-9:
                return True
    return False


MEASURES: dict[str, Callable[..., Value]] = {
    "geometry.area": lambda shape: sum(area(polygon) for polygon in shape.mesh.polygons()),
    "geometry.volume": volume,
    "geometry.height": world_height,
    "geometry.nFaces": lambda shape: float(len(shape.mesh.faces)),
    "geometry.nVertices": lambda shape: float(len(shape.mesh.points)),
    "geometry.isRectangular": is_rectangular,
    "geometry.isConcave": is_concave,
}
"""Functions of the shape's geometry."""


def euler_angles(rotation: np.ndarray) -> list[float]:
    """Degrees about x, y and z whose rotations, x innermost, make up a matrix; z is 0 where y is a right angle."""
    y = math.asin(min(1.0, max(-1.0, -rotation[2, 0])))
    if math.hypot(rotation[2, 1], rotation[2, 2]) < 1e-7:
        return [math.degrees(math.atan2(-rotation[1, 2], rotation[1, 1])), math.copysign(90.0, y), 0.0]
    x = math.atan2(rotation[2, 1], rotation[2, 2])
    z = math.atan2(rotation[1, 0], rotation[0, 0])
    return [math.degrees(angle) for angle in (x, y, z)]


def shape_attribute(name: str, scope: Scope) -> Value | None:
    """What a name such as ``scope.sx`` means for a shape; None when it is no shape attribute."""
    shape = scope.shape
    root = scope.model.root
    family, _, member = name.partition(".")
    if name in FRESH_STATE:
        return shape.state[name]
    if family == "material":
        return shape.material.get(member)
    if family == "scope" and member == "elevation":
        return float(shape.position[1])
    if family == "scope" and len(member) == 2 and member[1] in AXES:
        axis = AXES.index(member[1])
        match member[0]:
            case "s":
                return float(shape.size[axis])
            case "t":
                return float((shape.pivot.T @ (shape.position - shape.pivot_position))[axis])
            case "r":
                return euler_angles(shape.pivot.T @ shape.rotation)[axis]
    if family == "pivot" and len(member) == 2 and member[1] in AXES:
        axis = AXES.index(member[1])
        if member[0] == "p":
            return float((root.rotation.T @ (shape.pivot_position - root.position))[axis])
        return euler_angles(root.rotation.T @ shape.pivot)[axis]
    if name in {f"initialShape.origin.p{axis}" for axis in AXES}:
        return float(root.position[AXES.index(name[-1])])
    return None
