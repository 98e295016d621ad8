"""Vocabulary of expressions: keywords of CGA, precedence of operators, types, and contexts of expressions.

The parser and the formatter share the table of precedences.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import cast

from grammarlab.errors import Location
from grammarlab.language.syntax.syntax_tree import Binary, BinaryOperator, Expression, Floating

_AXES = "x y z"
_SIDES = "front back left right top bottom"
_COMPASS = "world.south world.north world.west world.east world.up world.down world.side"
_OBJECT_SIDES = "object.front object.back object.left object.right object.top object.bottom object.side"
_STREET_SIDES = "street.front street.back street.left street.right street.side"
_SLOPES = "vertical horizontal aslant nutant side"
_COMPONENT_SELECTORS = (
    f"{_SIDES} {_OBJECT_SIDES} {_COMPASS} {_STREET_SIDES} {_SLOPES} all border inside eave hip valley ridge "
    "streetSide noStreetSide"
)
KEYWORDS: Mapping[str, frozenset[str]] = {
    name: frozenset(words.split())
    for name, words in {
        "axis": _AXES,
        "uv_axis": "u v",
        "adjust": "adjust noAdjust",
        "uv_space": "uvSpace unitSpace",
        "axes": "x y z xy xz yz xyz",
        "world_axes": "x y z world.x world.y world.z world.xyz object.x object.y object.z object.xyz",
        "axis_pair": "xy yx xz zx yz zy",
        "axis_order": "xyz yzx zxy",
        "up": "yUp zUp",
        "face": "world.lowest largest any auto",
        "edge": "world.lowest longest auto",
        "component": "f e fe v fv g m h",
        "component_scope": "zUp noAlign",
        "component_selector": _COMPONENT_SELECTORS,
        "setback_selector": f"{_SIDES} side {_OBJECT_SIDES} {_COMPASS} {_STREET_SIDES} streetSide noStreetSide all "
        "remainder uv.left uv.right uv.bottom uv.top uv.uMin uv.uMax uv.vMin uv.vMax",
        "shape_selector": "shape remainder",
        "remainder_selector": "remainder",
        "extrusion": "world.up world.up.flatTop face.normal vertex.normal x y z world.x world.y world.z",
        "envelope": "normal world.up",
        "keep_faces": "all inside border",
        "cleanup": "all edges faces vertices",
        "insert": "alignSizeAndPosition keepSizeAndPosition keepSizeAlignPosition",
        "insert_cleanup": "numericalCleanup noCleanup",
        "height_direction": "scope.y vertex.normal",
        "height_alignment": "alignPosition keepPosition",
        "rectangle": "scope edge",
        "uv_mode": "uv uvUniform u v",
        "uv_faces": "separatePerFace collectiveAllFaces",
        "projection": "scope.xy scope.xz scope.yx scope.yz scope.zx scope.zy "
        "world.xy world.xz world.yx world.yz world.zx world.zy",
        "rotation_centre": "scopeOrigin scopeCenter",
        "mode": "abs rel",
        "system": "scope pivot object world",
        "material_target": "shape geometry all",
        "normals": "hard conform soft auto",
        "roof": "byAngle byHeight",
        "domain": "surface volume scope",
        "uniform": "uniform",
        "gaussian": "gaussian",
        "scatter_mean": f"center {_SIDES}",
        "tagged": "auto all faces edges vertices",
        "tag_components": "e v",
        "swap": "noSwap swap",
        "merge": "append unify recompose",
        "slope_angle": "maxSlope zenith azimuth",
        "orientation": f"all surface side {_SIDES} {_OBJECT_SIDES} {_COMPASS} {_STREET_SIDES}",
        "target": "intra inter all",
        "comparison": "world.northernmost world.southernmost world.easternmost world.westernmost world.highest "
        "world.lowest area.largest area.smallest",
        "asset_measure": "sx sy sz tx ty tz",
        "asset_name": "g m",
        "image_measure": "sx sy",
        "coordinate": "X Y lat lon",
        "position_type": "pos orient",
        "material_source": "used shape geometry",
        "material_mode": "all changed",
    }.items()
}

_LEVELS = (("||",), ("&&",), ("==", "!="), ("<", "<=", ">", ">="), ("+", "-"), ("*", "/", "%"))
"""Operators by increasing precedence; all are left-associative."""
BINARY_PRECEDENCE: dict[str, int] = {
    dot + operator: level for level, operators in enumerate(_LEVELS, 1) for operator in operators for dot in ("", ".")
}
FLOATING_PRECEDENCE = 0
"""``~`` applies to the whole size: ``~a * b`` is about ``a * b``."""
PREFIX_PRECEDENCE = len(_LEVELS) + 1
POSTFIX_PRECEDENCE = PREFIX_PRECEDENCE + 1

Types = frozenset[str]
"""Types that a value may have."""
ANY: Types = frozenset({"float", "bool", "string", "float[]", "bool[]", "string[]"})
ARRAYS: Types = frozenset({"float[]", "bool[]", "string[]"})
FLOAT: Types = frozenset({"float"})
BOOL: Types = frozenset({"bool"})
STRING: Types = frozenset({"string"})
_NAMES = {"size": FLOAT, "tile": FLOAT, "any": ANY, "place": ANY}


@dataclass(frozen=True, slots=True)
class Scope:
    """Context of an expression."""

    locals: frozenset[str] = frozenset()
    """Parameters and local variables."""
    selectors: frozenset[str] = frozenset()
    """Words that select components in this context."""
    relative: bool = False
    """Whether ``'`` is allowed."""
    floating: bool = False
    """Whether ``~`` is allowed."""

    def plain(self) -> Scope:
        """The same context, inside an argument."""
        return replace(self, selectors=frozenset(), relative=False, floating=False)


