"""Text of attributes with new distributions."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from grammarlab.density.counting.attributes import AttributeParts, drawn_range, leaf_at
from grammarlab.language.grammar import Grammar
from grammarlab.language.rewriting import choice_text, likely_last
from grammarlab.language.syntax import printing
from grammarlab.language.syntax.tree import Choice

Floats = NDArray[np.float64]

_INDENT = "    "
_SAME = 1e-13
"""Largest difference of equal probabilities."""


def mixture_text(name: str, probabilities: Sequence[float]) -> str:
    """Definition of the attribute with the number of a model's component, from 1.

    Args:
        name: of the attribute.
        probabilities: of at least two components.
    """
    choice = [(probability, str(i + 1)) for i, probability in enumerate(probabilities)]
    return f"attr {name} ={choice_text(likely_last(choice), _INDENT)}"


def attribute_text(grammar: Grammar, parts: AttributeParts, probabilities: Sequence[Floats], mixture: str) -> str:
    """New value of an attribute; empty if it does not change.

    Args:
        grammar: the original grammar.
        parts: the attribute.
        probabilities: of its parts, for each component.
        mixture: the attribute with the number of a model's component.
    """
    if all(np.abs(p - parts.probabilities).max() <= _SAME for p in probabilities):
        return ""
    value = grammar.attributes[parts.name].value
    if all((np.abs(p - probabilities[0]) <= _SAME).all() for p in probabilities):
        return _drawn(value, parts, probabilities[0], _INDENT)
    values = [_drawn(value, parts, p, 2 * _INDENT) for p in probabilities]
    heads = [*(f"case {mixture} == {i + 1} :" for i in range(len(values) - 1)), "else :"]
    return "".join(f"\n{_INDENT}{head}{text}" for head, text in zip(heads, values, strict=True))


def _drawn(value: Choice, parts: AttributeParts, probabilities: Floats, indent: str) -> str:
    """Text of a value whose parts have these probabilities; adjacent parts of unchanged proportions are joined."""
    runs: list[tuple[float, int, int]] = []
    ratios = probabilities / parts.probabilities
    for i, part in enumerate(parts.parts):
        same_branch = bool(runs) and part.branch == parts.parts[i - 1].branch
        if same_branch and abs(ratios[i] - ratios[i - 1]) <= _SAME * ratios[i]:
            runs[-1] = (runs[-1][0] + float(probabilities[i]), runs[-1][1], i)
        else:
            runs.append((float(probabilities[i]), i, i))
    texts = [(p, _part_text(value, parts, first, last)) for p, first, last in runs if p > 0.0]
    return f" {texts[0][1]}" if len(texts) == 1 else choice_text(likely_last(texts), indent)


def _part_text(value: Choice, parts: AttributeParts, first: int, last: int) -> str:
    """Text of a run of parts of one branch."""
    leaf = leaf_at(value, parts.parts[first].branch)
    low, high = parts.parts[first].low, parts.parts[last].high
    ends = drawn_range(leaf)
    if ends is None or ends == (low, high):
        return printing.value(leaf)
    return f"rand({_number(low)}, {_number(high)})"


def _number(value: float) -> str:
    return repr(value).removesuffix(".0")
