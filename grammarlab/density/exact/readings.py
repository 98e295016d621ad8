"""Readings of an expression: the smallest set of capped counts that determine its value.

``{TopFinish:1} + {LegFinish:1} == 0`` needs one number, whether the sum is 0, not two counts. Sums of
counts that are only compared with constants become one capped reading each.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from math import floor
from typing import TypeAlias

from grammarlab.arrays import Floats
from grammarlab.density.exact.subtree_counts import NO_CAP, Reading
from grammarlab.features.expression import Expression
from grammarlab.features.patterns.pattern import Apply, ConstantTerm, Draw, Feature, Measure, Pattern, Step

Read: TypeAlias = "Reading | Feature"
"""A number read from a model: a sum of counts of patterns, or a feature that is not a pattern."""

_MAX_WEIGHT = 1 << 16
"""Largest integer weight of a count, so that sums fit into 64 bits."""
_COMPARISONS = frozenset({"<", "<=", ">", ">=", "==", "!="})


@dataclass(frozen=True, slots=True)
class _Sum:
    """A sum of counts and a constant."""

    terms: Mapping[Pattern, float]
    constant: float


def read(expression: Expression) -> tuple[tuple[Read, ...], Callable[[Floats], Floats]]:
    """Readings of an expression, and the expression as a function of them.

    Args:
        expression: any expression.

    Returns:
        Readings and features, and a function from their values [n, readings] to the values [n] of the expression.
    """
    sums = _sums(expression.steps)
    evaluated = _evaluated(expression.steps, sums)
    uses = _uses(expression.steps, evaluated, sums)
    reads: dict[Read, int] = {}
    steps: list[Step] = []
    index_of: dict[int, int] = {}

    def add(step: Step) -> int:
        steps.append(step)
        return len(steps) - 1

    def read_as(read: Read) -> int:
        number = reads.setdefault(read, len(reads))
        return add(Measure(Draw(f"#{number}")))

    for i in sorted(evaluated):
        step, total = expression.steps[i], sums[i]
        if total is not None and total.terms:
            cap = _cap(total, uses[i], sums)
            reading = Reading(tuple((p, int(w)) for p, w in total.terms.items()), cap)
            index_of[i] = read_as(reading)
            if total.constant:
                index_of[i] = add(Apply("+", (index_of[i], add(ConstantTerm(total.constant)))))
        elif isinstance(step, Measure):
            feature = step.feature
            index_of[i] = read_as(Reading.of(feature) if isinstance(feature, Pattern) else feature)
        elif isinstance(step, Apply):
            index_of[i] = add(Apply(step.operation, tuple(index_of[operand] for operand in step.operands)))
        else:
            index_of[i] = add(step)
    rest = Expression(expression.text, tuple(steps), tuple(Draw(f"#{number}") for number in range(len(reads))))
    return tuple(reads), rest.evaluate


def _sums(steps: tuple[Step, ...]) -> list[_Sum | None]:
    """For each step, its sum of counts, if it is a sum with positive integer weights."""
    sums: list[_Sum | None] = []
    for step in steps:
        if isinstance(step, ConstantTerm):
            sums.append(_Sum({}, step.value))
        elif isinstance(step, Measure):
            sums.append(_Sum({step.feature: 1.0}, 0.0) if isinstance(step.feature, Pattern) else None)
        else:
            sums.append(_combined(step.operation, [sums[operand] for operand in step.operands]))
    return sums


def _combined(operation: str, operands: list[_Sum | None]) -> _Sum | None:
    sums = [operand for operand in operands if operand is not None]
    if len(sums) != 2 or len(operands) != 2:
        return None
    a, b = sums
    if operation == "+":
        terms = {pattern: a.terms.get(pattern, 0.0) + b.terms.get(pattern, 0.0) for pattern in {**a.terms, **b.terms}}
        return _Sum(terms, a.constant + b.constant)
    if operation == "*" and not (a.terms and b.terms):
        factor, total = (b.constant, a) if a.terms else (a.constant, b)
        if factor > 0.0 and factor == floor(factor) <= _MAX_WEIGHT:
            return _Sum({pattern: factor * weight for pattern, weight in total.terms.items()}, factor * total.constant)
    if operation == "-" and not b.terms:
        return _Sum(a.terms, a.constant - b.constant)
    return None


def _is_read(total: _Sum | None) -> bool:
    """Whether a step becomes a reading."""
    return total is not None and bool(total.terms)


def _evaluated(steps: tuple[Step, ...], sums: list[_Sum | None]) -> set[int]:
    """The steps that are still evaluated: those from the result down to sums."""
    evaluated = {len(steps) - 1}
    for i in range(len(steps) - 1, -1, -1):
        step = steps[i]
        if i in evaluated and isinstance(step, Apply) and not _is_read(sums[i]):
            evaluated.update(step.operands)
    return evaluated


def _uses(
    steps: tuple[Step, ...], evaluated: set[int], sums: list[_Sum | None]
) -> list[list[tuple[Apply | None, int]]]:
    """For each step, the operations that use its result, with the index of the operand; None for the final result."""
    uses: list[list[tuple[Apply | None, int]]] = [[] for _ in steps]
    for i, step in enumerate(steps):
        if i in evaluated and isinstance(step, Apply) and not _is_read(sums[i]):
            for position, operand in enumerate(step.operands):
                uses[operand].append((step, position))
    uses[-1].append((None, 0))
    return uses


def _cap(total: _Sum, uses: list[tuple[Apply | None, int]], sums: list[_Sum | None]) -> int:
    """Smallest sum of counts from which on all uses of a sum have the same result."""
    bounds = [_bound(use, position, sums) for use, position in uses]
    limits = [bound for bound in bounds if bound is not None]
    if len(limits) < len(bounds):
        return NO_CAP
    return min(NO_CAP, max(1, floor(max(limits) - total.constant) + 1))


def _bound(use: Apply | None, position: int, sums: list[_Sum | None]) -> float | None:
    """Bound above which a use has the same result for all values; None if there is none."""
    if use is None:
        return None
    if use.operation in _COMPARISONS:
        compared = sums[use.operands[1 - position]]
        return compared.constant if compared is not None and not compared.terms else None
    if use.operation in {"and", "or", "not"}:
        return 0.0
    is_condition = use.operation == "choose" and position % 2 == 0 and position < len(use.operands) - 1
    return 0.0 if is_condition else None
