"""Safe expression language over the features of a model; docs/evaluation/file.md describes it.

``{pattern}`` is the count of a pattern in the derivation tree, ``$name`` the mean of the draws of a random
expression. Everything else is arithmetic, comparisons, and/or/not, a few functions, and names of definitions.
True is 1 and false is 0; any number except 0 is true. ``a % b`` is the remainder of a division, with the sign of b, as
in Python. A result that is not finite (a division by zero, the logarithm of -1, an overflow) is 0.

An expression is a list of steps over columns, each step an operation on earlier ones, so that each step is evaluated
once and without recursion, for any nesting of the text.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from difflib import get_close_matches
from functools import cache, reduce
from typing import Any

import numpy as np
from lark import Lark, Token, Transformer_NonRecursive, UnexpectedCharacters, UnexpectedInput, v_args
from lark.exceptions import VisitError

from grammarlab.arrays import Floats
from grammarlab.errors import UsageError
from grammarlab.features.patterns import pattern_text
from grammarlab.features.patterns.operations import FUNCTIONS, apply, evaluate, takes
from grammarlab.features.patterns.pattern import (
    Apply,
    Atom,
    ConstantTerm,
    Draw,
    Formula,
    Measure,
    Step,
    Threshold,
    step_text,
)

MAX_CHARACTERS = 20_000
"""Largest number of characters of an expression."""

MAX_STEPS = 4_000
"""Largest number of steps of one expression, including those of its definitions."""

MAX_FEATURES = 500
"""Largest number of different patterns, thresholds and draws that one expression reads."""


@dataclass(frozen=True, slots=True)
class Expression:
    """A number for every model, as a function of its features."""

    text: str = field(compare=False)
    """Original text of the expression."""
    steps: tuple[Step, ...] = field(repr=False)
    """Steps; the last one is the result."""
    features: tuple[Atom, ...]
    """Features that the expression reads, each once: the columns that `evaluate` expects."""

    @classmethod
    def parse(cls, text: str, definitions: Mapping[str, Expression] | None = None) -> Expression:
        """Parse an expression.

        Args:
            text: the expression.
            definitions: expressions by name.

        Raises:
            UsageError: If the text is not an expression; it names the expected text and its place.

        >>> Expression.parse("2 * small", {"small": Expression.parse("{Block:0} < 3")}).features
        (Pattern(symbol='Block', parameters=None, branch=(0,), below=()),)
        """
        if len(text) > MAX_CHARACTERS:
            raise UsageError(
                f"the expression has {len(text):,} characters: expected at most {MAX_CHARACTERS:,}; "
                "give names to its parts"
            )
        try:
            tree = _parser().parse(text)
        except UnexpectedInput as error:
            raise UsageError(_explain(error, text)) from None
        program = _Program()
        try:
            root = _StepBuilder(text, program, definitions or {}).transform(tree)
        except VisitError as error:
            raise error.orig_exc from None
        formula = Formula.of_steps(program.steps[: root + 1])
        features = formula.features
        if len(features) > MAX_FEATURES:
            raise UsageError(
                f"the expression reads {len(features)} different features: expected at most {MAX_FEATURES}"
            )
        return cls(text, formula.steps, features)

    @classmethod
    def of(cls, formula: Formula) -> Expression:
        """A formula as an expression."""
        return cls(str(formula), formula.steps, formula.features)

    @property
    def formula(self) -> Formula:
        """The function alone, as a feature.

        >>> formula = Expression.parse("2 * {Block} > $height").formula
        >>> Expression.parse(str(formula)).formula == formula
        True
        """
        return Formula(self.steps)

    def evaluate(self, values: Floats) -> Floats:
        """The number for every model.

        Args:
            values: [models, F] the values of `features`, in their order.

        Returns:
            [models], finite.
        """
        if values.ndim != 2 or values.shape[1] != len(self.features):
            raise UsageError(f"expected {len(self.features)} columns, one per feature, found shape {values.shape}")
        columns = {feature: values[:, i].astype(np.float64) for i, feature in enumerate(self.features)}
        return evaluate(self.steps, columns, len(values))


def plain_text(expression: Expression) -> str:
    """A text of an expression in which the parts stand instead of their names.

    Raises:
        UsageError: If it is longer than an expression may be.

    >>> high = Expression.parse("$height > 3")
    >>> plain_text(Expression.parse("100 * high", {"high": high}))
    '(100 * (not ($height < 3.0000000000000004)))'
    """
    texts: list[str] = []
    for step in expression.steps:
        text = step_text(step, expression.steps, texts)
        if len(text) > MAX_CHARACTERS:
            raise UsageError(
                f"the expression has more than {MAX_CHARACTERS:,} characters with the definitions that it uses written "
                "out; use simpler ones"
            )
        texts.append(text)
    return texts[-1]


RESERVED = frozenset({*FUNCTIONS, "and", "or", "not"})
"""Names that a definition cannot have."""


class _Program:
    """Steps without duplicates."""

    def __init__(self) -> None:
        self.steps: list[Step] = []
        self._numbers: dict[Step, int] = {}

    def add(self, step: Step) -> int:
        if step not in self._numbers:
            if len(self.steps) >= MAX_STEPS:
                raise UsageError(
                    f"the expression takes more than {MAX_STEPS:,} steps, those of its definitions included"
                )
            self._numbers[step] = len(self.steps)
            self.steps.append(step)
        return self._numbers[step]

    def apply(self, operation: str, *operands: int) -> int:
        """An operation; evaluated immediately if all operands are constants."""
        steps = [self.steps[i] for i in operands]
        constants = [np.array([step.value]) for step in steps if isinstance(step, ConstantTerm)]
        if len(constants) == len(steps):
            return self.add(ConstantTerm(float(apply(operation, constants)[0])))
        return self.add(Apply(operation, operands))

    def include(self, expression: Expression) -> int:
        """The result of another expression."""
        number: list[int] = []
        for step in expression.steps:
            moved = Apply(step.operation, tuple(number[i] for i in step.operands)) if isinstance(step, Apply) else step
            number.append(self.add(moved))
        return number[-1]

    def compare(self, first: int, sign: str, second: int) -> int:
        """A comparison; that of a draw with a constant becomes a threshold, so that it has finitely many states."""
        match self.steps[first], self.steps[second]:
            case ConstantTerm(), Measure(Draw(_, None)) if sign in _MIRRORED:
                return self.compare(second, _MIRRORED[sign], first)
            case Measure(Draw(site, None)), ConstantTerm(bound) if sign in _MIRRORED:
                bound = bound if sign in {"<", ">="} else float(np.nextafter(bound, np.inf))
                below = self.apply(">", self.add(Measure(Threshold(site, bound))), self.add(ConstantTerm(0.0)))
                return below if sign in {"<", "<="} else self.apply("not", below)
        return self.apply(sign, first, second)


_MIRRORED = {"<": ">", "<=": ">=", ">": "<", ">=": "<="}


# From text to steps --------------------------------------------------------------------------------------------------


@cache
def _parser() -> Lark:
    return Lark.open("expression.lark", rel_to=__file__, parser="lalr")


@v_args(inline=True)
class _StepBuilder(Transformer_NonRecursive):
    """Transforms every node of the syntax tree to the number of a step."""

    def __init__(self, text: str, program: _Program, definitions: Mapping[str, Expression]) -> None:
        super().__init__()
        self._text = text
        self._program = program
        self._definitions = definitions

    def number(self, token: Token) -> int:
        value = float(token)
        if not np.isfinite(value):
            raise self._wrong(token, f"{token:.40} is too large for a number")
        return self._program.add(ConstantTerm(value))

    def pattern(self, token: Token) -> int:
        try:
            parsed = pattern_text.parse(token[1:-1])
        except UsageError as error:
            raise UsageError(f"in the pattern {token}: {error}") from None
        return self._program.add(Measure(parsed))

    def draw(self, token: Token) -> int:
        site, _, branch = token[1:].partition(":")
        return self._program.add(Measure(Draw(site, int(branch) if branch else None)))

    def name(self, token: Token) -> int:
        if token in FUNCTIONS:
            raise self._wrong(token, f"{token} is a function: expected {FUNCTIONS[token]}")
        if token not in self._definitions:
            names = [*self._definitions, *FUNCTIONS]
            raise self._wrong(token, f"unknown name {str(token)!r}{_nearest(token, names)}")
        return self._program.include(self._definitions[token])

    def call(self, token: Token, *operands: int) -> int:
        if token not in FUNCTIONS:
            raise self._wrong(token, f"{str(token)!r} is not a function; expected one of {', '.join(FUNCTIONS)}")
        if not takes(str(token), len(operands)):
            raise self._wrong(token, f"expected {FUNCTIONS[token]}, found {len(operands)} values")
        return self._program.apply(str(token), *operands)

    def binary(self, first: int, sign: Token, second: int) -> int:
        return self._program.apply(str(sign), first, second)

    def sign(self, sign: Token, operand: int) -> int:
        return operand if sign == "+" else self._program.apply("-", self._program.add(ConstantTerm(0.0)), operand)

    def comparison(self, first: int, *rest: Token | int) -> int:
        chain = [first, *rest]
        links = [self._program.compare(a, str(sign), b) for a, sign, b in _links(chain)]
        return reduce(lambda a, b: self._program.apply("and", a, b), links)

    def and_(self, first: int, second: int) -> int:
        return self._program.apply("and", first, second)

    def or_(self, first: int, second: int) -> int:
        return self._program.apply("or", first, second)

    def not_(self, operand: int) -> int:
        return self._program.apply("not", operand)

    def _wrong(self, token: Token, message: str) -> UsageError:
        return UsageError(f"{message}\n{_underlined(self._text, token.start_pos or 0, len(token))}")


def _links(chain: list[Any]) -> Iterator[tuple[int, Token, int]]:
    """``a < b < c`` as ``a < b`` and ``b < c``."""
    yield from zip(chain[:-2:2], chain[1::2], chain[2::2], strict=True)


# What is wrong with a text -------------------------------------------------------------------------------------------

_MISTAKES = {
    "=": "to compare, write ==",
    "&": "write and",
    "|": "write or",
    "!": "write not; for unequal, !=",
    "^": "there are no powers; write x * x, or exp(y * log(x))",
    "{": "a pattern ends with } and has no other brace",
    "}": "a pattern begins with {",
    "$": "after $ comes the name of an attribute",
    "[": "conditions of a pattern are inside its braces",
    '"': "texts have no place here; attributes are $name, definitions plain names",
    "'": "texts have no place here; attributes are $name, definitions plain names",
}


def _explain(error: UnexpectedInput, text: str) -> str:
    """Message with the expected text, the found text, its place and a hint."""
    accepted = getattr(error, "accepts", None) or getattr(error, "expected", None) or getattr(error, "allowed", None)
    expects_value = "NUMBER" in (accepted or ())
    expected = "a value: a number, a {pattern}, a $draw, a name or a parenthesis"
    if not expects_value:
        expected = "an operator such as +, < or and, a closing parenthesis, or the end"
    token = getattr(error, "token", None)
    at_end = (token is not None and token.type == "$END") or not isinstance(error.pos_in_stream, int)
    start = len(text) if at_end else int(error.pos_in_stream or 0)
    description = "the end" if at_end else repr(str(token)) if token is not None else repr(text[start : start + 1])
    length = len(token) if token is not None and not at_end else 1
    hint = _MISTAKES.get(text[start : start + 1], "") if isinstance(error, UnexpectedCharacters) else ""
    if not text.strip():
        return "expected an expression, found nothing"
    return f"expected {expected}; found {description}\n{_underlined(text, start, length)}" + (
        f"\n  hint: {hint}" if hint else ""
    )


def _underlined(text: str, start: int, length: int) -> str:
    """The line of a place in the text, with carets below the place."""
    before = text[:start]
    line_start = before.rfind("\n") + 1
    line = text[line_start:].split("\n", 1)[0]
    column = start - line_start
    # A window of the line, so that long lines stay readable.
    low = max(0, column - 60)
    excerpt = "".join(c if c.isprintable() else " " for c in line[low : low + 110])
    return f"  {excerpt}\n  {' ' * (column - low)}{'^' * max(1, min(length, len(excerpt) - (column - low)))}"


def _nearest(name: str, names: list[str]) -> str:
    near = get_close_matches(name, names, n=3, cutoff=0.6)
    return f"; did you mean {' or '.join(near)}?" if near else f"; known names: {', '.join(names)}"
