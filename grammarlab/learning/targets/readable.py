"""Smallest grammar whose density is near enough to a predicted one.

Simple functions of few features (`grammarlab.learning.targets.simplification`) are compiled one after the other, and
compared by the number of branches of their rules.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from grammarlab.density.splits.learned import LearnedGrammar, num_alternatives
from grammarlab.density.targets.accepted import AcceptedGrammar
from grammarlab.density.targets.rejection import RejectionSampler
from grammarlab.derivation.forest import Forest
from grammarlab.features.rules.acceptance import Acceptance
from grammarlab.learning.targets.accepting_target import with_acceptance
from grammarlab.learning.targets.simplification import TOLERANCE
from grammarlab.learning.targets.target import Making
from grammarlab.learning.targets.wanted import Simple, Wanted, compiled, rounded_off, rules_if_few
from grammarlab.preference.simple.simplified import SimplifiedPreference

_AS_SMALL = 0.05
"""Relative difference of sizes that count as equal; then the nearest grammar is used."""


class ReadableSampler(NamedTuple):
    """A grammar that samples a density, and the function it was made from."""

    learned: LearnedGrammar | AcceptedGrammar | RejectionSampler
    preference: SimplifiedPreference
    even: LearnedGrammar | None
    """With base uniform, the grammar that the preference multiplies."""


def smallest(wanted: Wanted, forest: Forest, making: Making, lines: Sequence[str]) -> ReadableSampler:
    """Smallest grammar near enough to the target density; with an acceptance rule if it would be too large.

    Args:
        wanted: the density.
        forest: derivations of the grammar that show how often successors inside blocks occur.
        making: options, such as the largest size.
        lines: comment lines at the top of the new file.
    """
    usual = 2 * num_alternatives(wanted.target.grammar)
    most = making.max_rules or usual
    best: tuple[Simple, LearnedGrammar] | None = None
    fewest, fitting = 0, np.inf
    header = [*lines, f"Method compile, base {making.base}"]
    if Acceptance.of(wanted.target.grammar.tree) is None:
        for simple in wanted.simple(exact_only=True):
            if simple.js > TOLERANCE:
                break
            if len(simple.preference.tree) > fitting:
                continue  # a larger tree than one that was too large
            learned = compiled(simple.target, forest, header, most)
            # A finding reports the size of the whole grammar, where counting takes no longer than usual.
            size = 0 if learned is None else rules_if_few(learned, max(most, usual))
            if learned is None or size > most:
                fewest, fitting = min(fewest or size, size), len(simple.preference.tree)
            elif best is None or _is_better((simple, learned), best):
                best = simple, learned
    if best is not None:
        ones = np.ones(len(wanted.scores))
        return ReadableSampler(
            rounded_off(wanted, best[0].target, forest, header, best[1], ones), best[0].preference, best[0].target.even
        )
    reason = (
        f"a grammar alone would have {fewest:,} branches of rules or more, and {most:,} {'is' if most == 1 else 'are'} "
        "allowed"
        if fewest
        else "no grammar alone says it"
    )
    return ReadableSampler(*with_acceptance(wanted, forest, lines, most, reason), wanted.target.even)


def _is_better(one: tuple[Simple, LearnedGrammar], other: tuple[Simple, LearnedGrammar]) -> bool:
    """Whether a grammar is smaller, or equally small and nearer."""
    size, other_size = one[1].rules_after, other[1].rules_after
    if abs(size - other_size) <= _AS_SMALL * other_size:
        return one[0].js < other[0].js
    return size < other_size
