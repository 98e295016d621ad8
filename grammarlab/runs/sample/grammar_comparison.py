"""Divergence of two grammars: exact if both make trees of one grammar, otherwise a bound from shared symbols."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from grammarlab.arrays import Floats
from grammarlab.density.exact.learned import LearnedGrammar
from grammarlab.density.exact.recovery import recovered
from grammarlab.density.grammar_skeleton import TreeGrammar
from grammarlab.density.sampler import GrammarSampler
from grammarlab.derivation.forest import Forest
from grammarlab.errors import GrammarlabError
from grammarlab.features.acceptance import Acceptance
from grammarlab.language.grammar import Grammar
from grammarlab.learning.targets.divergence import jensen_shannon
from grammarlab.runs.sample.comparison import (
    MAX_DIFFERENCES,
    MIN_DIVERGENCE,
    NUM_BINS,
    BranchShare,
    ChoiceDifference,
    Comparison,
    Difference,
    NumberDifference,
)
from grammarlab.runs.sample.records import compiled
from grammarlab.runs.sample.shipped import SUFFIX, RuleSource, find_rules

_LEARNED = re.compile(r"^// Learned by grammarlab \S+ from (\S+)\.cga \(SHA-256 ([0-9a-f]{16})\)", re.MULTILINE)
_HEADER_CHARACTERS = 2_000
"""Number of characters at the top of a file in which its origin is searched."""


def compare_grammars(sources: tuple[RuleSource, RuleSource], num_models: int, seed: int) -> Comparison:
    """Compare two grammars on samples of both.

    Args:
        sources: the grammars.
        num_models: number of models of each grammar, at least 1.
        seed: seed of the models.

    Raises:
        GrammarlabError: If one of them cannot be derived.
    """
    first_grammar, second_grammar = (compiled(source.text(), source.name)[0] for source in sources)
    common = _common(sources, (first_grammar, second_grammar))
    if common is None:
        forests = tuple(
            GrammarSampler(grammar, source.assets).sample(num_models, seed)
            for grammar, source in zip((first_grammar, second_grammar), sources, strict=True)
        )
    else:
        forests = tuple(learned.sample(num_models, seed) for learned in common.learned)
    occurring = [_counts(forest) for forest in forests]
    shared = [symbol for symbol in occurring[0] if symbol in occurring[1]]
    differences = sorted(
        _differences(occurring[0], occurring[1], shared), key=lambda difference: (-difference.js, difference.symbol)
    )
    significant = tuple(difference for difference in differences if difference.js > MIN_DIVERGENCE)
    return Comparison(
        sources=sources,
        origin="" if common is None else common.name,
        js=None if common is None else _divergence(common, forests),
        at_least=differences[0].js if differences else 0.0,
        choices=() if common is None else _choices(common, forests),
        numbers=() if common is None else _numbers(common, forests),
        differences=significant[:MAX_DIFFERENCES],
        only_first=tuple(symbol for symbol in occurring[0] if symbol not in occurring[1]),
        only_second=tuple(symbol for symbol in occurring[1] if symbol not in occurring[0]),
        are_strangers=common is None and not shared,
    )


@dataclass(frozen=True, slots=True)
class _Common:
    """The common original of two grammars."""

    name: str
    grammar: Grammar
    learned: tuple[LearnedGrammar, LearnedGrammar]


def _common(sources: Sequence[RuleSource], grammars: Sequence[Grammar]) -> _Common | None:
    """The grammar whose trees both grammars make: one of the two, or the original named in a learned file."""
    if any(Acceptance.of(grammar.tree) for grammar in grammars):
        return None  # its trees do not follow from rules only
    pairs = zip(sources, grammars, strict=True)
    candidates = [(source.name, grammar) for source, grammar in pairs]
    for source, grammar in zip(sources, grammars, strict=True):
        candidates += _named_in(source, grammar)
    for name, grammar in candidates:
        learned = [recovered(grammar, maker.text) for maker in grammars]
        if learned[0] is not None and learned[1] is not None:
            first, second = (
                replace(m, assets=s.assets) for m, s in zip(learned, sources, strict=True) if m is not None
            )
            return _Common(name, grammar, (first, second))
    return None


def _named_in(source: RuleSource, grammar: Grammar) -> Iterator[tuple[str, Grammar]]:
    """The original named in a learned file: a shipped grammar, or a file beside it."""
    match = _LEARNED.search(grammar.text[:_HEADER_CHARACTERS])
    if match is None:
        return
    name, start_of_hash = match.groups()
    for argument in (str(source.path.parent / f"{name}{SUFFIX}"), name):
        try:
            origin = find_rules(argument)
            parsed, _ = compiled(origin.text(), origin.name)
        except GrammarlabError:
            continue
        if parsed.hash.startswith(start_of_hash):
            yield name, parsed


def _divergence(common: _Common, forests: Sequence[Forest]) -> float:
    """Divergence of two densities, on models of both; a model represents its mean density under both grammars."""
    first, second = (np.concatenate([learned.ratio(forest) for forest in forests]) for learned in common.learned)
    return jensen_shannon(first / (first + second), second / (first + second))


def _choices(common: _Common, forests: Sequence[Forest]) -> tuple[ChoiceDifference, ...]:
    """The choices that differ most, weighted by their number per model, at most one."""
    rules = forests[0].rules
    rule_counts = [
        np.bincount(f.nodes.rule[f.nodes.rule >= 0], minlength=len(rules)).astype(np.float64) for f in forests
    ]
    tree = TreeGrammar.of(common.grammar)
    differences: list[tuple[float, ChoiceDifference]] = []
    for key in tree.bodies:
        indices = [i for i, rule in enumerate(rules) if (rule.symbol, rule.parameters) == key]
        shares = [counts[indices] for counts in rule_counts]
        if len(indices) < 2 or not all(share.any() for share in shares):
            continue
        least = min(float(share.sum()) for share in shares)
        js = jensen_shannon(shares[0], shares[1])
        if js <= MIN_DIVERGENCE + len(indices) / (2.0 * least):
            continue
        makes = {a.branch: " ".join(s.key[0] for s in a.successors) or "nothing" for a in tree.alternatives(key)}
        often = Counter(makes.values())
        first, second = (share / share.sum() for share in shares)
        branches = tuple(
            BranchShare(_words(makes[rules[i].branch], rules[i].line, often), float(p), float(q))
            for i, p, q in zip(indices, first, second, strict=True)
        )
        weight = js * min(1.0, least / min(forest.num_models for forest in forests))
        differences.append((weight, ChoiceDifference(key[0], rules[indices[0]].line, js, branches)))
    differences.sort(key=lambda pair: -pair[0])
    return tuple(difference for _, difference in differences[:MAX_DIFFERENCES])


def _words(makes: str, line: int, often: Counter[str]) -> str:
    return makes if often[makes] == 1 else f"{makes} (line {line})"


def _numbers(common: _Common, forests: Sequence[Forest]) -> tuple[NumberDifference, ...]:
    """Attributes with different ranges."""
    names = dict.fromkeys(parts.name for learned in common.learned for parts in learned.attributes)
    differences: list[NumberDifference] = []
    for name in names:
        sites = [i for i, site in enumerate(forests[0].sites) if site.name == name and site.kind == "uniform"]
        values = [forest.draws.value[np.isin(forest.draws.site, sites)] for forest in forests]
        if not all(len(drawn) for drawn in values):
            continue
        edges = np.histogram_bin_edges(np.concatenate(values), NUM_BINS)
        js = jensen_shannon(*(np.histogram(drawn, edges)[0] for drawn in values))
        if js > MIN_DIVERGENCE:
            differences.append(NumberDifference(name, float(values[0].mean()), float(values[1].mean()), js))
    return tuple(sorted(differences, key=lambda difference: -difference.js))


def _counts(forest: Forest) -> dict[str, Floats]:
    """Counts [models] of each symbol that occurs."""
    symbols, num = len(forest.symbols), forest.num_models
    cells = forest.nodes.model.astype(np.int64) * symbols + forest.nodes.symbol
    table = np.bincount(cells, minlength=num * symbols).reshape(num, symbols)
    return {symbol: table[:, i].astype(np.float64) for i, symbol in enumerate(forest.symbols) if table[:, i].any()}


def _differences(
    first_counts: dict[str, Floats], second_counts: dict[str, Floats], shared: Sequence[str]
) -> Iterator[Difference]:
    for symbol in shared:
        first, second = first_counts[symbol], second_counts[symbol]
        _, number = np.unique(np.concatenate([first, second]), return_inverse=True)
        size = int(number.max()) + 1
        parts = np.split(number.reshape(-1), [len(first)])
        js = jensen_shannon(*(np.bincount(part, minlength=size) for part in parts))
        yield Difference(symbol, float((first > 0).mean()), float((second > 0).mean()), js)
