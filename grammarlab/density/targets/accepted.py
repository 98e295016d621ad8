"""Grammar with an acceptance rule: rejection completes what a grammar of moderate size cannot express."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from grammarlab.arrays import Floats
from grammarlab.asset_roots import AssetRoot
from grammarlab.density.exact.learned import LearnedGrammar, num_alternatives
from grammarlab.density.exact.splitting import Base
from grammarlab.density.sampler import AbstractSampler, GrammarSampler
from grammarlab.derivation.forest import Forest
from grammarlab.errors import UsageError
from grammarlab.features.acceptance import Acceptance, SplitSymbol
from grammarlab.features.accepted_models import annotations_of
from grammarlab.features.expression import Expression
from grammarlab.features.patterns.conditions import patterns_of
from grammarlab.features.patterns.pattern import Feature, Pattern
from grammarlab.language.grammar import Grammar
from grammarlab.language.numbering import SymbolKey
from grammarlab.language.rewriting import rewrite

_NAME = "acceptance_rate"


@dataclass(frozen=True)
class AcceptedGrammar(AbstractSampler):
    """A density from a grammar and an acceptance rule."""

    text: str
    """A rule file with the rule in an annotation."""
    original: Grammar
    """The original grammar."""
    part: LearnedGrammar | None
    """The grammar without the rule; None if it is the original."""
    rule: Expression
    """Acceptance probability over the features of the original, clipped to 0 to 1."""
    mean: float
    """Mean of the rule over the models of the part, estimated from the pool."""
    accept_rate: float
    """Share of candidates that the file keeps: the mean, times that of the original's own rule."""
    base: Base
    findings: tuple[str, ...]
    """Remarks for the user about how it was made."""
    assets: AssetRoot | None = None
    """Folder of meshes and images."""

    @property
    def method(self) -> str:
        """The name of the method."""
        return "acceptance"

    @property
    def rules_before(self) -> int:
        """Branches of the rules of the original grammar."""
        return num_alternatives(self.original)

    @property
    def units(self) -> tuple[str, str]:
        """What its size counts: one, and several."""
        return "branch of rules", "branches of rules"

    @property
    def rules_after(self) -> int:
        """Branches of the rules."""
        return self.rules_before if self.part is None else self.part.rules_after

    @cached_property
    def grammar(self) -> Grammar:
        """Grammar of the text."""
        return Grammar.parse(self.text, self.original.file)

    def sample(self, num_models: int, seed: int) -> Forest:
        forest = GrammarSampler(self.grammar, self.assets).sample(num_models, seed)
        return forest if self.part is None else self.part.as_original(forest)

    def log_density(self, forest: Forest) -> Floats:
        with np.errstate(divide="ignore"):
            return forest.log_probability() + np.log(self.ratio(forest))

    def ratio(self, forest: Forest) -> Floats:
        """Density [models] of models of the original grammar, divided by their original density."""
        probabilities = Acceptance(self.rule, {}).probabilities(forest)
        return probabilities / self.mean * (1.0 if self.part is None else self.part.ratio(forest))


def split_symbols(part: LearnedGrammar | None, features: tuple[Feature, ...]) -> Mapping[SymbolKey, SplitSymbol]:
    """Symbols of a learned grammar for the symbols of patterns.

    Args:
        part: the learned grammar; None for the original.
        features: the features.
    """
    if part is None:
        return {}
    nodes = [node for feature in features for node in _nodes(feature)]
    every = any(node.symbol is None and node.branch is not None for node in nodes)
    named = {node.symbol for node in nodes}
    return {
        key: SplitSymbol(origin.key[0], origin.branches)
        for key, origin in part.origins.items()
        if every or origin.key[0] in named
    }


def with_rule(grammar: Grammar, acceptance: Acceptance, rate: float, header: Sequence[str] = ()) -> str:
    """Text of a grammar with a new acceptance rule instead of its own.

    Args:
        grammar: the grammar.
        acceptance: the rule.
        rate: share of its models that are kept.
        header: lines of a comment at the top of the file.
    """
    name = next(f"{_NAME}{end}" for end in _ends() if f"{_NAME}{end}" not in grammar.text)
    definition = f"{acceptance.annotation()}\nconst {name} = {rate:.3g}"
    return rewrite(grammar, {}, None, [definition], header)


def product_with_own(grammar: Grammar, rule: str) -> tuple[Grammar, Expression]:
    """A grammar without its acceptance rule, and the product of that rule with another one.

    Raises:
        UsageError: If the product is too long.
    """
    original_rule = Acceptance.of(grammar.tree)
    if original_rule is None:
        return grammar, Expression.parse(rule)
    if original_rule.split:
        raise UsageError("the acceptance rule of this file counts symbols that are split: learn from its original")
    number = next(i for i, d in enumerate(grammar.tree.definitions) if annotations_of(grammar.tree)[0] in d.annotations)
    start, end = grammar.tree.spans[number]
    text = grammar.text[:start] + grammar.text[end:].lstrip()
    return Grammar.parse(text, grammar.file), Expression.parse(
        f"min(max({original_rule.expression.text}, 0), 1) * ({rule})"
    )


def _ends() -> Iterator[str]:
    yield ""
    number = 2
    while True:
        yield f"_{number}"
        number += 1


def _nodes(feature: Feature) -> Iterator[Pattern]:
    waiting = list(patterns_of(feature))
    while waiting:
        node = waiting.pop()
        yield node
        waiting += [below for run in node.below for below in run.run]
