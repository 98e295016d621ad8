"""Expressions, functions and choices of the oracle, evaluated for one shape."""

from __future__ import annotations

import math
import operator
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np

from grammarlab.errors import DerivationError
from grammarlab.language.syntax.syntax_tree import (
    Binary,
    Boolean,
    Call,
    Case,
    Choice,
    Expression,
    Name,
    Node,
    Number,
    Stochastic,
    String,
    Unary,
    Variable,
)
from grammarlab.language.syntax.syntax_tree import Sequence as Operations
from grammarlab.randomness import fold, uniforms
from tests.oracle.functions import MEASURES, PLAIN, number_text, shape_attribute, through_array
from tests.oracle.shape import Shape, Value

if TYPE_CHECKING:
    from tests.oracle.interpreter import Model

RANDOM = {"rand", "p"}
SITE_LANE = 2


@dataclass(frozen=True)
class Scope:
    """Where an expression stands: for which shape of which model, with which parameters."""

    model: Model
    shape: Shape
    parameters: dict[str, Value] = field(default_factory=dict)


def with_variables(scope: Scope, variables: Sequence[Variable]) -> Scope:
    """The scope with the local variables of a definition, each of which may use those before it."""
    for variable in variables:
        value = evaluate(variable.value, scope)
        scope = replace(scope, parameters={**scope.parameters, variable.name: value})
    return scope


def evaluate(node: Choice, scope: Scope) -> Value:
    """The value of an expression, or of a choice between expressions."""
    match choose(node, scope)[0]:
        case Number(value=value) | String(value=value) | Boolean(value=value):
            return value
        case Name() as name:
            return _name(name, scope)
        case Call() as call:
            return _call(call, scope)
        case Unary(operator=operator, operand=operand):
            value = evaluate(operand, scope)
            return {"-": lambda: -number(value), "+": lambda: number(value), "!": lambda: not truth(value)}[operator]()
        case Binary() as binary:
            return _binary(binary, scope)
    raise DerivationError(f"the oracle cannot evaluate {node}")


def choose(node: Choice, scope: Scope) -> tuple[Operations | Expression | None, tuple[int, ...]]:
    """The leaf of a choice that applies, and which branch was taken at each level; None when no case holds."""
    path: list[int] = []
    while isinstance(node, Case | Stochastic):
        if isinstance(node, Case):
            taken = next((i for i, c in enumerate(node.conditions) if c is None or truth(evaluate(c, scope))), None)
            if taken is None:
                return None, tuple(path)
        else:
            taken = _draw_branch(node, scope)
        path.append(taken)
        node = node.branches[taken]
    return node, tuple(path)


def number(value: Value) -> float:
    if isinstance(value, str):
        raise DerivationError(f"expected a number, found the string {value!r}")
    return float(value)


def truth(value: Value) -> bool:
    if not isinstance(value, bool):
        raise DerivationError(f"expected true or false, found {value!r}")
    return value


def uniform(node: Node, scope: Scope) -> float:
    """The draw in [0, 1) that belongs to a place in the grammar, for one shape."""
    return float(uniforms(scope.shape.key, 3 * scope.model.addresses[id(node)] + SITE_LANE)[0])


def _draw_branch(node: Stochastic, scope: Scope) -> int:
    weights = [0.0 if p is None else number(evaluate(p, scope)) for p in node.percentages]
    weights = [
        max(0.0, 100.0 - sum(weights)) if p is None else w for p, w in zip(node.percentages, weights, strict=True)
    ]
    total = sum(weights)
    threshold = uniform(node, scope) * total
    cumulative = 0.0
    taken = len(weights) - 1
    for branch, weight in enumerate(weights):
        cumulative += weight
        if cumulative > threshold:
            taken = branch
            break
    scope.model.record_draw(scope.shape, node, float(taken), math.log(weights[taken] / total))
    return taken


def _name(node: Name, scope: Scope) -> Value:
    name = node.identifier
    if name in scope.parameters:
        return scope.parameters[name]
    if name in scope.shape.attributes:
        return scope.shape.attributes[name]
    if name in scope.model.attribute_definitions:
        return scope.model.attribute(name)
    if (name, 0) in scope.model.functions:
        return _apply_function(node, name, [], scope)
    if name in MEASURES:
        return MEASURES[name](scope.shape)
    value = shape_attribute(name, scope)
    if value is None:
        raise DerivationError(f"nothing is called {name}", node.location)
    return value


def _call(node: Call, scope: Scope) -> Value:
    name = node.function
    if name == "geometry.angle":
        raise DerivationError("the oracle does not know geometry.angle", node.location)
    arguments = [evaluate(argument, scope) for argument in node.arguments]
    if (name, len(arguments)) in scope.model.functions:
        return _apply_function(node, name, arguments, scope)
    if name in RANDOM:
        return _random(node, arguments, scope)
    if name in MEASURES:
        return MEASURES[name](scope.shape, *arguments)
    return PLAIN[name](*arguments)


def _apply_function(node: Call | Name, name: str, arguments: Sequence[Value], scope: Scope) -> Value:
    """A function of the grammar: its body is evaluated under a key of its own."""
    function = scope.model.functions[name, len(arguments)]
    key = fold(scope.shape.key, 3 * scope.model.addresses[id(node)] + SITE_LANE)
    inside = Scope(scope.model, replace(scope.shape, key=key), dict(zip(function.parameters, arguments, strict=True)))
    return evaluate(function.value, with_variables(inside, function.variables))


def _random(node: Call, arguments: Sequence[Value], scope: Scope) -> Value:
    draw = uniform(node, scope)
    bounds = [number(argument) for argument in arguments]
    if node.function == "p":
        chance = min(max(bounds[0], 0.0), 1.0)
        outcome = draw < chance
        scope.model.record_draw(scope.shape, node, float(outcome), math.log(chance if outcome else 1.0 - chance))
        return outcome
    low = bounds[0] if len(bounds) == 2 else 0.0
    high = bounds[-1] if bounds else 1.0
    value = low + (high - low) * draw
    density = -math.log(abs(high - low)) if high != low else 0.0
    scope.model.record_draw(scope.shape, node, value, density)
    return value


def _binary(node: Binary, scope: Scope) -> Value:
    left = evaluate(node.left, scope)
    if node.operator in {"&&", "||"}:
        settles = node.operator == "||"
        return settles if truth(left) == settles else truth(evaluate(node.right, scope))
    right = evaluate(node.right, scope)
    match node.operator:
        case "==":
            return left == right
        case "!=":
            return left != right
        case "+" if isinstance(left, str) or isinstance(right, str):
            return number_text(left) + number_text(right)
    if node.operator not in ARITHMETIC:
        raise DerivationError(f"the oracle does not know the operator {node.operator}", node.location)
    return ARITHMETIC[node.operator](number(left), number(right))


ARITHMETIC: dict[str, Callable[[float, float], Value]] = {
    "<": operator.lt,
    "<=": operator.le,
    ">": operator.gt,
    ">=": operator.ge,
    "+": operator.add,
    "-": operator.sub,
    "*": operator.mul,
    "/": lambda a, b: through_array(np.divide, a, b),
    "%": lambda a, b: through_array(np.fmod, a, b),
}