def types_of(names: Sequence[str]) -> Types:
    """Types from the names in a signature."""
    return frozenset[str]().union(*(_NAMES.get(name, frozenset({name})) for name in names))


def in_words(types: Types) -> str:
    """Types in the words of messages."""
    words = {"float": "a number", "bool": "a boolean", "string": "a string"}
    words |= {f"{kind}[]": f"an array of {kind}s" for kind in ("float", "bool", "string")}
    return "anything" if types == ANY else " or ".join(words[kind] for kind in sorted(types)) or "nothing"


def advice(expected: Types, actual: Types) -> str:
    """Hint for a conversion from the found type to the expected type; empty if there is none."""
    if expected == STRING:
        return "str(…) converts to a string"
    if expected == FLOAT and actual == STRING:
        return "float(…) converts a string to a number"
    return ""


def group_operands(operands: Sequence[Expression], operators: Sequence[str]) -> Expression:
    """Tree of ``operands[0] operators[0] operands[1] …`` (precedence climbing with two stacks)."""
    first = operands[0]
    if isinstance(first, Floating) and operators:
        inner = group_operands([first.operand, *operands[1:]], operators)
        return Floating(inner, location=span(first.location, inner.location))
    values = [first]
    pending: list[str] = []

    def reduce() -> None:
        right, left = values.pop(), values.pop()
        operator = cast(BinaryOperator, pending.pop())
        values.append(Binary(operator, left, right, location=span(left.location, right.location)))

    for operator, operand in zip(operators, operands[1:], strict=True):
        while pending and BINARY_PRECEDENCE[pending[-1]] >= BINARY_PRECEDENCE[operator]:
            reduce()
        pending.append(operator)
        values.append(operand)
    while pending:
        reduce()
    return values[0]


def span(first: Location, last: Location) -> Location:
    """From the beginning of one place to the end of another, or to the end of the first line."""
    if last.line != first.line or last.column < first.column:
        return first
    return Location(first.line, first.column, last.column + last.length - first.column, first.file)
