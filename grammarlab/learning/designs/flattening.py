"""Flattened grammars: all alternatives of a choice are equally likely, so that rare models occur more often."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np

from grammarlab.arrays import Floats
from grammarlab.derivation.compiler import compile_grammar
from grammarlab.derivation.forest import Forest
from grammarlab.derivation.program import Program
from grammarlab.language.checking.percentages import probabilities
from grammarlab.language.grammar import Grammar
from grammarlab.language.syntax.syntax_tree import Attribute, Function, Node, Number, Rule, Stochastic, walk


@dataclass(frozen=True, slots=True)
class Flattened:
    """A grammar for proposals, with their densities in the original grammar."""

    program: Program
    """Compiled grammar; symbols, rules and sites are numbered as in the original."""
    log_original: Floats
    """[sites, branches] log-probability of each branch in the original; NaN for unchanged choices."""

    def log_ratio(self, forest: Forest) -> Floats:
        """[num_models] log of p / p', the density under the original over that under the flattened grammar.

        Args:
            forest: models of `program`, or of the original.
        """
        log_flat = np.where(np.isfinite(self.log_original), 0.0, np.nan)
        alternatives = np.isfinite(self.log_original).sum(axis=1, keepdims=True)
        log_flat -= np.log(np.maximum(alternatives, 1))
        changed = np.isfinite(log_flat).any(axis=1)[forest.draws.site]  # ty: ignore[not-subscriptable]
        site = forest.draws.site[changed]
        branch = forest.draws.value[changed].astype(np.int64)
        ratio = (self.log_original - log_flat)[site, branch]
        model = forest.nodes.model[forest.draws.node[changed]]
        return np.bincount(model, weights=ratio, minlength=forest.num_models).astype(np.float64)


def flattened(grammar: Grammar, definitions: Collection[str] | None = None) -> Flattened:
    """The grammar with equal percentages in its choices.

    Branches of 0 % stay impossible, and a choice whose percentages are not numbers does not change.

    Args:
        grammar: the original.
        definitions: names of the rules, functions and attributes to change; None for all.
    """
    original: dict[int, tuple[float, ...]] = {}
    parts = tuple(
        _flat(definition, original)
        if isinstance(definition, Rule | Function | Attribute)
        and (definitions is None or definition.name in definitions)
        else definition
        for definition in grammar.tree.definitions
    )
    tree = replace(grammar.tree, definitions=parts)
    program = compile_grammar(Grammar(grammar.text, tree, grammar.file, grammar.libraries))
    choices = [node for node in walk(grammar.tree) if isinstance(node, Stochastic)]
    sites = [index for index, site in enumerate(program.sites) if site.kind == "choice"]
    log_original = np.full((len(program.sites), max([1, *(len(node.branches) for node in choices)])), np.nan)
    for site, node in zip(sites, choices, strict=True):
        if node.number in original:
            with np.errstate(divide="ignore"):
                log_original[site, : len(node.branches)] = np.log(original[node.number])
    return Flattened(program, log_original)


def _flat(value: Any, original: dict[int, tuple[float, ...]]) -> Any:
    """A part of a syntax tree with equal percentages; records the old probabilities by the number of the choice."""
    if isinstance(value, tuple):
        return tuple(_flat(item, original) for item in value)
    if not isinstance(value, Node):
        return value
    changes = {field.name: _flat(getattr(value, field.name), original) for field in fields(value)}
    if isinstance(value, Stochastic) and (shares := probabilities(value)) is not None:
        original[value.number] = shares
        changes["percentages"] = tuple(Number(100.0 if p > 0 else 0.0, location=value.location) for p in shares)
    return type(value)(**changes)
