"""Units of what a grammar draws: metres, their powers, and degrees, from annotations and from where values end up.

CGA has no units in its text, but its operations have: what `extrude` takes is a length, what `r` takes an angle. So
the arguments of operations say what the names in them are, those names say what their own values are, and so on until
nothing new follows. A name with two different units has none, and so has a factor beside another unknown one.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TypeAlias

from grammarlab.language.syntax.builtins import Signatures, blocks, operations
from grammarlab.language.syntax.syntax_tree import (
    Annotation,
    Attribute,
    Binary,
    Block,
    Call,
    Case,
    Definition,
    Expression,
    Floating,
    Function,
    Group,
    Invoke,
    Name,
    Node,
    Part,
    Rule,
    RuleFile,
    Stochastic,
    String,
    Unary,
    alternatives,
    walk,
)

METRES, DEGREES = "m", "°"
_POWERS: Mapping[str, int] = {"": 0, METRES: 1, "m²": 2, "m³": 3}
"""Exponents of metres."""
_UNITS = {power: unit for unit, power in _POWERS.items()}
_DESCRIBED = re.compile(
    r"(?:,|\bin|\(|\[)\s*(?:(met(?:re|er)s?|m)|(square met(?:re|er)s|m2|m²|sqm)|(degrees?|deg|°))[\s.)\]]*$",
    re.IGNORECASE,
)
"""The unit at the end of a description, as in ``Height of the ground floor, metres``."""
_ANNOTATED = {"distance": METRES, "angle": DEGREES}
_ANGLES = frozenset({"r", "rotate", "rotateScope"})
_AREAS = frozenset({"setbackToArea", "splitArea"})
_PRIMITIVES = {"primitiveQuad": 0, "primitiveCube": 0, "primitiveCylinder": 1, "primitiveCone": 1}
"""Number of arguments before the lengths of a primitive."""
_SAME = frozenset({"abs", "ceil", "clamp", "floor", "max", "min", "rand", "rint"})
"""Functions whose arguments have the unit of their results."""
_SUMS = frozenset({"+", "-", "%", "abs", "ceil", "floor", "least", "max", "min", "rint"})
"""Operations of formulas whose results have the unit of their operands."""
_MEASURED: Mapping[str, str] = {
    **{f"scope.{kind}{axis}": unit for kind, unit in (("s", METRES), ("t", METRES), ("r", DEGREES)) for axis in "xyz"},
    **dict.fromkeys(("split.index", "split.total", "comp.index", "comp.total"), ""),
    **dict.fromkeys(("scope.elevation", "geometry.height", "geometry.boundaryLength"), METRES),
    "geometry.area": "m²",
    "geometry.volume": "m³",
}
"""Units of what the engine measures."""
_Owner: TypeAlias = tuple[str, int]
"""A rule or function with its number of parameters."""
_Key: TypeAlias = tuple[str, int, str]
"""A name in its definition: of a parameter, or of an attribute or function in `_GLOBAL`."""
_GLOBAL: _Owner = ("", 0)


@dataclass
class _Demands:
    """What follows so far from the places where values end up."""

    parameters: Mapping[_Owner, tuple[str, ...]]
    """Names of the parameters of rules and functions."""
    stated: Mapping[_Key, str]
    """Units of names by their annotations."""
    units: dict[_Key, str | None] = field(default_factory=dict)
    """Units of the other names; None for two different ones."""
    calls: dict[int, str | None] = field(default_factory=dict)
    """Units of calls by `Numbered.number`; None for two different ones."""

    def unit(self, node: Node, owner: _Owner) -> str | None:
        """Unit of an expression in a definition; None if it does not follow from its parts."""
        match node:
            case Name(identifier=name):
                return _MEASURED[name] if name in _MEASURED else self.of_key(self._key(name, owner))
            case Call(function=name):
                return _MEASURED.get(name, self.of_key((*_GLOBAL, name)))
            case Unary(operand=operand) | Floating(operand=operand):
                return self.unit(operand, owner)
            case Binary(operator="*" | "/" as operator, left=left, right=right):
                return _product(self.unit(left, owner), self.unit(right, owner), -1 if operator == "/" else 1)
            case Binary(operator="+" | "-", left=left, right=right):
                return self.unit(left, owner) or self.unit(right, owner)
            case _:
                return None

    def demand(self, node: Node, unit: str | None, owner: _Owner) -> None:
        """Learn from an expression whose unit is known from its place; None if it is not."""
        if unit is None:
            return
        match node:
            case Name(identifier=name):
                self._note(self._key(name, owner), unit)
            case Call(function=name, arguments=arguments, number=number):
                self._note((*_GLOBAL, name), unit)
                self.calls[number] = unit if self.calls.get(number, unit) == unit else None
                for argument in arguments if name in _SAME else ():
                    self.demand(argument, unit, owner)
            case Unary(operand=operand) | Floating(operand=operand):
                self.demand(operand, unit, owner)
            case Binary(operator="+" | "-", left=left, right=right):
                self.demand(left, unit, owner)
                self.demand(right, unit, owner)
            case Binary(operator="*", left=left, right=right):
                self.demand(left, _product(unit, self.unit(right, owner), -1), owner)
                self.demand(right, _product(unit, self.unit(left, owner), -1), owner)
            case Binary(operator="/", left=left, right=right):
                self.demand(left, _product(unit, self.unit(right, owner), 1), owner)
                self.demand(right, _product(self.unit(left, owner), unit, -1), owner)
            case Case() | Stochastic():
                for leaf in alternatives(node):
                    self.demand(leaf, unit, owner)
            case _:
                pass

    def of_key(self, key: _Key) -> str | None:
        return self.stated.get(key, self.units.get(key))

    def _key(self, name: str, owner: _Owner) -> _Key:
        return (*owner, name) if name in self.parameters.get(owner, ()) else (*_GLOBAL, name)

    def _note(self, key: _Key, unit: str) -> None:
        self.units[key] = unit if self.units.get(key, unit) == unit else None


def units_of_calls(tree: RuleFile) -> dict[int, str]:
    """Units of calls by `Numbered.number`: ``m``, ``m²``, ``m³`` or ``°``; without those that are unknown.

    >>> from grammarlab.language.grammar import Grammar
    >>> grammar = Grammar.parse('''
    ... attr height = rand(9, 30)
    ... @Description("Pitch of the roof, degrees")
    ... attr pitch = rand(20, 50)
    ... attr share = rand(0, 1)
    ... Lot --> extrude(height) Tower(share)
    ... ''')
    >>> sorted(units_of_calls(grammar.tree).values())
    ['m', '°']
    """
    return {number: unit for number, unit in _followed(tree).calls.items() if unit}


def units_of_attributes(tree: RuleFile) -> dict[str, str]:
    """Units of attributes, constants and functions by name, without those that are unknown.

    >>> from grammarlab.language.grammar import Grammar
    >>> units_of_attributes(Grammar.parse("attr height = 9 attr tilt = 3 Lot --> extrude(height) r(0, tilt, 0) A").tree)
    {'height': 'm', 'tilt': '°'}
    """
    demands = _followed(tree)
    units = {**demands.units, **demands.stated}
    return {name: unit for (owner, _, name), unit in units.items() if unit and not owner}


def _followed(tree: RuleFile) -> _Demands:
    """All that follows from a file."""
    values = [node for node in tree.definitions if isinstance(node, Attribute | Function)]
    nodes = [(node, _owner(definition)) for definition in tree.definitions for node in walk(definition)]
    sizes = [(size, unit, owner) for node, owner in nodes for size, unit in _sizes(node)]
    calls = [(node, owner) for node, owner in nodes if isinstance(node, Invoke | Call)]
    demands = _Demands(
        {_owner(node): node.parameters for node in tree.definitions if isinstance(node, Rule | Function)},
        {(*_GLOBAL, node.name): unit for node in values if (unit := _stated(node.annotations))},
    )
    before: dict[_Key, str | None] | None = None
    while before != demands.units:  # each pass gives a unit to some name, or takes it away for good
        before = dict(demands.units)
        demands.calls.clear()  # what is drawn for a name that has lost its unit has none
        for size, unit, owner in sizes:
            demands.demand(size, unit, owner)
        for call, owner in calls:
            name = call.name if isinstance(call, Invoke) else call.function
            callee = (name, len(call.arguments))
            for parameter, argument in zip(demands.parameters.get(callee, ()), call.arguments, strict=False):
                demands.demand(argument, demands.of_key((*callee, parameter)), owner)
        for node in values:
            for leaf in alternatives(node.value):
                demands.demand(leaf, demands.of_key((*_GLOBAL, node.name)), _owner(node))
    return demands


def unit_of_result(operation: str, units: Sequence[str | None]) -> str | None:
    """Unit of the result of an operation of a formula; None for a plain number, which is of any unit.

    Args:
        operation: name or sign of the operation.
        units: units of its operands; empty for numbers of things and unknown ones, None for plain numbers.

    >>> unit_of_result("*", ["m", "m"]), unit_of_result("+", ["m", None]), unit_of_result("+", ["m", "°"])
    ('m²', 'm', '')
    """
    if operation == "choose":
        operation, units = "min", [*units[1::2], units[-1]]
    given = [unit for unit in units if unit is not None]
    if operation in _SUMS:
        return None if not given else given[0] if len(set(given)) == 1 else ""
    if operation not in ("*", "/"):
        return ""
    first, second = (unit or "" for unit in units)
    return _product(first, second, -1 if operation == "/" else 1) or (first if not second else "")


def _owner(definition: Definition) -> _Owner:
    return (definition.name, len(definition.parameters)) if isinstance(definition, Rule | Function) else _GLOBAL


def _product(first: str | None, second: str | None, sign: int) -> str | None:
    """Unit of a product, or with a sign of -1 of a quotient; None if it is none of `_POWERS`."""
    if first is None or second is None or not {first, second} <= _POWERS.keys():
        return None
    return _UNITS.get(_POWERS[first] + sign * _POWERS[second])


def _stated(annotations: tuple[Annotation, ...]) -> str:
    """The unit that annotations give to an attribute; empty for none."""
    for annotation in annotations:
        name = annotation.name.lower()
        if name in _ANNOTATED:
            return _ANNOTATED[name]
        for _, value in annotation.arguments if name == "description" else ():
            if isinstance(value, String) and (match := _DESCRIBED.search(value.value)):
                return METRES if match[1] else "m²" if match[2] else DEGREES
    return ""


def _sizes(node: Node) -> Iterator[tuple[Expression, str]]:
    """Arguments of an operation, and sizes of its parts, with their units."""
    if isinstance(node, Invoke):
        yield from _arguments(node)
    elif isinstance(node, Block):
        unit = "m²" if node.name in _AREAS else METRES
        yield from _typed(node, blocks(), unit)
        if any(form.heads == "size" and form.takes(len(node.arguments)) for form in blocks().get(node.name, ())):
            is_length = not any(isinstance(axis, Name) and axis.identifier in "uv" for axis in node.arguments)
            yield from ((part.head, unit) for part in _parts(node.group) if is_length)


def _arguments(node: Invoke) -> Iterator[tuple[Expression, str]]:
    if node.name in _ANGLES:
        yield from ((value, DEGREES) for value in node.arguments[-3:])
    elif node.name in _PRIMITIVES:
        yield from ((value, METRES) for value in node.arguments[_PRIMITIVES[node.name] :])
    elif node.name.startswith("roof"):
        flag = node.arguments[0].identifier if node.arguments and isinstance(node.arguments[0], Name) else ""
        values = node.arguments[1:] if flag in ("byAngle", "byHeight") else node.arguments
        yield from ((value, METRES if flag == "byHeight" else DEGREES) for value in values[:1])
        yield from ((value, METRES) for value in values[1:2])
    elif "UV" not in node.name:
        yield from _typed(node, operations(), METRES)


def _typed(node: Invoke | Block, forms: Signatures, unit: str) -> Iterator[tuple[Expression, str]]:
    """Arguments that the tables of operations call sizes."""
    fitting = [form for form in forms.get(node.name, ()) if form.takes(len(node.arguments))]
    for argument, parameter in zip(node.arguments, fitting[0].parameters if fitting else (), strict=False):
        if not {"size", "tile"}.isdisjoint(parameter.types):
            yield argument, unit


def _parts(group: Group) -> Iterator[Part]:
    for part in group.parts:
        yield from _parts(part) if isinstance(part, Group) else (part,)
