"""Formulas in words, with the names that a table gives to what they read.

>>> from grammarlab.features.expression import Expression
>>> first, second = ("which({Lot > Tower@0:0}, {Lot > Tower@0:1})", "which({Lot > Tower@1:0}, {Lot > Tower@1:1})")
>>> formula_words(Expression.parse(f"equal({first}, {second})").formula, {})
'Lot > Tower@0 and Lot > Tower@1 alike'
>>> formula_words(Expression.parse("({Floor} * $storey + $plinth) / $front").formula, {Pattern("Floor"): "floors"})
'(floors · storey + plinth) over front'
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

from grammarlab.features.patterns.pattern import Apply, ConstantTerm, Feature, Formula, Measure, Pattern, Step

_MAX_LISTED = 4
"""Largest number of elements of a sequence that are all named."""
_SIGNS: Mapping[str, str] = {
    "+": " + ",
    "-": " − ",
    "*": " · ",
    "/": " over ",
    "<": " below ",
    ">": " above ",
    "<=": " at most ",
    ">=": " at least ",
    "==": " equal to ",
    "!=": " not equal to ",
    "%": " modulo ",
    "and": " and ",
    "or": " or ",
}
_RELATIONS: Mapping[str, str] = {
    "equal": "{} alike",
    "unequal_neighbours": "no two neighbours alike among {}",
    "alternating": "{} alternate",
    "mirrored": "{} mirrored",
    "ascending": "{} never fall",
    "distinct": "number of kinds among {}",
    "changes": "changes along {}",
    "odd": "number unlike the most among {}",
    "min": "smallest of {}",
    "max": "largest of {}",
    "which": "first of {}",
    "choose": "choice by {}",
}
_PRODUCTS = ("*", "/", "%")


class _Words(NamedTuple):
    text: str
    operation: str = ""
    """Operation that made it, if its text needs parentheses inside others."""


def formula_words(formula: Formula, names: Mapping[Feature, str]) -> str:
    """A formula in words.

    Args:
        formula: the formula.
        names: words for features; others have their texts.
    """
    words: list[_Words] = []
    for step in formula.steps:
        words.append(_step(step, formula.steps, words, names))
    return words[-1].text


def _step(step: Step, steps: Sequence[Step], words: Sequence[_Words], names: Mapping[Feature, str]) -> _Words:
    if isinstance(step, ConstantTerm):
        return _Words(f"{step.value:.4g}")
    if isinstance(step, Measure):
        return _Words(names.get(step.feature, str(step.feature)))
    operands = [words[index] for index in step.operands]
    if step.operation == "which" and (place := _place(step, steps, names)):
        return _Words(place)
    if step.operation in _SIGNS:
        return _Words(_joined(step.operation, *operands), step.operation)
    if step.operation in _RELATIONS:
        return _Words(_RELATIONS[step.operation].format(_listed([operand.text for operand in operands])))
    return _Words(f"{step.operation} of {operands[0].text}" if step.operation != "not" else f"not {operands[0].text}")


def _joined(operation: str, first: _Words, second: _Words) -> str:
    """Two operands with a sign between them, in parentheses where the sign binds more than theirs."""

    def inside(words: _Words, is_last: bool) -> str:
        binds_less = words.operation and words.operation not in _PRODUCTS
        same = words.operation == operation and operation not in {"-", "/", "%"}
        same |= operation in {"+", "-"} and words.operation in {"+", *_PRODUCTS} and not (is_last and operation == "-")
        same |= not is_last and operation == "/" and words.operation == "*"
        needs = bool(words.operation) and not same and (binds_less or operation in {"*", "/", "%"})
        return f"({words.text})" if needs else words.text

    return f"{inside(first, False)}{_SIGNS[operation]}{inside(second, True)}"


def _place(step: Apply, steps: Sequence[Step], names: Mapping[Feature, str]) -> str:
    """The place of a choice that `which` numbers by its alternatives; empty if the operands are no alternatives."""
    groups = [_added(steps[index], steps) for index in step.operands]
    if len({len(group) for group in groups}) != 1 or not all(groups):
        return ""
    places: list[str] = []
    for alternatives in zip(*groups, strict=True):
        if len({str(_without_branch(pattern)) for pattern in alternatives}) != 1:
            return ""
        named = next((names[pattern] for pattern in alternatives if pattern in names), "")
        place, arrow, _ = named.rpartition(" → ")
        places.append(place if arrow else str(_without_branch(alternatives[0])))
    return " or ".join(dict.fromkeys(places))


def _added(step: Step, steps: Sequence[Step]) -> list[Pattern]:
    """Patterns that a step adds up; empty if it does anything else."""
    if isinstance(step, Apply) and step.operation == "+":
        first, second = (_added(steps[index], steps) for index in step.operands)
        return [*first, *second] if first and second else []
    return [step.feature] if isinstance(step, Measure) and isinstance(step.feature, Pattern) else []


def _without_branch(pattern: Pattern) -> Pattern:
    """A pattern without the branch of its lowest node."""
    if not pattern.below:
        return replace(pattern, branch=None)
    *others, last = pattern.below
    run = (*last.run[:-1], _without_branch(last.run[-1]))
    return replace(pattern, below=(*others, replace(last, run=run)))


def _listed(texts: Sequence[str]) -> str:
    if len(texts) > _MAX_LISTED:
        return f"{texts[0]} to {texts[-1]} ({len(texts)})"
    return " and ".join([", ".join(texts[:-1]), texts[-1]] if len(texts) > 1 else texts)
