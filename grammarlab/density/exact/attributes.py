"""Attributes whose draws a preference reads, cut into parts on which the preference is constant.

An attribute is drawn before the tree is derived. A preference can distinguish the branch of a choice that gave it,
and the two thresholds between which it lies: each such part has its own probability.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from grammarlab.derivation.expressions import number_grammar
from grammarlab.derivation.forest import Forest
from grammarlab.errors import InexactError
from grammarlab.features.patterns.pattern import Draw, Threshold
from grammarlab.language.checking.percentages import constant, probabilities
from grammarlab.language.grammar import Grammar
from grammarlab.language.numbering import Branch, function_name
from grammarlab.language.syntax.syntax_tree import Attribute, Call, Case, Choice, Expression, Stochastic, alternatives

AttributeFeature: TypeAlias = Threshold | Draw


@dataclass(frozen=True, slots=True)
class AttributePart:
    """A set of values of an attribute."""

    branch: Branch
    """Branch of the values in the attribute's choices, from the top."""
    low: float
    """Lower end of the range of a uniform number; NaN for other values."""
    high: float
    """Upper end of the range of a uniform number; NaN for other values."""
    probability: float
    share: float
    """Share of the branch's values that lie in the part, 0 to 1."""


@dataclass(frozen=True, slots=True)
class AttributeParts:
    """An attribute and its parts, all of which together have probability 1."""

    name: str
    parts: tuple[AttributePart, ...]
    counts: NDArray[np.int64]
    """[parts, features] value of each feature in each part."""

    @property
    def probabilities(self) -> NDArray[np.float64]:
        """Of each part [parts]."""
        return np.array([part.probability for part in self.parts])

    @property
    def shares(self) -> NDArray[np.float64]:
        """Share of each part in the values of its branch [parts]."""
        return np.array([part.share for part in self.parts])


def attribute_parts(grammar: Grammar, name: str, features: Sequence[AttributeFeature]) -> AttributeParts:
    """Parts of an attribute that features distinguish.

    Args:
        grammar: the grammar.
        name: the attribute.
        features: the features of this attribute.

    Raises:
        InexactError: If the attribute does not depend on random draws only, or a feature reads more than its part.
    """
    attribute = grammar.attributes.get(name)
    if attribute is None:
        raise InexactError(
            f"${name} is a random expression inside rules: an exact grammar can follow choices and drawn attributes"
        )
    numbered = _is_choice(attribute)
    for feature in features:
        if isinstance(feature, Draw) and not numbered:
            raise InexactError(
                f"the preference changes with every value of ${name}: an exact grammar needs thresholds, ${name} < 3"
            )
    bounds = sorted({feature.bound for feature in features if isinstance(feature, Threshold)})
    parts = tuple(
        part for leaf in _leaves(attribute, attribute.value, (), 1.0) for part in _cut(attribute, leaf, bounds)
    )
    counts = np.array([[_count(feature, part) for feature in features] for part in parts], dtype=np.int64)
    return AttributeParts(name, parts, counts)


def leaf_at(choice: Choice, branch: Branch) -> Choice:
    """The leaf of an attribute's choices that branches lead to."""
    for i in branch:
        if not isinstance(choice, Case | Stochastic):
            break
        choice = choice.branches[i]
    return choice


def drawn_range(node: Choice) -> tuple[float, float] | None:
    """The ends of ``rand(a, b)``, ``rand(b)`` or ``rand()``, lower end first; None for everything else."""
    if not isinstance(node, Call) or node.function != "rand":
        return None
    values = [constant(argument) for argument in node.arguments]
    ends = [0.0, 1.0] if not values else [0.0, values[0]] if len(values) == 1 else values
    if len(ends) != 2 or any(end is None or not np.isfinite(end) for end in ends):
        return None
    low, high = sorted(float(end) for end in ends if end is not None)
    return (low, high) if low < high else None


def _leaves(
    attribute: Attribute, choice: Choice, path: Branch, probability: float
) -> Iterator[tuple[Branch, Expression, float]]:
    if isinstance(choice, Case):
        raise InexactError(
            f"the attribute {attribute.name} is chosen by a condition: an exact grammar needs random draws only"
        )
    if not isinstance(choice, Stochastic):
        yield path, choice, probability  # type: ignore[misc, ty:invalid-yield]
        return
    chances = probabilities(choice)
    if chances is None:
        raise InexactError(f"the percentages of the attribute {attribute.name} are not constant")
    for i, (chance, branch) in enumerate(zip(chances, choice.branches, strict=True)):
        if chance > 0.0:
            yield from _leaves(attribute, branch, (*path, i), probability * chance)


def _cut(
    attribute: Attribute, leaf: tuple[Branch, Expression, float], bounds: Sequence[float]
) -> Iterator[AttributePart]:
    branch, node, probability = leaf
    ends = drawn_range(node)
    if ends is None:
        if bounds:
            raise InexactError(
                f"the attribute {attribute.name} is not rand(a, b) with constant a and b: its thresholds have no "
                "probabilities that an exact grammar could use"
            )
        yield AttributePart(branch, np.nan, np.nan, probability, 1.0)
        return
    low, high = ends
    cuts = [low, *(bound for bound in bounds if low < bound < high), high]
    for start, end in pairwise(cuts):
        share = (end - start) / (high - low)
        yield AttributePart(branch, start, end, probability * share, share)


def _count(feature: AttributeFeature, part: AttributePart) -> int:
    if isinstance(feature, Threshold):
        return int(part.high <= feature.bound)
    return part.branch[0] if feature.branch is None else int(part.branch[0] == feature.branch)


def _is_choice(attribute: Attribute) -> bool:
    """Whether the draw of an attribute is the number of a branch (`Site.name`)."""
    value = attribute.value
    return isinstance(value, Stochastic) and not all(function_name(leaf) == "rand" for leaf in alternatives(value))


def parts_taken(parts: AttributeParts, grammar: Grammar, forest: Forest) -> NDArray[np.int64]:
    """Part [models] of the attribute in each model of a forest of the grammar."""
    attribute = grammar.attributes[parts.name]
    values: dict[int, NDArray[np.float64]] = {}
    """Draws [models] of each random place of the attribute, by its number."""
    draws = forest.draws
    for site, occurrence in enumerate(number_grammar(grammar).random_places):
        if occurrence.definition is attribute:
            is_drawn = draws.site == site
            values[occurrence.node.number] = np.full(forest.num_models, np.nan)
            values[occurrence.node.number][forest.nodes.model[draws.node[is_drawn]]] = draws.value[is_drawn]
    indices = np.zeros(forest.num_models, dtype=np.int64)
    for number, part in enumerate(parts.parts):
        fits = np.ones(forest.num_models, dtype=bool)
        choice = attribute.value
        for branch in part.branch:
            if isinstance(choice, Stochastic):
                fits &= values[choice.number] == branch
                choice = choice.branches[branch]
        if isinstance(choice, Call) and np.isfinite(part.low):
            drawn = values[choice.number]
            fits &= (part.low <= drawn) & (drawn <= part.high)
        indices[fits] = number
    return indices
