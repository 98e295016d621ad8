"""Grammars in which one choice is always or never taken: the same seed then gives models that differ in it alone."""

from __future__ import annotations

from dataclasses import replace

from grammarlab.derivation.compiler import compile_grammar
from grammarlab.derivation.program import Program
from grammarlab.features.patterns.pattern import Feature, Formula, Pattern, Present
from grammarlab.language.checking.percentages import probabilities
from grammarlab.language.grammar import Grammar
from grammarlab.language.syntax.syntax_tree import Case, Choice, Number, Rule, Stochastic


def choice_of(feature: Feature) -> Pattern | None:
    """The branch of one rule that a feature looks at, wherever the rule is used; None if it looks at anything else."""
    if isinstance(feature, Present):
        return choice_of(feature.feature)
    if isinstance(feature, Formula):
        patterns = [pattern for atom in feature.features if (pattern := choice_of(atom)) is not None]
        return patterns[0] if len(patterns) == len(feature.features) == 1 else None
    if isinstance(feature, Pattern) and feature.symbol is not None and feature.branch and not feature.below:
        return feature
    return None


def contrasted(grammar: Grammar, choice: Pattern) -> tuple[Program, Program] | None:
    """The grammar without and with a choice, compiled; None if its last branch is not a choice by constant percentages.

    Percentages alone differ, so all places of the grammar, and with them all other draws of a seed, stay as they are.

    Args:
        grammar: the grammar.
        choice: a branch, as `choice_of` gives it.
    """
    programs = []
    for share in (0.0, 1.0):
        parts = tuple(
            replace(part, body=_with_share(part.body, choice.branch or (), share))
            if isinstance(part, Rule) and _is_of(part, choice)
            else part
            for part in grammar.tree.definitions
        )
        if parts == grammar.tree.definitions:
            return None
        tree = replace(grammar.tree, definitions=parts)
        programs.append(compile_grammar(Grammar(grammar.text, tree, grammar.file, grammar.libraries)))
    return programs[0], programs[1]


def _is_of(rule: Rule, choice: Pattern) -> bool:
    return rule.name == choice.symbol and choice.parameters in (None, len(rule.parameters))


def _with_share(body: Choice, branch: tuple[int, ...], share: float) -> Choice:
    """A choice in which the branch at the end of a way has a share of 0 or 1; unchanged if it has none by chance."""
    if not isinstance(body, Case | Stochastic) or branch[0] >= len(body.branches):
        return body
    index = branch[0]
    if len(branch) > 1:
        inner = _with_share(body.branches[index], branch[1:], share)
        return replace(body, branches=(*body.branches[:index], inner, *body.branches[index + 1 :]))
    shares = probabilities(body) if isinstance(body, Stochastic) else None
    if not isinstance(body, Stochastic) or shares is None or not 0.0 < shares[index] < 1.0:
        return body
    others = [0.0 if share or number == index else 100.0 * other for number, other in enumerate(shares)]
    others[index] = 100.0 * share
    return replace(body, percentages=tuple(Number(value, location=body.location) for value in others))
