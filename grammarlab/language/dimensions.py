"""Units of what a grammar draws: metres, their powers, and degrees, from annotations and from where values end up.

CGA has no units in its text, but its operations have: what `extrude` takes is a length, what `r` takes an angle. So
the arguments of operations say what the names in them are, those names say what their own values are, and so on until
nothing new follows. What is used with two different units has none, nor has any value that it is made of. A factor
beside another unknown one stays unknown.

A number in the text may be a plain one or a length: in ``extrude(3 * floors)`` it is the height of a floor. Only
beside a size of the scope, as in ``scope.sx - 2 * inset``, it is taken for a plain one.
"""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TypeAlias

from grammarlab.language.syntax.builtins import Signatures, blocks, operations
from grammarlab.language.syntax.outline import MAX_DEPTH
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
    Number,
    Part,
    Relative,
    Rule,
    RuleFile,
    Stochastic,
    String,
    Unary,
    alternatives,
    walk,
)

METRES, DEGREES = "m", "°"
UNKNOWN = "?"
"""Unit of what is of no known unit, nor known to be a plain number."""
_POWERS: Mapping[str, int] = {"": 0, METRES: 1, "m²": 2, "m³": 3}
"""Exponents of metres."""
_UNITS = {power: unit for unit, power in _POWERS.items()}
_DESCRIBED = re.compile(
    r"(?:,|\b(?i:in)|\(|\[)\s*"
    r"(?:((?i:met(?:re|er)s?)|m)|((?i:square met(?:re|er)s|sqm)|m2|m²)|((?i:degrees?)|deg|°))[\s.)\]]*$"
)
"""The unit at the end of a description, as in ``Height of the ground floor, metres``."""
_ANNOTATED = {"distance": METRES, "angle": DEGREES}
_ANGLES = frozenset({"r", "rotate", "rotateScope"})
_AREAS = frozenset({"setbackToArea", "splitArea"})
_PRIMITIVES = {"primitiveQuad": 0, "primitiveCube": 0, "primitiveCylinder": 1, "primitiveCone": 1}
"""Number of arguments before the lengths of a primitive."""
_OVERHANGS = {"roofGable": 2, "roofHip": 1}
"""Number of lengths that may follow the slope of a roof."""
_SAME = frozenset({"abs", "ceil", "clamp", "floor", "max", "min", "rand", "rint"})
"""Functions whose arguments have the unit of their results."""
_SUMS = frozenset({"+", "-", "%", "abs", "ceil", "floor", "least", "max", "min", "rint"})
"""Operations of formulas whose results have the unit of their operands."""
_CURVES = frozenset({"exp", "log", "sqrt"})
"""Operations of formulas whose results have none of our units; those of all others are plain numbers."""
_MEASURED: Mapping[str, str] = {
    **{f"scope.{kind}{axis}": unit for kind, unit in (("s", METRES), ("t", METRES), ("r", DEGREES)) for axis in "xyz"},
    **dict.fromkeys(("split.index", "split.total", "comp.index", "comp.total"), ""),
    **dict.fromkeys(("scope.elevation", "geometry.height", "geometry.boundaryLength"), METRES),
    "geometry.area": "m²",
    "geometry.volume": "m³",
}
"""Units of what the engine measures."""
_Owner: TypeAlias = tuple[type, str, int]
"""A definition: its kind, name and number of parameters."""
_Key: TypeAlias = tuple[_Owner | None, str]
"""A local name in its definition, or with None an attribute or function."""


@dataclass(frozen=True, slots=True)
class _Scope:
    """What the names in a part of a definition mean."""

    owner: _Owner
    places: Mapping[str, int]
    """Local names of the definition: 0 for parameters, then the number of the variable."""
    num_before: int
    """Number of variables before the part, which it can read."""

    def key(self, name: str) -> _Key:
        return (self.owner if self.places.get(name, self.num_before + 1) <= self.num_before else None, name)


@dataclass(frozen=True, slots=True, eq=False)
class _Flow:
    """A value whose unit follows from its place."""

    node: Expression
    scope: _Scope
    source: _Key | str
    """The unit, or the name that has it."""
    is_plain: bool = False
    """Whether the numbers in it are plain ones."""

    def read(self) -> Iterator[_Key]:
        """The names on whose units depends what follows from this value."""
        if not isinstance(self.source, str):
            yield self.source
        for node in () if isinstance(self.node, Name | Call) else walk(self.node):
            if isinstance(node, Name):
                yield self.scope.key(node.identifier)
            elif isinstance(node, Call):
                yield (None, node.function)


