"""Parser of template text; errors have line, column and caret.

Expressions are linear: a constant and a coefficient for each parameter.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import cast

import numpy as np
from lark import Lark, Token, Tree, UnexpectedInput
from scipy.optimize import linprog

from grammarlab.arrays import Floats
from grammarlab.errors import Finding, LanguageError, Location
from grammarlab.matching.template import Template

Complain = Callable[[str, str, Token | Tree], LanguageError]
"""Function of a code, a message and a part of the tree: the error to raise."""
MOST_CHARACTERS = 1_000_000
"""Largest number of characters of a text."""
MOST_TEMPLATES, MOST_WIRES, MOST_PARAMETERS, MOST_COUNT = 1_000, 200, 12, 20
"""Largest numbers of templates of a text, of wires and parameters of a template, and largest count."""
_MAX_VALUE = 1e6
"""Largest value of an expression."""
_MAX_REPEATS = 2_000
"""Largest number of repeats of a template, including nested ones."""


@dataclass(frozen=True, slots=True)
class NameScope:
    """Known names."""

    names: tuple[str, ...]
    """[D] parameters."""
    values: Mapping[str, int]
    """Values of counts and of counters of repeats."""
    inner: bool = False
    """Whether this is inside a repeat."""


def parse_templates(text: str, file: str = "<text>") -> tuple[Template, ...]:
    """The templates of a text, one for each value of each count.

    Raises:
        LanguageError: If the text does not have the format, or has unknown names, products of parameters, templates
            without wires or parameters, or constraints that contradict each other; with the position of the mistake.
    """
    if len(text) > MOST_CHARACTERS:
        raise _error("too-long", f"expected at most {MOST_CHARACTERS:,} characters", Location(file=file), text)
    try:
        return _templates(_parser().parse(text), text, file)
    except UnexpectedInput as error:
        token = getattr(error, "token", None)
        message = f"unexpected {str(token)!r}" if token else "unexpected character or end of the text"
        expected = sorted(
            getattr(error, "expected", None) or getattr(error, "accepts", None) or getattr(error, "allowed", None) or ()
        )
        where = Location(max(error.line, 1), max(error.column, 1), max(1, len(str(token or "x"))), file)
        hint = f"expected one of: {', '.join(name.lower() for name in expected[:12])}" if expected else ""
        raise _error("syntax", message, where, text, hint) from error
    except RecursionError as error:
        raise _error("too-deep", "expressions are nested too deep", Location(file=file), text) from error


def _error(code: str, message: str, where: Location, text: str, hint: str = "") -> LanguageError:
    return LanguageError((Finding("error", code, message, where, hint),), text)


def _templates(tree: Tree, text: str, file: str) -> tuple[Template, ...]:
    templates: list[Template] = []
    names: set[str] = set()
    for block in cast("list[Tree]", tree.children):
        reader = _TemplateReader(text, file)
        name = cast("Token", block.children[0])
        if str(name) in names:
            raise reader.error("twice", f"the template {str(name)!r} is defined twice", name)
        names.add(str(name))
        templates += reader.read(block)
        if len(templates) > MOST_TEMPLATES:
            raise reader.error("too-many", f"expected at most {MOST_TEMPLATES:,} templates and counts", name)
    if not templates:
        raise _error("empty", "expected at least one template, found none", Location(file=file), text)
    return tuple(templates)


class _TemplateReader:
    """Reads one template; has the text only for messages."""

    def __init__(self, text: str, file: str) -> None:
        self.text = text
        self.file = file
        self.num_repeats = 0

    def error(self, code: str, message: str, node: Token | Tree, hint: str = "") -> LanguageError:
        """An error at a token or a part of the tree."""
        position = node if isinstance(node, Token) else node.meta
        line, column = getattr(position, "line", 1) or 1, getattr(position, "column", 1) or 1
        end = getattr(position, "end_column", column + 1) if getattr(position, "end_line", line) == line else column + 1
        return _error(code, message, Location(line, column, max(1, (end or 0) - column), self.file), self.text, hint)

    def read(self, tree: Tree) -> list[Template]:
        """The templates of one block, one for each combination of counts."""
        name, statements = cast("Token", tree.children[0]), cast("list[Tree]", tree.children[1:])
        parameters = [statement for statement in statements if statement.data == "parameter"]
        names = tuple(str(parameter.children[0]) for parameter in parameters)
        if names[:2] != ("width", "height"):
            raise self.error(
                "no-size",
                f"template {str(name)!r} needs width and height as its first two params",
                name,
                "param width 0.9 (0.3 to 3)",
            )
        if len(set(names)) < len(names) or len(names) > MOST_PARAMETERS:
            raise self.error("parameters", f"expected at most {MOST_PARAMETERS} different parameters", name)
        counts: list[tuple[str, int, int]] = []
        for statement in statements:
            if statement.data == "count":
                first, last = (
                    _whole_number(_evaluate(part, NameScope((), {}), self.error), part, self.error)
                    for part in statement.children[1:]
                )
                if not 0 <= first <= last <= MOST_COUNT:
                    raise self.error(
                        "count", f"expected an ascending range of counts from 0 to {MOST_COUNT}", statement
                    )
                counts.append((str(statement.children[0]), first, last))
                if str(statement.children[0]) in {*names, *(other for other, *_ in counts[:-1])}:
                    raise self.error(
                        "twice", f"{str(statement.children[0])!r} is a parameter or a count already", statement
                    )
        if math.prod(last - first + 1 for _, first, last in counts) > MOST_TEMPLATES:
            raise self.error("too-many", f"expected counts that make at most {MOST_TEMPLATES:,} templates", name)
        templates = []
        for values in _combinations(counts):
            self.num_repeats = 0
            templates.append(self._template(name, statements, parameters, names, values))
        return templates

    def _template(
        self,
        name: Token,
        statements: list[Tree],
        parameters: list[Tree],
        names: tuple[str, ...],
        counts: dict[str, int],
    ) -> Template:
        scope = NameScope(names, counts)
        usual, low, high = (
            np.array([self._constant(parameter.children[part], counts) for parameter in parameters])
            for part in (1, 2, 3)
        )
        wrong = ~((low > 0.0) & (low < high) & (low <= usual) & (usual <= high))
        if wrong.any():
            raise self.error(
                "range", "expected 0 < least <= usual <= largest, least < largest", parameters[int(wrong.argmax())]
            )
        wires: list[Floats] = []
        limits: list[Floats] = []
        self._run(statements, scope, wires, limits)
        if not wires:
            raise self.error("no-wires", f"template {str(name)!r} has no line or arc", name)
        if not np.abs(np.array(wires)[:, :, 1:]).any():
            raise self.error("no-parameters", f"no wire of template {str(name)!r} depends on a parameter", name)
        limited = np.array(limits).reshape(-1, 1 + len(names))
        self._check_feasible(name, limited, low, high)
        text = ",".join(f"{key}={value}" for key, value in counts.items())
        return Template(
            name=f"{name}[{text}]" if text else str(name),
            base=str(name),
            counts=tuple(counts.items()),
            parameters=names,
            usual=usual,
            low=low,
            high=high,
            wires=np.array(wires),
            limits=limited,
        )

    def _constant(self, tree: Tree, counts: dict[str, int]) -> float:
        return float(_evaluate(tree, NameScope((), counts), self.error)[0])

    def _run(self, statements: list[Tree], scope: NameScope, wires: list[Floats], limits: list[Floats]) -> None:
        for statement in statements:
            if statement.data in {"line", "arc"}:
                ends = [
                    _evaluate(part, scope, self.error) for point in statement.children[:2] for part in point.children
                ]
                bulge = (
                    _evaluate(statement.children[2], scope, self.error) if statement.data == "arc" else 0.0 * ends[0]
                )
                wires.append(np.array([*ends, bulge]))
                if len(wires) > MOST_WIRES:
                    raise self.error("too-many", f"expected at most {MOST_WIRES} wires", statement)
            elif statement.data == "limit":
                first, sign, second = statement.children
                difference = _evaluate(second, scope, self.error) - _evaluate(first, scope, self.error)
                limits.append(difference if sign == "<=" else -difference)
                if len(limits) > MOST_WIRES:
                    raise self.error("too-many", f"expected at most {MOST_WIRES} constraints", statement)
            elif statement.data == "repeat":
                self._repeat(statement, scope, wires, limits)
            elif scope.inner:
                raise self.error("inside", "parameters and counts are not allowed inside repeat", statement)

    def _repeat(self, tree: Tree, scope: NameScope, wires: list[Floats], limits: list[Floats]) -> None:
        name, first, last, *statements = tree.children
        low, high = (_whole_number(_evaluate(bound, scope, self.error), bound, self.error) for bound in (first, last))
        if str(name) in scope.names or str(name) in scope.values:
            raise self.error("twice", f"{str(name)!r} is already a parameter, a count or a repeat", name)
        self.num_repeats += max(high - low + 1, 1)
        if self.num_repeats > _MAX_REPEATS:
            raise self.error("too-many", f"expected at most {_MAX_REPEATS:,} repeats", tree)
        for value in range(low, high + 1):
            inner = NameScope(scope.names, {**scope.values, str(name): value}, inner=True)
            self._run(statements, inner, wires, limits)

    def _check_feasible(self, name: Token, limits: Floats, low: Floats, high: Floats) -> None:
        if not len(limits):
            return
        ranges = list(zip(low.tolist(), high.tolist(), strict=True))
        result = linprog(np.zeros(len(low)), A_ub=-limits[:, 1:], b_ub=limits[:, 0], bounds=ranges)
        if result.status == 2:
            raise self.error(
                "contradiction",
                f"the constraints of template {str(name)!r} contradict each other: no size satisfies all of them",
                name,
                "widen the range of a parameter, or remove a require",
            )


def _whole_number(value: Floats, node: Tree, complain: Complain) -> int:
    """The value, if it is an integer without parameters."""
    if value[1:].any() or value[0] != round(value[0]):
        raise complain("whole", "expected a whole number without parameters", node)
    return round(value[0])


def _evaluate(tree: Tree, scope: NameScope, complain: Complain) -> Floats:
    """[1 + D] constant and coefficients of an expression.

    Raises:
        LanguageError: If there are unknown names, products or quotients of parameters, divisions by 0, or huge numbers.
    """
    value = _value(tree, scope, complain)
    if not (np.abs(value) <= _MAX_VALUE).all():
        raise complain("too-large", f"expected numbers up to {_MAX_VALUE:g}", tree)
    return value


def _value(tree: Tree, scope: NameScope, complain: Complain) -> Floats:
    size = 1 + len(scope.names)
    if tree.data == "number":
        # A text may hold 1e999: not infinity, which times 0 is no number.
        return np.eye(size)[0] * min(float(str(tree.children[0])), 2.0 * _MAX_VALUE)
    if tree.data == "name":
        return _named(cast("Token", tree.children[0]), scope, complain)
    parts = [_evaluate(child, scope, complain) for child in tree.children]
    if tree.data == "negative":
        return -parts[0]
    a, b = parts
    if tree.data == "add":
        return a + b
    if tree.data == "subtract":
        return a - b
    constant = not b[1:].any()
    if tree.data == "divide":
        if not constant or b[0] == 0.0:
            raise complain("linear", "expected a divisor that is a number other than 0", tree)
        return a / b[0]
    if not constant and a[1:].any():
        raise complain("linear", "expected linear expressions: one factor of a product must be a number", tree)
    return a * b[0] if constant else b * a[0]


def _named(name: Token, scope: NameScope, complain: Complain) -> Floats:
    size = 1 + len(scope.names)
    if str(name) in scope.values:
        return np.eye(size)[0] * scope.values[str(name)]
    if str(name) in scope.names:
        return np.eye(size)[1 + scope.names.index(str(name))]
    names = ", ".join((*scope.names, *scope.values)) or "none here"
    raise complain("unknown-name", f"unknown name {str(name)!r}; expected one of {names}", name)


def _combinations(counts: list[tuple[str, int, int]]) -> list[dict[str, int]]:
    combinations: list[dict[str, int]] = [{}]
    for name, first, last in counts:
        combinations = [
            {**combination, name: value} for combination in combinations for value in range(first, last + 1)
        ]
    return combinations


@cache
def _parser() -> Lark:
    grammar = Path(__file__).with_name("templates.lark").read_text(encoding="utf-8")
    return Lark(grammar, parser="lalr", propagate_positions=True, maybe_placeholders=False)
