"""How far two grammars are apart: exactly where their trees say the same, else as far as shared symbols tell."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from grammarlab.density.inside import Start, TreeRatio
from grammarlab.density.skeleton import SymbolKey, TreeGrammar
from grammarlab.density.writing import Origin
from grammarlab.derivation.derive import derive
from grammarlab.derivation.forest import Forest
from grammarlab.errors import UsageError
from grammarlab.evaluation.divergence import jensen_shannon
from grammarlab.language.grammar import Grammar
from grammarlab.runs.derive_batch import compiled
from grammarlab.runs.examples import RuleSource, find_rules

Floats = NDArray[np.float64]

NUM_MODELS = 2_500
"""Of each grammar."""
MOST_DIFFERENCES = 12
_ALIKE = 0.003
"""Divergences of two samples of one grammar reach this by chance."""


@dataclass(frozen=True, slots=True)
class Difference:
    """A symbol that is not as common in one grammar as in the other."""

    symbol: str
    first: float
    """Share of the models of the first grammar that have it."""
    second: float
    js: float
    """Divergence in nats of how often it occurs."""


@dataclass(frozen=True)
class Comparison:
    """Two grammars compared."""

    sources: tuple[RuleSource, RuleSource]
    grammars: tuple[Grammar, Grammar]
    js: float | None
    """Divergence in nats of the two densities over trees; None where their trees are not the same."""
    at_least: float
    """What the most telling symbol shows of it."""
    differences: tuple[Difference, ...]
    """The symbols that differ most, the most telling first."""
    only_first: tuple[str, ...]
    """Symbols that the second grammar does not have."""
    only_second: tuple[str, ...]


def compare_grammars(first: str, second: str, *, num_models: int = NUM_MODELS, seed: int = 0) -> Comparison:
    """Compares two grammars on samples of both.

    Args:
        first: a rule file or the name of a shipped grammar.
        second: likewise.
        num_models: of each grammar, at least 1.
        seed: of the models.

    Raises:
        UsageError: when there is no such grammar.
        GrammarlabError: when one of them cannot be derived.
    """
    if num_models < 1:
        raise UsageError(f"expected at least one model of each grammar, found {num_models}")
    sources = find_rules(first), find_rules(second)
    one, other = (compiled(source.text(), source.name)[0] for source in sources)
    forests = tuple(
        derive(grammar, num_models, seed, assets=source.assets)
        for grammar, source in zip((one, other), sources, strict=True)
    )
    occurring = [_counts(forest) for forest in forests]
    shared = [symbol for symbol in occurring[0] if symbol in occurring[1]]
    found = sorted(_differences(occurring[0], occurring[1], shared), key=lambda found: (-found.js, found.symbol))
    told = tuple(difference for difference in found if difference.js > _ALIKE)
    return Comparison(
        (sources[0], sources[1]),
        (one, other),
        _exact(one, other, forests),
        found[0].js if found else 0.0,
        told[:MOST_DIFFERENCES],
        tuple(symbol for symbol in occurring[0] if symbol not in occurring[1]),
        tuple(symbol for symbol in occurring[1] if symbol not in occurring[0]),
    )


def _counts(forest: Forest) -> dict[str, Floats]:
    """How often each symbol occurs in each model [models]; those that occur at all."""
    symbols, num = len(forest.symbols), forest.num_models
    places = forest.nodes.model.astype(np.int64) * symbols + forest.nodes.symbol
    table = np.bincount(places, minlength=num * symbols).reshape(num, symbols)
    return {symbol: table[:, i].astype(np.float64) for i, symbol in enumerate(forest.symbols) if table[:, i].any()}


def _differences(one: dict[str, Floats], other: dict[str, Floats], shared: Sequence[str]) -> Iterator[Difference]:
    for symbol in shared:
        first, second = one[symbol], other[symbol]
        _, number = np.unique(np.concatenate([first, second]), return_inverse=True)
        size = int(number.max()) + 1
        parts = np.split(number.reshape(-1), [len(first)])
        js = jensen_shannon(*(np.bincount(part, minlength=size) for part in parts))
        yield Difference(symbol, float((first > 0).mean()), float((second > 0).mean()), js)


def _exact(one: Grammar, other: Grammar, forests: tuple[Forest, ...]) -> float | None:
    """The divergence of two grammars that differ in percentages of rules only."""
    before, after = TreeGrammar.of(one), TreeGrammar.of(other)
    if _structure(before) != _structure(after) or not _same_attributes(one, other):
        return None
    origins = {key: _same(after, key) for key in after.bodies}
    ratio = TreeRatio(before, after, origins, [Start(after.start, None)])
    by_first = np.concatenate([ratio(forest)[0] for forest in forests])
    # Every model stands for what both grammars together make of it.
    weights = 2.0 / (1.0 + by_first)
    return jensen_shannon(weights, weights * by_first)


def _same(tree: TreeGrammar, key: SymbolKey) -> Origin:
    branches = [alternative.branch for alternative in tree.alternatives(key)]
    return Origin(key, {branch: branch for branch in branches if branch is not None})


def _structure(tree: TreeGrammar) -> object:
    """Everything about a skeleton but its probabilities."""
    rules = {
        key: [(a.branch, [successor.key for successor in a.successors]) for a in tree.alternatives(key)]
        for key in tree.bodies
    }
    return tree.start, rules


def _same_attributes(one: Grammar, other: Grammar) -> bool:
    """Whether attributes have the same values, so that only rules decide."""
    values = [{name: attribute.value for name, attribute in grammar.attributes.items()} for grammar in (one, other)]
    return values[0] == values[1]
