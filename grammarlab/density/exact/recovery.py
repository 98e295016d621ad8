"""Origins of the rules of a learned rule file, recovered from its text and that of the original.

A learned file repeats the rules of the original: split symbols have its names with suffixes, the alternatives are
equal except for these names, and percentages differ. So each alternative is matched with equal ones of the
original; if exactly one matches, it is the origin.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields
from itertools import pairwise
from typing import Any, TypeAlias

import numpy as np

from grammarlab.arrays import ROUNDING, Floats
from grammarlab.density.exact.attributes import AttributePart, AttributeParts, attribute_parts, drawn_range, leaf_at
from grammarlab.density.exact.grammar_text import Mixed, Origin
from grammarlab.density.exact.learned import LearnedGrammar
from grammarlab.density.exact.splitting import PLAIN
from grammarlab.density.grammar_skeleton import TreeGrammar
from grammarlab.errors import InexactError
from grammarlab.features.patterns.pattern import Threshold
from grammarlab.language.checking.percentages import probabilities
from grammarlab.language.grammar import Grammar
from grammarlab.language.numbering import Branch, SymbolKey
from grammarlab.language.syntax.syntax_tree import Binary, Case, Choice, Invoke, Name, Node, Number, Stochastic
from grammarlab.language.syntax.syntax_tree import Sequence as Items

Renamed: TypeAlias = dict[SymbolKey, SymbolKey]
"""Original symbols, by symbols of the learned grammar."""


class _ForeignError(Exception):
    """The grammar was not made from the original."""


@dataclass(frozen=True, slots=True)
class _End:
    """An alternative of a rule."""

    branch: Branch
    conditions: tuple[tuple[object, int], ...]
    """The lists of ``case`` conditions that lead to it, with the index in each."""
    text: Node


def recovered(original: Grammar, text: str) -> LearnedGrammar | None:
    """A learned grammar with its origins; None if it was not made from the original, or this is ambiguous.

    Args:
        original: the possible original grammar.
        text: the possibly learned rule file.
    """
    if text == original.text:
        start = TreeGrammar.of(original).start
        return LearnedGrammar(
            text=text,
            original=original,
            method="recovered",
            base="grammar",
            origins={},
            start=start,
            components=(Mixed(1.0, (), PLAIN),),
            attributes=(),
            mean_preference=1.0,
        )
    try:
        return _recovered(original, Grammar.parse(text, original.file))
    except (_ForeignError, InexactError):
        return None


def _recovered(original: Grammar, learned: Grammar) -> LearnedGrammar:
    mixture = _mixture(original, learned)
    if learned.functions != original.functions or learned.imports != original.imports:
        raise _ForeignError
    before, after = TreeGrammar.of(original), TreeGrammar.of(learned)
    origins, branching = _origins(original, learned, before.start, after.start, mixture)
    weights = _component_weights(learned, mixture)
    parts, drawn = [], []
    for name, attribute in original.attributes.items():
        if learned.attributes[name] != attribute:
            new_parts, values = _attribute(original, learned, name, mixture, len(weights))
            parts.append(new_parts)
            drawn.append(values)
    components = tuple(
        Mixed(weight, tuple(values[i] for values in drawn), i if branching else PLAIN)
        for i, weight in enumerate(weights)
    )
    return LearnedGrammar(
        text=learned.text,
        original=original,
        method="recovered",
        base="grammar",
        origins=origins,
        start=after.start,
        components=components,
        attributes=tuple(parts),
        mean_preference=1.0,
    )


# The mixture


def _mixture(original: Grammar, learned: Grammar) -> str:
    """The attribute with the number of a model's component; empty without one."""
    new = [name for name in learned.attributes if name not in original.attributes]
    if len(new) > 1 or any(name not in learned.attributes for name in original.attributes):
        raise _ForeignError
    return new[0] if new else ""


def _component_weights(learned: Grammar, mixture: str) -> list[float]:
    if not mixture:
        return [1.0]
    value = learned.attributes[mixture].value
    chances = probabilities(value) if isinstance(value, Stochastic) else None
    if chances is None or not isinstance(value, Stochastic):
        raise _ForeignError
    numbers = [branch.value if isinstance(branch, Number) else 0.0 for branch in value.branches]
    if sorted(numbers) != [float(i + 1) for i in range(len(numbers))]:
        raise _ForeignError
    return [chance for _, chance in sorted(zip(numbers, chances, strict=True))]


def _by_component(choice: Choice, mixture: str, number: int) -> list[Choice] | None:
    """The branches of ``case component == 1 : ... else : ...``; None for every other choice."""
    if not mixture or not isinstance(choice, Case) or len(choice.branches) != number:
        return None
    conditions = [Binary("==", Name(mixture), Number(float(i + 1))) for i in range(number - 1)]
    return list(choice.branches) if list(choice.conditions) == [*conditions, None] else None


# Rules


def _origins(
    original: Grammar, learned: Grammar, start: SymbolKey, learned_start: SymbolKey, mixture: str
) -> tuple[dict[SymbolKey, Origin], bool]:
    """Origins of rules, and whether the start rule has a branch for each component."""
    renamed: Renamed = {learned_start: start}
    waiting = [learned_start]
    origins: dict[SymbolKey, Origin] = {}
    branching = False
    number = len(_component_weights(learned, mixture))
    while waiting:
        key = waiting.pop()
        rule, old = learned.rules[key], original.rules[renamed[key]]
        if (rule.parameters, rule.variables) != (old.parameters, old.variables):
            raise _ForeignError
        ends = list(_ends(old.body, (), ()))
        mixed = _by_component(rule.body, mixture, number) if key == learned_start else None
        branching = branching or mixed is not None
        bodies = [(rule.body, ())] if mixed is None else [(body, (i,)) for i, body in enumerate(mixed)]
        branches: dict[Branch, Branch | None] = {}
        for body, path in bodies:
            for end in _ends(body, path, ()):
                branches[end.branch] = _origin(end, ends, renamed, original, learned, waiting)
        origins[key] = Origin(renamed[key], branches)
    return origins, branching


