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
from grammarlab.features.expression import Apply, ConstantTerm, Expression, Measure, Step
from grammarlab.features.patterns.pattern import Draw, Feature, Pattern

Read: TypeAlias = "Reading | Feature"
"""A number read from a model: a sum of counts of patterns, or a feature that is not a pattern."""

_MOST_WEIGHT = 1 << 16
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
    kept = _kept(expression.steps, sums)
    uses = _uses(expression.steps, kept, sums)
    reads: dict[Read, int] = {}
    steps: list[Step] = []
    place: dict[int, int] = {}

    def add(step: Step) -> int:
        steps.append(step)
        return len(steps) - 1

    def read_as(read: Read) -> int:
        number = reads.setdefault(read, len(reads))
        return add(Measure(Draw(f"#{number}")))

    for i in sorted(kept):
        step, found = expression.steps[i], sums[i]
        if found is not None and found.terms:
            cap = _cap(found, uses[i], sums)
            reading = Reading(tuple((p, int(w)) for p, w in found.terms.items()), cap)
            place[i] = read_as(reading)
            if found.constant:
                place[i] = add(Apply("+", (place[i], add(ConstantTerm(found.constant)))))
        elif isinstance(step, Measure):
            feature = step.feature
            place[i] = read_as(Reading.of(feature) if isinstance(feature, Pattern) else feature)
        elif isinstance(step, Apply):
            place[i] = add(Apply(step.operation, tuple(place[operand] for operand in step.operands)))
        else:
            place[i] = add(step)
    rest = Expression(expression.text, tuple(steps), tuple(Draw(f"#{number}") for number in range(len(reads))))
    return tuple(reads), rest.evaluate


def _sums(steps: tuple[Step, ...]) -> list[_Sum | None]:
    """For each step, its sum of counts, if it is a sum with positive integer weights."""
    found: list[_Sum | None] = []
    for step in steps:
        if isinstance(step, ConstantTerm):
            found.append(_Sum({}, step.value))
        elif isinstance(step, Measure):
            found.append(_Sum({step.feature: 1.0}, 0.0) if isinstance(step.feature, Pattern) else None)
        else:
            found.append(_combined(step.operation, [found[operand] for operand in step.operands]))
    return found


def _combined(operation: str, operands: list[_Sum | None]) -> _Sum | None:
    sums = [operand for operand in operands if operand is not None]
    if len(sums) != 2 or len(operands) != 2:
        return None
    a, b = sums
    if operation == "+":
        terms = {pattern: a.terms.get(pattern, 0.0) + b.terms.get(pattern, 0.0) for pattern in {**a.terms, **b.terms}}
        return _Sum(terms, a.constant + b.constant)
    if operation == "*" and not (a.terms and b.terms):
        factor, other = (b.constant, a) if a.terms else (a.constant, b)
        if factor > 0.0 and factor == floor(factor) <= _MOST_WEIGHT:
            return _Sum({pattern: factor * weight for pattern, weight in other.terms.items()}, factor * other.constant)
    if operation == "-" and not b.terms:
        return _Sum(a.terms, a.constant - b.constant)
    return None


def _is_read(found: _Sum | None) -> bool:
    """Whether a step becomes a reading."""
    return found is not None and bool(found.terms)


def _kept(steps: tuple[Step, ...], sums: list[_Sum | None]) -> set[int]:
    """The steps that are still evaluated: those from the result down to sums."""
    kept = {len(steps) - 1}
    for i in range(len(steps) - 1, -1, -1):
        step = steps[i]
        if i in kept and isinstance(step, Apply) and not _is_read(sums[i]):
            kept.update(step.operands)
    return kept


def _uses(steps: tuple[Step, ...], kept: set[int], sums: list[_Sum | None]) -> list[list[tuple[Apply | None, int]]]:
    """For each step, the operations that use its result, with the index of the operand; None for the final result."""
    uses: list[list[tuple[Apply | None, int]]] = [[] for _ in steps]
    for i, step in enumerate(steps):
        if i in kept and isinstance(step, Apply) and not _is_read(sums[i]):
            for place, operand in enumerate(step.operands):
                uses[operand].append((step, place))
    uses[-1].append((None, 0))
    return uses


def _cap(found: _Sum, uses: list[tuple[Apply | None, int]], sums: list[_Sum | None]) -> int:
    """Smallest sum of counts from which on all uses of a sum have the same result."""
    bounds = [_bound(use, place, sums) for use, place in uses]
    known = [bound for bound in bounds if bound is not None]
    if len(known) < len(bounds):
        return NO_CAP
    return min(NO_CAP, max(1, floor(max(known) - found.constant) + 1))


def _bound(use: Apply | None, place: int, sums: list[_Sum | None]) -> float | None:
    """Bound above which a use has the same result for all values; None if there is none."""
    if use is None:
        return None
    if use.operation in _COMPARISONS:
        other = sums[use.operands[1 - place]]
        return other.constant if other is not None and not other.terms else None
    if use.operation in {"and", "or", "not"}:
        return 0.0
    is_condition = use.operation == "choose" and place % 2 == 0 and place < len(use.operands) - 1
    return 0.0 if is_condition else None
