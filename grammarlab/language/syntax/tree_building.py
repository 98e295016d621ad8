"""Nodes of the syntax tree from the rules of the parser, and parts of definitions that are not nodes of it."""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from math import isfinite
from typing import Any, cast

from lark import Transformer

from grammarlab.errors import Finding, Location
from grammarlab.language.syntax.keywords import group_operands, span
from grammarlab.language.syntax.syntax_tree import (
    Annotation,
    Array,
    Attribute,
    Block,
    Boolean,
    Call,
    Case,
    Choice,
    Components,
    Definition,
    Expression,
    Floating,
    Function,
    Group,
    Import,
    Index,
    Inline,
    Invoke,
    Item,
    Name,
    Number,
    Override,
    Part,
    Relative,
    Rule,
    Scatter,
    Scoped,
    Sequence,
    Span,
    Stochastic,
    String,
    Style,
    Unary,
    Variable,
)
from grammarlab.language.syntax.tokens import Token

_ESCAPES = {"n": "\n", "t": "\t", '"': '"', "\\": "\\"}


class MistakeError(Exception):
    """Text that the parser's grammar accepts but CGA does not allow."""

    def __init__(self, code: str, message: str, location: Location, hint: str = "") -> None:
        super().__init__(message)
        self.finding = Finding("error", code, message, location, hint)


@dataclass(frozen=True, slots=True)
class Version:
    """The version line."""

    text: str
    location: Location