def _ends(choice: Choice, path: Branch, conditions: tuple[tuple[object, int], ...]) -> Iterator[_End]:
    if isinstance(choice, Case):
        # An added else makes nothing, and is for shapes for which no case holds.
        tests = tuple(condition for condition in choice.conditions if condition is not None)
        for i, branch in enumerate(choice.branches):
            yield from _ends(branch, (*path, i), (*conditions, (tests, i)))
    elif isinstance(choice, Stochastic):
        for i, branch in enumerate(choice.branches):
            yield from _ends(branch, (*path, i), conditions)
    else:
        yield _End(path, conditions, choice)


def _origin(
    end: _End,
    ends: Sequence[_End],
    renamed: Renamed,
    original: Grammar,
    learned: Grammar,
    waiting: list[SymbolKey],
) -> Branch | None:
    """The matching alternative of the original rule."""
    matches: list[tuple[Branch, Renamed]] = []
    for other in ends:
        names: Renamed = {}
        if other.conditions == end.conditions and _same(other.text, end.text, names):
            names = {name: old for name, old in names.items() if name in learned.rules or old in original.rules}
            consistent = all(renamed.get(name, old) == old for name, old in names.items())
            if consistent and all(name in learned.rules and old in original.rules for name, old in names.items()):
                matches.append((other.branch, names))
    if not matches and end.text == Items(()) and end.conditions:
        return None
    if len(matches) != 1:
        raise _ForeignError
    branch, names = matches[0]
    waiting += [name for name in names if name not in renamed]
    renamed.update(names)
    return branch


def _same(old: Any, new: Any, names: Renamed) -> bool:
    """Whether two texts are equal except for suffixes of names; records the names."""
    if type(old) is not type(new):
        return False
    if isinstance(old, tuple):
        return len(old) == len(new) and all(_same(a, b, names) for a, b in zip(old, new, strict=True))
    if not isinstance(old, Node):
        return old == new
    if isinstance(old, Invoke):
        key, origin = (new.name, len(new.arguments)), (old.name, len(old.arguments))
        if new.name != old.name and not new.name.startswith(f"{old.name}_"):
            return False
        if names.setdefault(key, origin) != origin:
            return False
        return _same(old.arguments, new.arguments, names) and old.overrides == new.overrides
    compared = [field.name for field in fields(old) if field.compare]
    return all(_same(getattr(old, name), getattr(new, name), names) for name in compared)


# Attributes


def _attribute(
    original: Grammar, learned: Grammar, name: str, mixture: str, number: int
) -> tuple[AttributeParts, list[Floats]]:
    """Parts of an attribute with a new distribution, and for each component their probabilities [parts]."""
    value = learned.attributes[name].value
    values = _by_component(value, mixture, number) or [value] * number
    leaves = [list(_leaves(choice, 1.0)) for choice in values]
    ranges = [drawn_range(leaf) for component_leaves in leaves for _, leaf in component_leaves]
    bounds = sorted({end for ends in ranges if ends is not None for end in ends})
    numeric = all(ends is not None for ends in ranges)
    parts = attribute_parts(original, name, [Threshold(name, bound) for bound in bounds] if numeric else [])
    _check_apart(parts.parts)
    return parts, [
        _probabilities(original.attributes[name].value, parts, component_leaves) for component_leaves in leaves
    ]


def _leaves(choice: Choice, probability: float) -> Iterator[tuple[float, Choice]]:
    if isinstance(choice, Case):
        raise _ForeignError
    if not isinstance(choice, Stochastic):
        yield probability, choice
        return
    chances = probabilities(choice)
    if chances is None:
        raise _ForeignError
    for chance, branch in zip(chances, choice.branches, strict=True):
        yield from _leaves(branch, probability * chance)


def _check_apart(parts: Sequence[AttributePart]) -> None:
    """Check that a number determines its part."""
    ranges = sorted((part.low, part.high) for part in parts if np.isfinite(part.low))
    if any(high > low for (_, high), (low, _) in pairwise(ranges)):
        raise _ForeignError


def _probabilities(value: Choice, parts: AttributeParts, leaves: Sequence[tuple[float, Choice]]) -> Floats:
    result = np.zeros(len(parts.parts))
    for probability, leaf in leaves:
        ends = drawn_range(leaf)
        shares = np.array([_share(leaf, ends, leaf_at(value, part.branch), part) for part in parts.parts])
        if abs(shares.sum() - 1.0) > ROUNDING:
            raise _ForeignError
        result += probability * shares
    return result


def _share(leaf: Choice, ends: tuple[float, float] | None, old: Choice, part: AttributePart) -> float:
    """Share of the draws of a leaf that lies in a part."""
    if ends is None or not np.isfinite(part.low):
        return float(leaf == old)
    low, high = max(ends[0], part.low), min(ends[1], part.high)
    return max(0.0, high - low) / (ends[1] - ends[0])
