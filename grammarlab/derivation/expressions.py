"""Expressions compiled to functions over columns.

A compiled expression takes N shapes and returns one constant for all of them or a column [N]. Constants stay Python
scalars, so that constant parts of a rule file cost nothing. Where the last bits could differ (division, powers,
functions), scalars use the same array loops as columns.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TypeVar, cast

import numpy as np

from grammarlab.derivation import array_expressions
from grammarlab.derivation.calls.branches import Branching, CaseChoice, Leaf, RandomChoice, Rows, route
from grammarlab.derivation.calls.calls import Builtin, FunctionCall
from grammarlab.derivation.functions import BUILTINS, SHAPE_ATTRIBUTES
from grammarlab.derivation.operations import BLOCKS, OPERATIONS
from grammarlab.derivation.state.array_table import is_table
from grammarlab.derivation.state.operators import BINARY, UNARY
from grammarlab.derivation.state.shapes import NUM_LANES, SITE_LANE, Shapes, Value, join_values
from grammarlab.derivation.state.workspace import Code, Workspace
from grammarlab.errors import BudgetError, DerivationError, Location
from grammarlab.language.grammar import Grammar
from grammarlab.language.numbering import EngineWords, Numbering
from grammarlab.language.syntax.builtins import functions
from grammarlab.language.syntax.syntax_tree import (
    Array,
    Binary,
    Boolean,
    Call,
    Case,
    Choice,
    Components,
    Expression,
    Floating,
    Index,
    Name,
    Number,
    Relative,
    Span,
    Stochastic,
    String,
    Unary,
)
from grammarlab.language.syntax.syntax_tree import Sequence as Operations
from grammarlab.randomness import fold

VOCABULARY = EngineWords(
    frozenset(OPERATIONS), frozenset(BLOCKS), frozenset(name for name, builtin in BUILTINS.items() if builtin.random)
)
_Payload = TypeVar("_Payload")


def _not_compiled(shapes: Shapes, workspace: Workspace) -> Value:
    raise RuntimeError("a function was called before the grammar was compiled")


@dataclass(slots=True)
class CompiledFunction:
    """A function of the rule file.

    Its code is filled in after all functions are known, since they may call each other.
    """

    name: str
    draws: bool
    """Whether evaluating it may make a random draw."""
    code: Code = field(default=_not_compiled)


@dataclass(frozen=True, slots=True)
class Names:
    """Definitions of identifiers in one rule file."""

    attributes: frozenset[str]
    functions: Mapping[tuple[str, int], CompiledFunction]
    sites: Mapping[int, int]
    """Index of each random node among the sites of the forest, by `Numbered.number`."""
    has_arrays: bool = False
    """Whether any value may be an array."""
    called: set[str] = field(default_factory=set[str])
    """Built-in functions that compiled expressions call."""


@dataclass(frozen=True, slots=True)
class ExpressionCompiler:
    """Compiles the expressions of one definition."""

    names: Names
    parameters: tuple[str, ...] = ()
    selectors: frozenset[str] = frozenset()
    """Selectors of a block used as words in conditions; their values are in `Shapes.state`."""

    def with_selectors(self, selectors: frozenset[str]) -> ExpressionCompiler:
        """A compiler for expressions in which these words are selectors of a block."""
        return replace(self, selectors=selectors)

    def choice(self, choice: Choice) -> Code:
        """Code for a choice whose leaves are expressions."""
        if not isinstance(choice, Case | Stochastic | Operations):
            return self.expression(choice)
        branching = self.branching(choice, self._leaf)

        def evaluate(shapes: Shapes, workspace: Workspace) -> Value:
            parts = [
                (rows, leaf(chosen, workspace), chosen.num)
                for leaf, rows, chosen in route(branching, shapes, workspace)
            ]
            if not parts:
                raise DerivationError("no case applies and there is no else", choice.location, "add an else branch")
            if len(parts) == 1 and parts[0][2] == shapes.num:
                return parts[0][1]
            return _assemble(parts, shapes.num, workspace, choice.location)

        return evaluate

    def branching(
        self, choice: Choice, leaf: Callable[[Choice, tuple[int, ...]], _Payload], path: tuple[int, ...] = ()
    ) -> Branching[_Payload]:
        """A choice with its conditions compiled and its leaves made by ``leaf(choice, path)``."""
        if isinstance(choice, Case):
            return CaseChoice(
                tuple(None if c is None else self.expression(c) for c in choice.conditions),
                tuple(self.branching(b, leaf, (*path, i)) for i, b in enumerate(choice.branches)),
                choice.location,
            )
        if isinstance(choice, Stochastic):
            return RandomChoice(
                tuple(None if p is None else self.expression(p) for p in choice.percentages),
                tuple(self.branching(b, leaf, (*path, i)) for i, b in enumerate(choice.branches)),
                choice.number,
                self.names.sites[choice.number],
                choice.location,
            )
        return Leaf(leaf(choice, path))

    def expression(self, node: Expression) -> Code:
        """Code for one expression."""
        match node:
            case Number(value=value) | String(value=value) | Boolean(value=value):
                return _constant(value)
            case Name():
                return self._name(node)
            case Call():
                return self._call(node)
            case Unary(operator=operator, operand=operand) if operator in UNARY:
                return _apply_unary(operator, self._single(operator, operand), node.location)
            case Binary(operator="&&" | "||" as operator):
                return _short_circuit(operator, self.expression(node.left), self.expression(node.right), node.location)
            case Binary(operator=operator) if operator in BINARY:
                apply = _apply_to_any if self.names.has_arrays else _apply_binary
                return apply(operator, self.expression(node.left), self.expression(node.right), node.location)
            case Case() | Stochastic():
                return self.choice(node)
            case Relative() | Floating():
                return _refusal("' and ~ are allowed only in sizes, not inside an expression", node.location)
            case Array() | Span() | Index() | Components():
                return array_expressions.compiled(self, node)
            case Unary() | Binary():
                return array_expressions.cell_by_cell(self, node)

    def _single(self, operator: str, operand: Expression) -> Code:
        """Code for an operand of an operator that does not accept arrays."""
        code = self.expression(operand)
        if not self.names.has_arrays:
            return code

        def evaluate(shapes: Shapes, workspace: Workspace) -> Value:
            value = code(shapes, workspace)
            if is_table(value):
                raise DerivationError(f"{operator} expects a single value, found an array", operand.location)
            return value

        return evaluate

    def _leaf(self, choice: Choice, path: tuple[int, ...]) -> Code:
        if isinstance(choice, Case | Stochastic | Operations):
            raise DerivationError("expected an expression, found operations", choice.location)
        return self.expression(choice)

    def _name(self, node: Name) -> Code:
        name = node.identifier
        if name in self.parameters:
            index = self.parameters.index(name)
            return lambda shapes, workspace: shapes.locals[index]
        if name in self.selectors:
            return lambda shapes, workspace: shapes.state[name]
        if name in self.names.attributes:
            return lambda shapes, workspace: workspace.attribute_of(name, shapes)
        function = self.names.functions.get((name, 0))
        if function is not None:
            return self._call_function(function, (), node.number, node.location)
        if name in SHAPE_ATTRIBUTES:
            return SHAPE_ATTRIBUTES[name]
        if name in BUILTINS and BUILTINS[name].num_arguments[0] == 0:
            return self._call_builtin(BUILTINS[name], name, node, ())
        return _refusal(_unknown(name), node.location)

    def _call(self, node: Call) -> Code:
        builtin = BUILTINS.get(node.function)
        arguments = tuple(
            _constant(a.identifier) if isinstance(a, Name) and a.identifier in words else self.expression(a)
            for a, words in zip(node.arguments, _words(node, builtin), strict=True)
        )
        function = self.names.functions.get((node.function, len(arguments)))
        if function is not None:
            return self._call_function(function, arguments, node.number, node.location)
        if builtin is None:
            return _refusal(f"the function {node.function} is not supported", node.location)
        least, most = builtin.num_arguments
        if not least <= len(arguments) <= most:
            counts = str(least) if least == most else f"{least} to {most}"
            return _refusal(f"{node.function} expects {counts} arguments, found {len(arguments)}", node.location)
        return self._call_builtin(builtin, node.function, node, arguments)

    def _call_builtin(self, builtin: Builtin, name: str, node: Call | Name, arguments: Sequence[Code]) -> Code:
        location, evaluate = node.location, builtin.evaluate
        self.names.called.add(name)
        address = node.number
        site = self.names.sites.get(node.number, -1)
        refuses = self.names.has_arrays and not builtin.takes_arrays

        def call(shapes: Shapes, workspace: Workspace) -> Value:
            values = tuple([argument(shapes, workspace) for argument in arguments])
            if refuses and any(is_table(value) for value in values):
                raise DerivationError(f"{name} takes no arrays", location, "take a cell of the array, as in a[0]")
            return evaluate(
                FunctionCall(
                    name=name,
                    shapes=shapes,
                    arguments=values,
                    workspace=workspace,
                    address=address,
                    site=site,
                    location=location,
                )
            )

        return call

    def _call_function(
        self, function: CompiledFunction, arguments: Sequence[Code], address: int, location: Location
    ) -> Code:
        word = NUM_LANES * address + SITE_LANE
        draws = function.draws

        def call(shapes: Shapes, workspace: Workspace) -> Value:
            values = tuple([argument(shapes, workspace) for argument in arguments])
            key = fold(shapes.key, word) if draws and shapes.key is not None else shapes.key
            if workspace.call_depth >= workspace.budget.calls:
                raise BudgetError(
                    f"{function.name} calls itself, directly or not, more than {workspace.budget.calls} times deep",
                    location,
                    "a recursive function needs a case that ends it",
                )
            workspace.call_depth += 1
            try:
                return function.code(shapes._replace(locals=values, key=key), workspace)
            finally:
                workspace.call_depth -= 1

        return call


def number_grammar(grammar: Grammar) -> Numbering:
    """Numbering of a grammar shared by all its forests: `Forest.symbols`, `rules`, `sites`, `Nodes.child`."""
    return Numbering.of(grammar, VOCABULARY)


def _assemble(parts: list[tuple[Rows, Value, int]], count: int, workspace: Workspace, location: Location) -> Value:
    """One value merged from the values of branches for their rows."""
    counts = [number for _, _, number in parts]
    joined = join_values([value for _, value, _ in parts], counts, workspace.strings)
    if sum(counts) != count:
        raise DerivationError("no case applies for some shapes and there is no else", location, "add an else branch")
    if not isinstance(joined, np.ndarray):
        return joined
    result = np.empty(count, dtype=joined.dtype)
    result[np.concatenate([rows for rows, _, _ in parts if rows is not None])] = joined
    return cast("Value", result)


def _constant(value: Value) -> Code:
    return lambda shapes, workspace: value


def _apply_unary(operator: str, operand: Code, location: Location) -> Code:
    apply = UNARY[operator]
    return lambda shapes, workspace: apply(operand(shapes, workspace), location)


def _short_circuit(operator: str, left: Code, right: Code, location: Location) -> Code:
    """``&&`` and ``||``: the right side is evaluated only for shapes whose left side does not decide the result."""
    settles = operator == "||"

    def evaluate(shapes: Shapes, workspace: Workspace) -> Value:
        first = _truth(left(shapes, workspace), operator, location)
        if not isinstance(first, np.ndarray):
            return first if first == settles else _truth(right(shapes, workspace), operator, location)
        open_rows = np.flatnonzero(first != settles)
        if len(open_rows) == 0:
            return first
        if len(open_rows) == len(first):
            return _truth(right(shapes, workspace), operator, location)
        result = first.copy()
        result[open_rows] = _truth(right(shapes.take(open_rows), workspace), operator, location)
        return result

    return evaluate


def _truth(value: Value, operator: str, location: Location) -> Value:
    if isinstance(value, bool) or (isinstance(value, np.ndarray) and value.dtype.kind == "b"):
        return value
    raise DerivationError(f"{operator} expects true or false on both sides", location)


def _apply_to_any(operator: str, left: Code, right: Code, location: Location) -> Code:
    """A binary operator whose sides may be arrays."""
    apply = BINARY[operator]

    def evaluate(shapes: Shapes, workspace: Workspace) -> Value:
        first, second = left(shapes, workspace), right(shapes, workspace)
        if is_table(first) or is_table(second):
            return array_expressions.binary(operator, first, second, workspace, location)
        return apply(first, second, workspace.strings, location)

    return evaluate


def _apply_binary(operator: str, left: Code, right: Code, location: Location) -> Code:
    apply = BINARY[operator]
    return lambda shapes, workspace: apply(
        left(shapes, workspace), right(shapes, workspace), workspace.strings, location
    )


def _refusal(message: str, location: Location) -> Code:
    """Code that raises an error when it is evaluated: a rule file may contain errors in unused parts."""

    def evaluate(shapes: Shapes, workspace: Workspace) -> Value:
        raise DerivationError(message, location, "`grammarlab check` lists everything that is wrong or not supported")

    return evaluate


def _unknown(name: str) -> str:
    """Error for an unknown name."""
    prefix = name.partition(".")[0]
    if prefix == name:
        return f"unknown name {name}"
    if any(attribute.startswith(f"{prefix}.") for attribute in SHAPE_ATTRIBUTES):
        return f"the shape attribute {name} is not supported"
    return f"{name} comes from an imported file that was not read"


def _words(node: Call, builtin: Builtin | None) -> list[frozenset[str]]:
    """Keywords of each argument of a call."""
    count = len(node.arguments)
    if builtin is None or not builtin.keywords:
        return [frozenset[str]()] * count
    forms = [form for form in functions()[node.function] if form.takes(count)]
    keywords = [frozenset[str]().union(*(form.parameters[i].keywords for form in forms)) for i in range(count)]
    return [words & builtin.keywords for words in keywords]