@dataclass
class _Units:
    """What follows so far from the places where values end up."""

    defined: frozenset[str]
    """Names of the attributes and functions of the file."""
    stated: Mapping[_Key, str]
    """Units of names by their annotations."""
    names: dict[_Key, str] = field(default_factory=dict)
    """Units of the other names; `UNKNOWN` for two different ones."""
    calls: dict[int, str] = field(default_factory=dict)
    """Units of calls by `Numbered.number`; `UNKNOWN` for two different ones."""
    changed: list[_Key] = field(default_factory=list)
    """Names whose units have changed: from nothing to a unit, from that to `UNKNOWN`, never back."""

    def follow(self, flow: _Flow) -> None:
        """Learn from a value."""
        unit = flow.source if isinstance(flow.source, str) else self.of_key(flow.source)
        self._demand(flow.node, unit, flow.scope, flow.is_plain)

    def of_key(self, key: _Key) -> str | None:
        return self.stated.get(key, self.names.get(key))

    def _unit(self, node: Node, scope: _Scope) -> str | None:
        """Unit of an expression; None if nothing follows from its parts so far."""
        match node:
            case Name(identifier=name):
                return _MEASURED[name] if name in _MEASURED else self.of_key(scope.key(name))
            case Call(function=name):
                return _MEASURED[name] if name in _MEASURED else self.of_key((None, name))
            case Unary(operand=operand) | Floating(operand=operand):
                return self._unit(operand, scope)
            case Binary(operator="*" | "/" as operator, left=left, right=right):
                return _product(self._unit(left, scope), self._unit(right, scope), -1 if operator == "/" else 1)
            case Binary(operator="+" | "-", left=left, right=right):
                return _joined(self._unit(left, scope), self._unit(right, scope))
            case _:
                return None

    def _demand(self, node: Node, unit: str | None, scope: _Scope, is_plain: bool) -> None:
        """Learn from an expression of a unit; None if nothing is known of it so far."""
        if unit is None:
            return
        for leaf, plain in _of_same_unit(node, is_plain):
            match leaf:
                case Name(identifier=name):
                    self._note(scope.key(name), unit)
                case Call(function=name, number=number):
                    self._note((None, name), unit)
                    self.calls[number] = _joined(self.calls.get(number), unit) or ""
                case Binary(operator="*" | "/" as operator, left=left, right=right):
                    first, second = (
                        "" if plain and isinstance(part, Number) else self._unit(part, scope) for part in (left, right)
                    )
                    self._demand(left, _product(unit, second, 1 if operator == "/" else -1), scope, plain)
                    of_right = (first, unit) if operator == "/" else (unit, first)
                    self._demand(right, _product(*of_right, -1), scope, plain)
                case Relative(operand=operand):
                    self._demand(operand, "", scope, is_plain)
                case _:
                    pass

    def _note(self, key: _Key, unit: str) -> None:
        if key in self.stated or (key[0] is None and key[1] not in self.defined):
            return
        before = self.names.get(key)
        if (after := _joined(before, unit)) is not None and after != before:
            self.names[key] = after
            self.changed.append(key)