class TreeBuilder(Transformer[Any, Any]):
    """One method per rule of cga.lark, called by the parser when the rule is complete."""

    # Expressions

    def number(self, children: list[Any]) -> Number:
        (token,) = children
        value = float(token.value)
        if not isfinite(value):
            raise MistakeError("number-too-large", f"the number {token.value:.40} is too large", token.location)
        return Number(value, location=token.location)

    def string(self, children: list[Any]) -> String:
        (token,) = children
        body = token.value[1:-1]
        return String(re.sub(r"\\(.)", _unescape, body) if "\\" in body else body, location=token.location)

    def boolean(self, children: list[Any]) -> Boolean:
        return Boolean(children[0].value == "true", location=children[0].location)

    def name(self, children: list[Any]) -> Name:
        return Name(children[0].value, location=children[0].location)

    def call(self, children: list[Any]) -> Call:
        name, arguments = children
        return Call(name.value, arguments.expressions(), location=span(name.location, arguments.end))

    def parenthesis(self, children: list[Any]) -> Expression:
        return children[0]

    def prefixed(self, children: list[Any]) -> Expression:
        sign, operand = children
        location = span(sign.location, operand.location)
        if isinstance(operand, Floating):
            raise MistakeError(
                "misplaced-tilde", "expected '~' first in a size", operand.location, "write ~'0.5, not '~0.5"
            )
        if sign.value == "'":
            return Relative(operand, location=location)
        if sign.value == "~":
            return Floating(operand, location=location)
        return Unary(sign.value, operand, location=location)

    def chain(self, children: list[Any]) -> Expression:
        for operand in children[2::2]:
            if isinstance(operand, Floating):
                hint = "'~' applies to the whole size: write ~2*x"
                raise MistakeError("misplaced-tilde", "expected '~' first in a size", operand.location, hint)
        return group_operands(children[::2], [sign.value for sign in children[1::2]])

    def array(self, children: list[Any]) -> Array:
        """``children`` are the cells, the signs between them, and the closing bracket."""
        *inner, closing = children
        rows: list[list[Expression]] = [[]] if inner else []
        cell: list[Expression] = inner[:1]
        for sign, value in zip(inner[1::2], inner[2::2], strict=True):
            if sign.value == ":":
                cell.append(value)
                continue
            rows[-1].append(_span_of(cell))
            cell = [value]
            if sign.value == ";":
                rows.append([])
        if inner:
            rows[-1].append(_span_of(cell))
        start = inner[0].location if inner else closing.location
        return Array(tuple(map(tuple, rows)), location=span(start, closing.location))

    def vector(self, children: list[Any]) -> _Vector:
        *cells, closing = children
        return _Vector(Array((tuple(cells),), location=span(cells[0].location, closing.location)))

    def index(self, children: list[Any]) -> Index:
        array, brackets = children
        if isinstance(array, Index) and isinstance(array.array, Index):
            hint = "an array has rows and columns: write a[row, column]"
            raise MistakeError("bad-index", "expected at most two indices in a row", brackets.location, hint)
        if len(brackets.rows) != 1:
            raise MistakeError("bad-index", "expected [i] or [row, column]", brackets.location)
        return Index(array, brackets.rows[0], location=span(array.location, brackets.location))

    def components(self, children: list[Any]) -> Components:
        name, arguments, *parts, closing = children
        if name.value != "comp":
            hint = "only comp(f) { … } gives a value for each component"
            raise MistakeError(
                "misplaced-block", f"'{name.value}' takes no block in an expression", name.location, hint
            )
        return Components(arguments.expressions(), tuple(parts), location=span(name.location, closing.location))

    # Arguments

    def arguments(self, children: list[Any]) -> _Arguments:
        return _Arguments(tuple(children[:-1]), children[-1].location)

    def keyword(self, children: list[Any]) -> _Keyword:
        return _Keyword(*children)

    def override(self, children: list[Any]) -> Rule:
        *head, body = children
        return self.rule([self.signature(head), body])

    # Choices

    def branch(self, children: list[Any]) -> _Branch:
        return _Branch(*children)

    def otherwise(self, children: list[Any]) -> _Branch:
        return _Branch(None, None, children[0])

    def choice(self, children: list[Any]) -> Case | Stochastic:
        kind = Stochastic if children[0].mark.type == "CHANCE" else Case
        heads = tuple(branch.condition for branch in children)
        bodies = tuple(branch.body for branch in children)
        return kind(heads, bodies, location=children[0].mark.location)

    # Sequences

    def sequence(self, children: list[Any]) -> Sequence:
        if not children:
            return Sequence(())
        return Sequence(tuple(children), location=span(children[0].location, children[-1].location))

    def invoke(self, children: list[Any]) -> Invoke:
        name, *rest = children
        if not rest:
            return Invoke(name.value, location=name.location)
        location = span(name.location, rest[0].end)
        return Invoke(name.value, rest[0].expressions(), True, location=location)

    def invoke_import(self, children: list[Any]) -> Invoke:
        alias, overrides, member, *rest = children
        arguments = rest[0].expressions() if rest else ()
        return Invoke(
            alias.value + member.value,
            arguments,
            bool(rest),
            overrides.overrides(),
            location=span(alias.location, member.location),
        )

    def block(self, children: list[Any]) -> Block:
        name, *rest = children
        arguments = next((item.expressions() for item in rest if isinstance(item, _Arguments)), ())
        group, *further = [item for item in rest if isinstance(item, Group)]
        remainder = further[0] if further else None
        if remainder is not None and name.value != "splitAndSetbackPerimeter":
            hint = "an operation takes one pair of braces; start the next operation with its name"
            raise MistakeError("second-block", "expected an operation, found '{'", remainder.location, hint)
        location = span(name.location, (remainder or group).location)
        return Block(name.value, arguments, group, remainder, location=location)

    def group(self, children: list[Any]) -> Group:
        *parts, closing = children
        location = span(parts[0].location, closing.location)
        return Group(tuple(parts), closing.value == "}*", location=location)

    def part(self, children: list[Any]) -> Part:
        head, separator, body = children
        return Part(
            head,
            _located(body, head.location),
            separator.value == "=",
            separator.value == "=:",
            location=span(head.location, body.location),
        )

    def part_with_depth(self, children: list[Any]) -> Part:
        head, depth, body = children
        return Part(head, _located(body, head.location), depth=depth, location=span(head.location, body.location))

    def scoped(self, children: list[Any]) -> Scoped:
        body, closing = children
        body = _located(body, closing.location)
        return Scoped(body, location=span(body.location, closing.location))

    def scatter(self, children: list[Any]) -> Scatter:
        name, arguments, body, closing = children
        location = span(name.location, closing.location)
        return Scatter(arguments.expressions(), _located(body, name.location), location=location)

    def inline(self, children: list[Any]) -> Inline:
        mark, inner, *rest = children
        if isinstance(inner, Inline):
            raise MistakeError("bad-inline", f"expected a rule or a block after '{mark.value}'", inner.location)
        body = inner if rest else Sequence((cast(Item, inner),), location=inner.location)
        operation, _, strategy = mark.value.partition(" ")
        second = _located(rest[0], mark.location) if len(rest) == 2 else None
        if second is not None and (operation == "inline" or strategy):
            hint = "union, subtract and intersect have two operands: union { A | B }"
            subject = f"{operation}({strategy})" if strategy else operation
            raise MistakeError("bad-inline", f"expected one sequence of operations in {subject}", mark.location, hint)
        return Inline(operation, strategy, _located(body, mark.location), second, location=mark.location)

    # Definitions

    def definition(self, children: list[Any]) -> Definition | Version:
        *annotations, node = children
        if not annotations or isinstance(node, Version):
            return node
        return replace(node, annotations=tuple(annotations))

    def annotation(self, children: list[Any]) -> Annotation:
        name, *rest = children
        arguments: list[tuple[str, Expression]] = []
        for item in rest[0].items if rest else ():
            if isinstance(item, Rule):
                raise MistakeError("misplaced-rule", "expected an annotation's argument", item.location)
            keyword, value = (item.name.value, item.value) if isinstance(item, _Keyword) else ("", item)
            arguments.append((keyword, value.array if isinstance(value, _Vector) else value))
        return Annotation(name.value, tuple(arguments), location=name.location)

    def variables(self, children: list[Any]) -> _Variables:
        return _Variables(tuple(children[:-1]))

    def variable(self, children: list[Any]) -> Variable:
        name, value = children
        return Variable(name.value, value, location=name.location)

    def signature(self, children: list[Any]) -> _DefinitionHead:
        name, *rest = children
        parameters = next((item.names("parameter") for item in rest if isinstance(item, _Arguments)), None)
        variables = next((item.items for item in rest if isinstance(item, _Variables)), ())
        return _DefinitionHead(name, parameters, variables)

    def rule(self, children: list[Any]) -> Rule:
        *modifier, head, body = children
        return Rule(
            name=head.name.value,
            parameters=head.parameters or (),
            body=_located(body, head.name.location),
            variables=head.variables,
            keyword=modifier[0].value if modifier else "",
            location=head.name.location,
        )

    def function(self, children: list[Any]) -> Function:
        head, value = children
        return Function(
            name=head.name.value,
            parameters=head.parameters or (),
            value=value,
            variables=head.variables,
            location=head.name.location,
        )

    def attribute(self, children: list[Any]) -> Attribute | Function:
        mark, head, value = children
        name, parameters, variables = head.name, head.parameters, head.variables
        constant = mark.value == "const"
        if parameters is None:
            return Attribute(name.value, value, constant, variables=variables, location=name.location)
        # An attribute with parameters is a function: nothing outside can give it a value.
        return Function(
            name=name.value,
            parameters=parameters,
            value=value,
            constant=constant,
            variables=variables,
            location=name.location,
        )

    def import_(self, children: list[Any]) -> Import:
        _, alias, *rest = children
        styles = rest.pop(0).names("style") if isinstance(rest[0], _Arguments) else ()
        path = self.string([rest[0]]).value
        items = rest[1].items if len(rest) > 1 else ()
        protected = tuple(item.identifier for item in items if isinstance(item, Name))
        for item in items:
            if not isinstance(item, Name | _Keyword | Rule):
                hint = 'write import alias : "file.cga" (attribute = value)'
                raise MistakeError("bad-override", "expected 'attribute = value'", item.location, hint)
        return Import(
            alias=alias.value,
            path=path,
            arguments=tuple(
                (item.name.value, _without_braces(item.value)) for item in items if isinstance(item, _Keyword)
            ),
            styles=styles,
            protected=None if len(rest) > 1 and not items else protected,
            rules=tuple(item for item in items if isinstance(item, Rule)),
            location=alias.location,
        )

    def style(self, children: list[Any]) -> Style:
        _, name, *base = children
        return Style(name.value, base[0].value if base else "", location=name.location)

    def version(self, children: list[Any]) -> Version:
        (token,) = children
        return Version(token.value.strip('"'), token.location)


