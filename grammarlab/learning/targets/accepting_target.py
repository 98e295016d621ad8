"""Smallest grammar whose density is near enough to a predicted one, with an acceptance rule if it would be too large.

Simple functions of few features (`grammarlab.learning.targets.simplification`) are compiled one after the other, and
compared by the number of branches of their rules. A grammar of moderate size follows the predictions as far as its size
allows, so that many of its models are kept; the acceptance rule adds the rest.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import Flags, Floats
from grammarlab.density.exact.learned import LearnedGrammar, num_alternatives
from grammarlab.density.targets.accepted import AcceptedGrammar, product_with_own, split_symbols, with_rule
from grammarlab.density.targets.ranges import range_ends
from grammarlab.density.targets.rejection import PILOT_MODELS, RejectionSampler
from grammarlab.derivation.compiler import compile_grammar
from grammarlab.derivation.derive import derive_chunks
from grammarlab.derivation.forest import Forest
from grammarlab.features.acceptance import Acceptance
from grammarlab.features.expression import Expression
from grammarlab.features.patterns.conditions import sites_of
from grammarlab.features.patterns.pattern import Feature, Present
from grammarlab.language.grammar import Grammar
from grammarlab.learning.targets.distance_words import divergence_share
from grammarlab.learning.targets.divergence import agreement
from grammarlab.learning.targets.simplification import MIN_LEAF, TOLERANCE, simpler
from grammarlab.learning.targets.target_density import (
    MAX_TEXT,
    PoolDensity,
    Simple,
    compiled,
    rounded_off,
    rules_if_few,
)
from grammarlab.learning.targets.writers import Making
from grammarlab.preference.base import MIN_SHARE
from grammarlab.preference.regression_tree import Split, grow, leaves_of, means_of
from grammarlab.preference.simplified import SimplifiedPreference

_MARGIN_CHARACTERS = 2_000
"""Number of characters by which a text may grow when scores are scaled."""
_LEAVES = (2, 3, 4, 6, 8, 12, 16, 24, 32)
"""Largest numbers of leaves of trees for the grammar; the last one is that of a rule of its own, too."""
_EMPHASES = (0.0, 10.0)
"""Factor of the weight of liked models: a larger one makes trees separate regions without liked models."""
_MIN_RATE_FACTOR = 0.97
"""Smallest factor of the acceptance rate by which a split pays for its rules."""
_MIN_EFFECTIVE_LIKED = 200.0
"""Smallest effective number of liked models of the pool from which none in a leaf means that there are none."""
_SIZE_FACTOR = 0.75
"""Factor of the splits of the next candidate after a tree whose grammar is too large."""
_MIN_RATE_GAIN = 1.25
"""Smallest factor of the acceptance rate that a larger grammar needs."""
_SIZE_TOLERANCE = 0.05
"""Relative difference of sizes that count as equal; then the nearest grammar is used."""


class ReadableSampler(NamedTuple):
    """A grammar that samples a density, and the function it was made from."""

    learned: LearnedGrammar | AcceptedGrammar | RejectionSampler
    preference: SimplifiedPreference
    even: LearnedGrammar | None
    """Grammar that the preference multiplies; only with base uniform."""


def smallest(density: PoolDensity, forest: Forest, making: Making, lines: Sequence[str]) -> ReadableSampler:
    """Smallest grammar near enough to the target density; with an acceptance rule if it would be too large.

    Args:
        density: the density.
        forest: derivations of the grammar that show how often successors inside blocks occur.
        making: options, such as the largest size.
        lines: comment lines at the top of the new file.
    """
    usual = 2 * num_alternatives(density.target.grammar)
    most = making.max_rules or usual
    best: tuple[Simple, LearnedGrammar] | None = None
    fewest, fitting, is_too_long = 0, np.inf, False
    compiled_by_text: dict[str, LearnedGrammar | None] = {}  # trees that differ in rounding only say the same
    header = [*lines, f"Method compile, base {making.base}"]
    has_rule = Acceptance.of(density.target.grammar.tree) is not None
    for columns in () if has_rule else density.column_sets(exact_only=True):
        for simple in density.simple(columns):
            if simple.js > TOLERANCE:
                break
            if len(simple.preference.tree) > fitting:
                continue  # a larger tree than one that was too large
            function = density.columns.text(simple.preference)
            if function not in compiled_by_text:
                compiled_by_text[function] = compiled(simple.target, forest, header, most)
            learned = compiled_by_text[function]
            # A finding reports the size of the whole grammar, where counting takes no longer than usual.
            size = 0 if learned is None else rules_if_few(learned, max(most, usual))
            if learned is None or size is None or size > most:
                is_too_long |= size is None
                fewest, fitting = min(fewest or size or 0, size or fewest), len(simple.preference.tree)
            elif best is None or _is_better((simple, learned), best):
                best = simple, learned
        if best is not None:
            break  # other columns would only stand for those that matter
    if best is not None:
        ones = np.ones(len(density.scores))
        return ReadableSampler(
            rounded_off(density, best[0].target, forest, header, best[1], ones), best[0].preference, best[0].target.even
        )
    reason = (
        f"a grammar alone would have {fewest:,} branches of rules or more, and {most:,} {'is' if most == 1 else 'are'} "
        "allowed"
        if fewest
        else "a grammar alone would be too long for a rule file"
        if is_too_long
        else "no grammar alone says it"
    )
    return ReadableSampler(*_with_acceptance(density, forest, lines, most, reason), density.target.even)


def _is_better(grammar: tuple[Simple, LearnedGrammar], best: tuple[Simple, LearnedGrammar]) -> bool:
    """Whether a grammar is smaller, or equally small and nearer."""
    size, best_size = grammar[1].rules_after, best[1].rules_after
    if abs(size - best_size) <= _SIZE_TOLERANCE * best_size:
        return grammar[0].js < best[0].js
    return size < best_size


def _with_acceptance(
    density: PoolDensity, forest: Forest, lines: Sequence[str], max_branches: int, why: str
) -> tuple[AcceptedGrammar, SimplifiedPreference]:
    """Grammar of limited size with an acceptance rule, and the function that both together follow.

    Args:
        density: the target density.
        forest: derivations of the grammar that show how often successors inside blocks occur.
        lines: comment lines at the top of the new file.
        max_branches: largest number of branches of the rules.
        why: reason why no grammar alone is used.
    """
    simple = density.simplest(exact_only=False)
    grammar = density.target.grammar
    values = simple.preference(density.columns.rows)
    whole = _Part(None, float(values.max()), float(density.weights @ values / values.max() / density.weights.sum()))
    rule, learned = _rule_for_all(density, simple, whole), density.target.even
    original_rule = Acceptance.of(grammar.tree)
    if original_rule is None:
        fitting = np.inf
        for part in sorted(_parts(density, simple.preference), key=_worth, reverse=True):
            if part.preference is None or len(density.columns.text(part.preference)) > MAX_TEXT - _MARGIN_CHARACTERS:
                continue
            if _worth(part) < _MIN_RATE_GAIN * whole.rate or len(part.preference.tree) > fitting:
                continue
            fitting = _SIZE_FACTOR * len(part.preference.tree)
            candidate = compiled(density.as_target(part.preference), forest, (), max_branches)
            if candidate is None or (rules_if_few(candidate, max_branches) or np.inf) > max_branches:
                continue
            rest = _rule_for_rest(density, simple, part, part.preference, candidate)
            if rest is not None:
                keep_probability = _quotient(values, part.preference(density.columns.rows) * part.highest)
                target = density.as_target(part.preference)
                rule, learned = rest, rounded_off(density, target, forest, (), candidate, keep_probability)
                break
    text, mean, followed, js = rule
    rate = mean if original_rule is None else mean * _mean(original_rule, density)
    method = f"Method compile with acceptance, base {density.target.base}"
    header = [*lines, f"An acceptance rule keeps {rate:.2g} of the models; other engines ignore it.", method]
    if learned is None:
        plain, rule = product_with_own(grammar, text)
        written = with_rule(plain, Acceptance(rule, {}), rate, header)
    else:
        rule = Expression.parse(text)
        acceptance = Acceptance(rule, split_symbols(learned, rule.features))
        written = with_rule(learned.grammar, acceptance, rate, header)
    findings = [f"{why}, so the file keeps {rate:.2g} of its models by an acceptance rule; other engines ignore it"]
    if js > TOLERANCE:
        findings.append(
            f"the predictions need more features: without them the file differs by {divergence_share(js)} from what "
            "was learned, which more scores may mend"
        )
    result = AcceptedGrammar(
        text=written,
        original=grammar,
        part=learned,
        rule=Expression.parse(text),
        mean=mean,
        accept_rate=rate,
        base=density.target.base,
        findings=tuple(findings),
        assets=density.target.assets,
    )
    return result, followed


class _Part(NamedTuple):
    """A candidate function for the grammar."""

    preference: SimplifiedPreference | None
    """Function that the grammar follows; None for the original grammar."""
    highest: float
    """Largest quotient of the predicted function and this one, on the pool."""
    rate: float
    """Share of its models that are kept."""


def _parts(density: PoolDensity, predicted: SimplifiedPreference) -> Iterator[_Part]:
    """Functions of few features that exact grammars express, and their acceptance rates."""
    columns = density.columns
    values = predicted(columns.rows)
    liked = density.weights * values
    few_liked = bool(liked.sum() ** 2 < _MIN_EFFECTIVE_LIKED * (liked @ liked))
    exact = columns.order[columns.exact[columns.order]]
    share = values / (density.weights @ values / density.weights.sum())
    for emphasis in _EMPHASES:
        tree = grow(columns.rows, values, density.weights * (1.0 + emphasis * share), exact, max(_LEAVES), MIN_LEAF)
        for size in _LEAVES[: sum(size <= len(tree) + 1 for size in _LEAVES)]:
            leaf = leaves_of(tree[: size - 1], columns.rows)
            possible = np.logical_and(few_liked, _overlaps(tree[: size - 1], predicted))
            highest = np.zeros(size)
            np.maximum.at(highest, leaf, values)
            for scores in (means_of(leaf, size, values, density.weights), highest):
                leaf_values = scores[leaf]
                quotient = _cut(_quotient(values, leaf_values), density.weights * leaf_values, density.weights * values)
                # Leaves whose liked models are too rare for the pool keep the largest value.
                above = np.where(possible & (scores == 0.0), values.max() / quotient, scores)
                rate = float(density.weights @ values / quotient / (density.weights @ above[leaf]))
                # A rate of 1 can be a little more in floats.
                yield _Part(SimplifiedPreference(tree[: size - 1], above).pruned(), quotient, min(rate, 1.0))


def _overlaps(tree: Sequence[Split], predicted: SimplifiedPreference) -> NDArray[np.bool_]:
    """[leaves] whether ranges of columns of a leaf overlap with those of a positive leaf of another tree."""
    used = np.unique([split.column for split in (*tree, *predicted.tree)])
    low, high = _ranges(tree, used)
    other_low, other_high = _ranges(predicted.tree, used)
    overlap = (low[:, None] < other_high).all(axis=2) & (other_low < high[:, None]).all(axis=2)
    return np.any(overlap & (predicted.scores > 0.0), axis=1)


def _ranges(tree: Sequence[Split], used: NDArray[np.number]) -> tuple[Floats, Floats]:
    """[leaves, columns] bounds of the leaves of a tree in the used columns: the lower one is included."""
    low, high = np.full((len(tree) + 1, len(used)), -np.inf), np.full((len(tree) + 1, len(used)), np.inf)
    for number, split in enumerate(tree, 1):
        column = int(np.searchsorted(used, split.column))
        low[number], high[number] = low[split.leaf], high[split.leaf]
        low[number, column] = max(low[number, column], split.bound)
        high[split.leaf, column] = min(high[split.leaf, column], split.bound)
    return low, high


def _cut(quotients: Floats, masses: Floats, target: Floats) -> float:
    """Smallest quotient that can replace the largest one, since almost none of the target density lies above it.

    Args:
        quotients: [m] target density divided by the density of the grammar.
        masses: [m] density of the grammar.
        target: [m] their product.
    """
    order = np.argsort(-quotients, kind="stable")
    high = quotients[order]
    above = np.cumsum(target[order]) - np.cumsum(masses[order]) * high
    index = int(np.searchsorted(np.maximum.accumulate(above), MIN_SHARE * target.sum(), side="right"))
    return float(high[max(index - 1, 0)])


def _quotient(values: Floats, divisor: Floats) -> Floats:
    return np.divide(values, divisor, out=np.zeros(len(divisor)), where=divisor > 0.0)


def _worth(part: _Part) -> float:
    """Acceptance rate of a candidate, reduced for each of its splits."""
    return part.rate * _MIN_RATE_FACTOR ** len(part.preference.tree if part.preference else ())


def _countable(features: Sequence[Feature], grammar: Grammar, learned: LearnedGrammar) -> bool:
    """Whether the draws of features have the same names and meanings in the new grammar."""
    changed_rules = {origin.key[0] for origin in learned.origins.values()}
    changed_attributes = {parts.name for parts in learned.attributes}
    for feature in features:
        inner = feature.feature if isinstance(feature, Present) else feature
        for site in sites_of(inner):
            # Draws are numbered within their definition; a part of an attribute has not all of them.
            definition, _, number = site.partition("#")
            is_cut = definition in changed_attributes and (number or not range_ends(grammar, definition))
            if definition in changed_rules or is_cut:
                return False
    return True


def _mean(rule: Acceptance, density: PoolDensity) -> float:
    """Share of the models of the original rules that the original acceptance rule keeps."""
    program = compile_grammar(density.target.grammar)
    forests = derive_chunks(program, PILOT_MODELS, 0, assets=density.target.assets)
    return float(np.concatenate([rule.probabilities(forest) for forest in forests]).mean())


class _Rule(NamedTuple):
    """An acceptance rule."""

    text: str
    """Expression, at most 1."""
    rate: float
    """Share of the models of the grammar that it keeps."""
    preference: SimplifiedPreference
    """Function that the grammar and the rule follow together."""
    js: float
    """Divergence in nats of this function from the predictions, on the pool."""


def _rule_for_all(density: PoolDensity, predicted: Simple, whole: _Part) -> _Rule:
    """The rule for the predicted function beside a grammar that does not follow it."""
    text = density.columns.text(predicted.preference.scaled(1.0 / whole.highest))
    return _Rule(text, whole.rate, predicted.preference, predicted.js)


def _rule_for_rest(
    density: PoolDensity, predicted: Simple, part: _Part, function: SimplifiedPreference, learned: LearnedGrammar
) -> _Rule | None:
    """The shorter one of two rules for what a grammar leaves open; None if both read draws that it changed.

    One is the quotient of the predicted function and that of the grammar, and the other a function of its own, which
    names only what the grammar does not express.

    Args:
        density: the target density.
        predicted: the predicted function.
        part: what the grammar follows.
        function: the function of the part.
        learned: the grammar.
    """
    columns, grammar = density.columns, density.target.grammar
    below = columns.text(function.scaled(part.highest))
    quotient = _Rule(f"{columns.text(predicted.preference)} / {below}", part.rate, predicted.preference, predicted.js)
    kept = np.array([_countable([feature], grammar, learned) for feature in columns.features])
    near = [rule for rule in _rest(density, function, kept) if rule.js <= max(TOLERANCE, predicted.js)]
    if kept[predicted.preference.columns].all() and kept[function.columns].all():
        near.append(quotient)
    return min(near, key=lambda rule: len(rule.text), default=None)


def _rest(density: PoolDensity, part: SimplifiedPreference, kept: Flags) -> Iterator[_Rule]:
    """Rules of their own for what a function leaves open: of columns that matter, and of all, as far as these are kept.

    Args:
        density: the target density.
        part: the function.
        kept: [F] columns that may be read.
    """
    columns, values = density.columns, part(density.columns.rows)
    open_values, weights = _quotient(density.scores, values), density.weights * values
    for column_set in density.column_sets(exact_only=False) if weights @ open_values > 0.0 else ():
        readable = column_set[kept[column_set]]
        rest = next(simpler(columns.rows, open_values, weights, readable, max(_LEAVES))).preference
        rest = rest.scaled(1.0 / max(rest.levels))
        both = part.times(rest)
        js = agreement(density.scores, both(columns.rows), density.weights).js
        rate = float(weights @ rest(columns.rows) / weights.sum())
        yield _Rule(columns.text(rest), rate, both, js)