def units_of_calls(tree: RuleFile) -> dict[int, str]:
    """Units of calls by `Numbered.number`: ``m``, ``m²``, ``m³`` or ``°``, or empty for plain numbers.

    Calls of unknown units are left out.

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
    return {number: unit for number, unit in _followed(tree).calls.items() if unit != UNKNOWN}


def units_of_attributes(tree: RuleFile) -> dict[str, str]:
    """Units of attributes, constants and functions by name, without unknown ones and plain numbers.

    >>> from grammarlab.language.grammar import Grammar
    >>> units_of_attributes(Grammar.parse("attr height = 9 attr tilt = 3 Lot --> extrude(height) r(0, tilt, 0) A").tree)
    {'height': 'm', 'tilt': '°'}
    """
    units = _followed(tree)
    values = (node.name for node in tree.definitions if isinstance(node, Attribute | Function))
    known = ((name, units.of_key((None, name))) for name in values)
    return {name: unit for name, unit in known if unit and unit != UNKNOWN}


def _followed(tree: RuleFile) -> _Units:
    """All that follows from a file."""
    values = [node for node in tree.definitions if isinstance(node, Attribute | Function)]
    called = [node for node in tree.definitions if isinstance(node, Rule | Function)]
    parameters = {_owner(node): node.parameters for node in reversed(called)}  # of duplicates the first
    units = _Units(
        frozenset(node.name for node in values),
        {(None, node.name): unit for node in values if (unit := _stated(node.annotations))},
    )
    readers: dict[_Key, list[_Flow]] = defaultdict(list)
    pending: dict[_Flow, None] = {}
    for definition in tree.definitions:
        for flow in _flows(definition, parameters):
            read = set(flow.read())
            if len(read) <= MAX_DEPTH:  # so that following a value again costs little
                pending[flow] = None
                for key in read:
                    readers[key].append(flow)
    while pending:
        flow, _ = pending.popitem()
        units.follow(flow)
        while units.changed:
            pending.update(dict.fromkeys(readers[units.changed.pop()]))
    return units


def _flows(definition: Definition, parameters: Mapping[_Owner, tuple[str, ...]]) -> Iterator[_Flow]:
    """The values of a definition whose units may follow from their places."""
    if not isinstance(definition, Rule | Attribute | Function):
        return
    owner, variables = _owner(definition), definition.variables
    places = {variable.name: place for place, variable in reversed(list(enumerate(variables, 1)))}
    places |= {} if isinstance(definition, Attribute) else dict.fromkeys(definition.parameters, 0)
    body = definition.body if isinstance(definition, Rule) else definition.value
    for place, variable in enumerate(variables):
        yield from _parts_of(variable.value, _Scope(owner, places, place), (owner, variable.name), parameters)
    scope = _Scope(owner, places, len(variables))
    yield from _parts_of(body, scope, None if isinstance(definition, Rule) else (None, definition.name), parameters)


def _parts_of(
    root: Node, scope: _Scope, key: _Key | None, parameters: Mapping[_Owner, tuple[str, ...]]
) -> Iterator[_Flow]:
    """The values of a part of a definition; `key` is the name whose value the whole part is."""
    if key is not None:
        yield from _split(root, scope, key)
    for node in walk(root):
        for size, unit in _sizes(node):
            yield from _split(size, scope, unit)
        if isinstance(node, Invoke | Call):
            kind, name = (Rule, node.name) if isinstance(node, Invoke) else (Function, node.function)
            callee = (kind, name, len(node.arguments))
            for parameter, argument in zip(parameters.get(callee, ()), node.arguments, strict=False):
                yield from _split(argument, scope, (callee, parameter))


def _split(node: Node, scope: _Scope, source: _Key | str) -> Iterator[_Flow]:
    """A flow for each part of a value that has its unit, so that each depends on few names."""
    for leaf, is_plain in _of_same_unit(node, is_plain=False):
        yield _Flow(leaf, scope, source, is_plain)


def _of_same_unit(node: Node, is_plain: bool) -> Iterator[tuple[Expression, bool]]:
    """Parts of a value that have its unit, each with whether numbers in it are plain ones."""
    stack = [(node, is_plain)]
    while stack:
        current, plain = stack.pop()
        match current:
            case Unary(operand=operand) | Floating(operand=operand):
                stack.append((operand, plain))
            case Binary(operator="+" | "-"):
                terms = list(_terms(current))
                plain = plain or any(isinstance(term, Name) and term.identifier in _MEASURED for term in terms)
                stack += ((term, plain) for term in terms)
            case Case() | Stochastic():
                stack += ((leaf, plain) for leaf in alternatives(current))
            case Call(function=name, arguments=arguments):
                yield current, plain
                stack += ((argument, plain) for argument in arguments if name in _SAME)
            case Name() | Binary() | Relative():
                yield current, plain
            case _:
                pass


def _terms(node: Expression) -> Iterator[Expression]:
    """The operands of nested sums."""
    stack = [node]
    while stack:
        match stack.pop():
            case Binary(operator="+" | "-", left=left, right=right):
                stack += (left, right)
            case term:
                yield term


def unit_of_result(operation: str, units: Sequence[str | None]) -> str | None:
    """Unit of the result of an operation of a formula; None for a number of the text, which is of any unit.

    Args:
        operation: name or sign of the operation.
        units: units of its operands; empty for plain numbers as those of things, `UNKNOWN` for unknown ones, None for
            numbers of the text.

    >>> unit_of_result("*", ["m", "m"]), unit_of_result("+", ["m", None]), unit_of_result("+", ["m", "°"])
    ('m²', 'm', '?')
    >>> unit_of_result("*", ["m", ""]), unit_of_result("*", ["m", "?"])
    ('m', '?')
    """
    if operation == "choose":
        operation, units = "min", [*units[1::2], units[-1]]
    given = [unit for unit in units if unit is not None]
    if not given:
        return None
    if operation in _SUMS:
        return given[0] if len(set(given)) == 1 else UNKNOWN
    if operation in ("*", "/"):
        first, second = (unit or "" for unit in units)
        return _product(first, second, -1 if operation == "/" else 1)
    return UNKNOWN if operation in _CURVES and any(given) else ""


def _owner(definition: Attribute | Function | Rule) -> _Owner:
    parameters = () if isinstance(definition, Attribute) else definition.parameters
    return (type(definition), definition.name, len(parameters))


def _joined(first: str | None, second: str | None) -> str | None:
    """Unit of what has two units, of which None says nothing."""
    if first is None or second is None:
        return second if first is None else first
    return first if first == second else UNKNOWN


def _product(first: str | None, second: str | None, sign: int) -> str | None:
    """Unit of a product, or with a sign of -1 of a quotient; None if nothing is known of one of them so far."""
    if first is None or second is None:
        return None
    if UNKNOWN in (first, second):
        return UNKNOWN
    if not second or (sign > 0 and not first):
        return first or second
    if first == second and sign < 0:
        return ""
    if not {first, second} <= _POWERS.keys():
        return UNKNOWN
    return _UNITS.get(_POWERS[first] + sign * _POWERS[second], UNKNOWN)


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
        yield from ((value, METRES) for value in values[1 : 1 + _OVERHANGS.get(node.name, 0)])
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