def _unescape(match: re.Match[str]) -> str:
    # An unknown escape keeps its backslash, since many file names contain backslashes.
    return _ESCAPES.get(match[1], match[0])


def _span_of(cell: list[Expression]) -> Expression:
    if len(cell) == 1:
        return cell[0]
    if len(cell) > 3:
        raise MistakeError("bad-span", "expected first : last or first : step : last", cell[3].location)
    location = span(cell[0].location, cell[-1].location)
    return Span(cell[0], cell[-1], cell[1] if len(cell) == 3 else None, location=location)


@dataclass(frozen=True, slots=True)
class _Vector:
    """``{1, 0, 0}``, allowed only in annotations."""

    array: Array

    @property
    def location(self) -> Location:
        return self.array.location


@dataclass(frozen=True, slots=True)
class _Arguments:
    """Items between parentheses: arguments, parameters or styles."""

    items: tuple[Expression | _Vector | _Keyword | Rule, ...]
    end: Location

    def expressions(self) -> tuple[Expression, ...]:
        """Arguments of a call."""
        for item in self.items:
            if isinstance(item, _Keyword):
                hint = "to compare, write '=='; a value is given by name only in annotations and imports"
                raise MistakeError("single-equals", "expected an expression, found '='", item.name.location, hint)
            if isinstance(item, Rule):
                hint = "a rule is redefined only in an import"
                raise MistakeError("misplaced-rule", "expected an expression, found a rule", item.location, hint)
            _without_braces(item)
        return cast(tuple[Expression, ...], self.items)

    def names(self, kind: str) -> tuple[str, ...]:
        """Parameters of a definition, or styles of an import."""
        names: list[str] = []
        for item in self.expressions():
            if not isinstance(item, Name) or "." in item.identifier:
                hint = "write Name(a, b): a definition has names in parentheses, a call has values"
                raise MistakeError("bad-parameter", f"expected the plain name of a {kind}", item.location, hint)
            names.append(item.identifier)
        return tuple(names)

    def overrides(self) -> tuple[Override, ...]:
        """Redefinitions of a dynamic import."""
        result: list[Override] = []
        for item in self.items:
            if isinstance(item, _Keyword):
                result.append(Attribute(item.name.value, _without_braces(item.value), location=item.name.location))
            elif isinstance(item, Rule):
                result.append(item)
            else:
                hint = "write imported(height = 20).Rule"
                raise MistakeError("bad-override", "expected 'attribute = value'", item.location, hint)
        return tuple(result)


@dataclass(frozen=True, slots=True)
class _Keyword:
    """``name = value`` between parentheses."""

    name: Token
    value: Expression | _Vector


def _without_braces(item: Expression | _Vector) -> Expression:
    """An argument in a place where braces are not allowed."""
    if isinstance(item, _Vector):
        message = "expected an expression, found '{'"
        raise MistakeError("misplaced-braces", message, item.array.location, "an array is written [1, 2, 3]")
    return item


@dataclass(frozen=True, slots=True)
class _Branch:
    """A branch of a choice; `mark` is its ``case`` or the token where its percentage begins, None for ``else``."""

    mark: Token | None
    condition: Expression | None
    body: Choice


def _located(body: Any, location: Location) -> Any:
    """The body, with a place if it is empty and has none."""
    if isinstance(body, Sequence) and not body.items:
        return replace(body, location=location)
    return body


@dataclass(frozen=True, slots=True)
class _Variables:
    items: tuple[Variable, ...]


@dataclass(frozen=True, slots=True)
class _DefinitionHead:
    """Beginning of a definition."""

    name: Token
    parameters: tuple[str, ...] | None
    """Parameters; None without parentheses."""
    variables: tuple[Variable, ...]
