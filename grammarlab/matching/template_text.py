"""Parser of template text; errors have line, column and caret.

Expressions of template text: a constant and a coefficient for each parameter.
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

from grammarlab.errors import Finding, LanguageError, Location
from grammarlab.matching.elements import Floats
from grammarlab.matching.template import Template

Complain = Callable[[str, str, Token | Tree], LanguageError]
_LARGEST = 1e6


@dataclass(frozen=True, slots=True)
class NameScope:
    """Known names."""

    names: tuple[str, ...]
    """[D] parameters."""
    values: Mapping[str, int]
    """Values of counts and of counters of repeats."""
    inner: bool = False
    """Whether this is inside a repeat."""


def evaluate(tree: Tree, scope: NameScope, complain: Complain) -> Floats:
    """[1 + D] constant and coefficients of an expression.

    Raises:
        LanguageError: If there are unknown names, products or quotients of parameters, divisions by 0, or huge numbers.
    """
    value = _value(tree, scope, complain)
    if not (np.abs(value) <= _LARGEST).all():
        raise complain("too-large", f"expected numbers up to {_LARGEST:g}", tree)
    return value


def _value(tree: Tree, scope: NameScope, complain: Complain) -> Floats:
    size = 1 + len(scope.names)
    if tree.data == "number":
        # A text may hold 1e999: not infinity, which times 0 is no number.
        return np.eye(size)[0] * min(float(str(tree.children[0])), 2.0 * _LARGEST)
    if tree.data == "name":
        return _named(cast("Token", tree.children[0]), scope, complain)
    parts = [evaluate(each, scope, complain) for each in tree.children]
    if tree.data == "negative":
        return -parts[0]
    left, right = parts
    if tree.data == "add":
        return left + right
    if tree.data == "subtract":
        return left - right
    constant = not right[1:].any()
    if tree.data == "divide":
        if not constant or right[0] == 0.0:
            raise complain("linear", "expected a divisor that is a number other than 0", tree)
        return left / right[0]
    if not constant and left[1:].any():
        raise complain("linear", "expected linear expressions: one factor of a product must be a number", tree)
    return left * right[0] if constant else right * left[0]


def _named(name: Token, scope: NameScope, complain: Complain) -> Floats:
    size = 1 + len(scope.names)
    if str(name) in scope.values:
        return np.eye(size)[0] * scope.values[str(name)]
    if str(name) in scope.names:
        return np.eye(size)[1 + scope.names.index(str(name))]
    known = ", ".join((*scope.names, *scope.values)) or "none here"
    raise complain("unknown-name", f"unknown name {str(name)!r}; expected one of {known}", name)


def whole(value: Floats, place: Tree, complain: Complain) -> int:
    """The value, if it is an integer without parameters."""
    if value[1:].any() or value[0] != round(value[0]):
        raise complain("whole", "expected a whole number without parameters", place)
    return round(value[0])


MOST_CHARACTERS = 1_000_000
MOST_TEMPLATES, MOST_WIRES, MOST_PARAMETERS, MOST_COUNT = 1_000, 200, 12, 20
_MOST_REPEATS = 2_000
"""Of all repeats of a template, also those inside of each other."""


@cache
def _parser() -> Lark:
    grammar = Path(__file__).with_name("templates.lark").read_text(encoding="utf-8")
    return Lark(grammar, parser="lalr", propagate_positions=True, maybe_placeholders=False)


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
        found = getattr(error, "token", None)
        what = f"unexpected {str(found)!r}" if found else "unexpected character or end of the text"
        expected = sorted(
            getattr(error, "expected", None) or getattr(error, "accepts", None) or getattr(error, "allowed", None) or ()
        )
        where = Location(max(error.line, 1), max(error.column, 1), max(1, len(str(found or "x"))), file)
        hint = f"expected one of: {', '.join(each.lower() for each in expected[:12])}" if expected else ""
        raise _error("syntax", what, where, text, hint) from error
    except RecursionError as error:
        raise _error("too-deep", "expressions are nested too deep", Location(file=file), text) from error


def _templates(tree: Tree, text: str, file: str) -> tuple[Template, ...]:
    made: list[Template] = []
    seen: set[str] = set()
    for each in cast("list[Tree]", tree.children):
        reader = _TemplateReader(text, file)
        name = cast("Token", each.children[0])
        if str(name) in seen:
            raise reader.error("twice", f"the template {str(name)!r} is defined twice", name)
        seen.add(str(name))
        made += reader.read(each)
        if len(made) > MOST_TEMPLATES:
            raise reader.error("too-many", f"expected at most {MOST_TEMPLATES:,} templates and counts", name)
    if not made:
        raise _error("empty", "expected at least one template, found none", Location(file=file), text)
    return tuple(made)


def _error(code: str, message: str, where: Location, text: str, hint: str = "") -> LanguageError:
    return LanguageError((Finding("error", code, message, where, hint),), text)


class _TemplateReader:
    """Reads one template; has the text only for messages."""

    def __init__(self, text: str, file: str) -> None:
        self.text = text
        self.file = file
        self.num_repeats = 0

    def error(self, code: str, message: str, place: Token | Tree, hint: str = "") -> LanguageError:
        """An error at a token or a part of the tree."""
        position = place if isinstance(place, Token) else place.meta
        line, column = getattr(position, "line", 1) or 1, getattr(position, "column", 1) or 1
        end = getattr(position, "end_column", column + 1) if getattr(position, "end_line", line) == line else column + 1
        return _error(code, message, Location(line, column, max(1, (end or 0) - column), self.file), self.text, hint)

    def read(self, tree: Tree) -> list[Template]:
        """The templates of one block, one for each combination of counts."""
        name, statements = cast("Token", tree.children[0]), cast("list[Tree]", tree.children[1:])
        parameters = [each for each in statements if each.data == "parameter"]
        names = tuple(str(each.children[0]) for each in parameters)
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
        for each in statements:
            if each.data == "count":
                first, last = (
                    whole(evaluate(part, NameScope((), {}), self.error), part, self.error) for part in each.children[1:]
                )
                if not 0 <= first <= last <= MOST_COUNT:
                    raise self.error("count", f"expected an ascending range of counts from 0 to {MOST_COUNT}", each)
                counts.append((str(each.children[0]), first, last))
                if str(each.children[0]) in {*names, *(known for known, *_ in counts[:-1])}:
                    raise self.error("twice", f"{str(each.children[0])!r} is a parameter or a count already", each)
        if math.prod(last - first + 1 for _, first, last in counts) > MOST_TEMPLATES:
            raise self.error("too-many", f"expected counts that make at most {MOST_TEMPLATES:,} templates", name)
        made = []
        for values in _combinations(counts):
            self.num_repeats = 0
            made.append(self._made(name, statements, parameters, names, values))
        return made

    def _made(
        self,
        name: Token,
        statements: list[Tree],
        parameters: list[Tree],
        names: tuple[str, ...],
        counts: dict[str, int],
    ) -> Template:
        scope = NameScope(names, counts)
        usual, low, high = (
            np.array([self._constant(each.children[part], counts) for each in parameters]) for part in (1, 2, 3)
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
        return float(evaluate(tree, NameScope((), counts), self.error)[0])

    def _run(self, statements: list[Tree], scope: NameScope, wires: list[Floats], limits: list[Floats]) -> None:
        for each in statements:
            if each.data in {"line", "arc"}:
                ends = [evaluate(part, scope, self.error) for point in each.children[:2] for part in point.children]
                bulge = evaluate(each.children[2], scope, self.error) if each.data == "arc" else 0.0 * ends[0]
                wires.append(np.array([*ends, bulge]))
                if len(wires) > MOST_WIRES:
                    raise self.error("too-many", f"expected at most {MOST_WIRES} wires", each)
            elif each.data == "limit":
                left, sign, right = each.children
                difference = evaluate(right, scope, self.error) - evaluate(left, scope, self.error)
                limits.append(difference if sign == "<=" else -difference)
                if len(limits) > MOST_WIRES:
                    raise self.error("too-many", f"expected at most {MOST_WIRES} constraints", each)
            elif each.data == "repeat":
                self._repeat(each, scope, wires, limits)
            elif scope.inner:
                raise self.error("inside", "parameters and counts are not allowed inside repeat", each)

    def _repeat(self, tree: Tree, scope: NameScope, wires: list[Floats], limits: list[Floats]) -> None:
        name, first, last, *statements = tree.children
        low, high = (whole(evaluate(each, scope, self.error), each, self.error) for each in (first, last))
        if str(name) in scope.names or str(name) in scope.values:
            raise self.error("twice", f"{str(name)!r} is already a parameter, a count or a repeat", name)
        self.num_repeats += max(high - low + 1, 1)
        if self.num_repeats > _MOST_REPEATS:
            raise self.error("too-many", f"expected at most {_MOST_REPEATS:,} repeats", tree)
        for value in range(low, high + 1):
            inner = NameScope(scope.names, {**scope.values, str(name): value}, inner=True)
            self._run(statements, inner, wires, limits)

    def _check_feasible(self, name: Token, limits: Floats, low: Floats, high: Floats) -> None:
        if not len(limits):
            return
        ranges = list(zip(low.tolist(), high.tolist(), strict=True))
        found = linprog(np.zeros(len(low)), A_ub=-limits[:, 1:], b_ub=limits[:, 0], bounds=ranges)
        if found.status == 2:
            raise self.error(
                "contradiction",
                f"the constraints of template {str(name)!r} contradict each other: no size satisfies all of them",
                name,
                "widen the range of a parameter, or remove a require",
            )


def _combinations(counts: list[tuple[str, int, int]]) -> list[dict[str, int]]:
    found: list[dict[str, int]] = [{}]
    for name, first, last in counts:
        found = [{**each, name: value} for each in found for value in range(first, last + 1)]
    return found
