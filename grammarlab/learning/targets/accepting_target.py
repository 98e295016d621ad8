"""A density as a grammar of moderate size and an acceptance rule: together they follow the predictions.

The grammar follows them as far as its size allows, so that many of its models are kept; the rule adds the rest.

Smallest grammar whose density is near enough to a predicted one.

Simple functions of few features (`grammarlab.learning.targets.simplification`) are compiled one after the other, and
compared by the number of branches of their rules.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import Floats
from grammarlab.density.exact.learned import LearnedGrammar, num_alternatives
from grammarlab.density.targets.accepted import AcceptedGrammar, product_with_own, split_symbols, with_rule
from grammarlab.density.targets.ranges import range_ends
from grammarlab.density.targets.rejection import RejectionSampler
from grammarlab.derivation.compiler import compile_grammar
from grammarlab.derivation.derive import derive_chunks
from grammarlab.derivation.forest import Forest
from grammarlab.features.acceptance import Acceptance
from grammarlab.features.expression import Expression
from grammarlab.features.patterns.pattern import Draw, Feature, HalfSpace, Present, Sum, Threshold
from grammarlab.language.grammar import Grammar
from grammarlab.learning.targets.simplification import TOLERANCE
from grammarlab.learning.targets.target_density import LONGEST, Simple, Wanted, compiled, rounded_off, rules_if_few
from grammarlab.learning.targets.writers import Making
from grammarlab.preference.regression_tree import Split, grow, leaves_of, means_of
from grammarlab.preference.simplified import SimplifiedPreference

_MARGIN = 2_000
"""Number of characters by which a text may grow when scores are scaled."""
_LEAVES = (2, 3, 4, 6, 8, 12, 16, 24, 32)
"""Largest number of leaves of trees for the grammar."""
_EMPHASES = (0.0, 10.0)
"""Factor of the weight of liked models: a larger one makes trees separate regions without liked models."""
_TRUNCATED = 1e-3
"""Share of the target density that may be too rare in the samples, so that fewer others are rejected."""
_PER_SPLIT = 0.97
"""Smallest factor of the acceptance rate by which a split pays for its rules."""
_LEAST_MODELS = 60
"""Smallest number of models of the pool in each leaf."""
_ENOUGH_LIKED = 200.0
"""Smallest effective number of liked models of the pool from which none in a leaf means that there are none."""
_RATE_MODELS = 2_000
"""Number of models for estimating the acceptance rate of an original grammar."""
_SMALLER = 0.75
"""Factor of the splits of the next candidate after a tree whose grammar is too large."""
_GAIN = 1.25
"""Smallest factor of the acceptance rate that a larger grammar needs."""


class _Part(NamedTuple):
    """A candidate function for the grammar."""

    preference: SimplifiedPreference | None
    """None for the original grammar."""
    highest: float
    """Largest quotient of the whole function and this one, on the pool."""
    rate: float
    """Share of its models that are kept."""


def with_acceptance(
    wanted: Wanted, forest: Forest, lines: Sequence[str], most: int, why: str
) -> tuple[AcceptedGrammar, SimplifiedPreference]:
    """Grammar of limited size with an acceptance rule, and the function that both together follow.

    Args:
        wanted: the target density.
        forest: derivations of the grammar that show how often successors inside blocks occur.
        lines: comment lines at the top of the new file.
        most: largest number of branches of the rules.
        why: reason why no grammar alone is used.
    """
    whole = wanted.simplest(exact_only=False)
    grammar = wanted.target.grammar
    header = [*lines, f"Method compile with acceptance, base {wanted.target.base}"]
    values = whole.preference(wanted.columns.rows)
    features = tuple(wanted.columns.features[column] for column in whole.preference.columns.tolist())
    best = _Part(None, float(values.max()), float(wanted.weights @ values / values.max() / wanted.weights.sum()))
    learned = wanted.target.even
    own = Acceptance.of(grammar.tree)
    if own is None:
        fitting = np.inf
        for part in sorted(_parts(wanted, whole.preference), key=_worth, reverse=True):
            if part.preference is None or len(wanted.columns.text(part.preference)) > LONGEST - _MARGIN:
                continue
            if _worth(part) < _GAIN * best.rate or len(part.preference.tree) > fitting:
                continue
            fitting = _SMALLER * len(part.preference.tree)
            made = compiled(wanted.as_target(part.preference), forest, (), most)
            if made is not None and rules_if_few(made, most) <= most and _countable(features, grammar, made):
                kept = _quotient(values, part.preference(wanted.columns.rows) * part.highest)
                target = wanted.as_target(part.preference)
                best, learned = part, rounded_off(wanted, target, forest, (), made, kept)
                break
    rate = best.rate if own is None else best.rate * _mean(own, wanted)
    text = _rule(wanted, whole, best)
    if learned is None:
        plain, rule = product_with_own(grammar, text)
        written = with_rule(plain, Acceptance(rule, {}), rate, header)
    else:
        rule = Expression.parse(text)
        acceptance = Acceptance(rule, split_symbols(learned, rule.features))
        written = with_rule(learned.grammar, acceptance, rate, header)
    findings = [f"{why}, so the file keeps {rate:.2g} of its models by an acceptance rule; other engines ignore it"]
    if whole.js > TOLERANCE:
        findings.append(
            f"the predictions need more features: {whole.js:.2g} nats of them were given up, which more scores may mend"
        )
    found = AcceptedGrammar(
        text=written,
        original=grammar,
        part=learned,
        rule=Expression.parse(text),
        mean=best.rate,
        accept_rate=rate,
        base=wanted.target.base,
        findings=tuple(findings),
        assets=wanted.target.assets,
    )
    return found, whole.preference


def _mean(own: Acceptance, wanted: Wanted) -> float:
    """Share of the models of the original rules that the original acceptance rule keeps."""
    program = compile_grammar(wanted.target.grammar)
    forests = derive_chunks(program, _RATE_MODELS, 0, assets=wanted.target.assets)
    return float(np.concatenate([own.probabilities(forest) for forest in forests]).mean())


def _parts(wanted: Wanted, whole: SimplifiedPreference) -> Iterator[_Part]:
    """Functions of few features that exact grammars express, and their acceptance rates."""
    columns = wanted.columns
    values = whole(columns.rows)
    liked = wanted.weights * values
    few_liked = bool(liked.sum() ** 2 < _ENOUGH_LIKED * (liked @ liked))
    exact = columns.order[columns.exact[columns.order]]
    share = values / (wanted.weights @ values / wanted.weights.sum())
    for emphasis in _EMPHASES:
        tree = grow(columns.rows, values, wanted.weights * (1.0 + emphasis * share), exact, max(_LEAVES), _LEAST_MODELS)
        for size in _LEAVES[: sum(size <= len(tree) + 1 for size in _LEAVES)]:
            leaf = leaves_of(tree[: size - 1], columns.rows)
            possible = np.logical_and(few_liked, _overlaps(tree[: size - 1], whole))
            highest = np.zeros(size)
            np.maximum.at(highest, leaf, values)
            for scores in (means_of(leaf, size, values, wanted.weights), highest):
                own = scores[leaf]
                quotient = _cut(_quotient(values, own), wanted.weights * own, wanted.weights * values)
                # Leaves whose liked models are too rare for the pool keep the largest value.
                above = np.where(possible & (scores == 0.0), values.max() / quotient, scores)
                rate = float(wanted.weights @ values / quotient / (wanted.weights @ above[leaf]))
                # A rate of 1 can be a little more in floats.
                yield _Part(SimplifiedPreference(tree[: size - 1], above).pruned(), quotient, min(rate, 1.0))


def _overlaps(tree: Sequence[Split], whole: SimplifiedPreference) -> NDArray[np.bool_]:
    """[leaves] whether ranges of columns of a leaf overlap with those of a positive leaf of another tree."""
    used = np.unique([split.column for split in (*tree, *whole.tree)])
    low, high = _ranges(tree, used)
    other_low, other_high = _ranges(whole.tree, used)
    overlap = (low[:, None] < other_high).all(axis=2) & (other_low < high[:, None]).all(axis=2)
    return np.any(overlap & (whole.scores > 0.0), axis=1)


def _ranges(tree: Sequence[Split], used: NDArray[np.number]) -> tuple[Floats, Floats]:
    """[leaves, columns] bounds of the leaves of a tree in the used columns: the lower one is included."""
    low, high = np.full((len(tree) + 1, len(used)), -np.inf), np.full((len(tree) + 1, len(used)), np.inf)
    for number, split in enumerate(tree, 1):
        column = int(np.searchsorted(used, split.column))
        low[number], high[number] = low[split.leaf], high[split.leaf]
        low[number, column] = max(low[number, column], split.bound)
        high[split.leaf, column] = min(high[split.leaf, column], split.bound)
    return low, high


def _worth(part: _Part) -> float:
    """Acceptance rate of a candidate, reduced for each of its splits."""
    return part.rate * _PER_SPLIT ** len(part.preference.tree if part.preference else ())


def _cut(quotients: Floats, masses: Floats, wanted: Floats) -> float:
    """Smallest quotient that can replace the largest one, since almost none of the target density lies above it.

    Args:
        quotients: [m] target density divided by the density of the grammar.
        masses: [m] density of the grammar.
        wanted: [m] their product.
    """
    order = np.argsort(-quotients, kind="stable")
    high = quotients[order]
    above = np.cumsum(wanted[order]) - np.cumsum(masses[order]) * high
    place = int(np.searchsorted(np.maximum.accumulate(above), _TRUNCATED * wanted.sum(), side="right"))
    return float(high[max(place - 1, 0)])


def _quotient(values: Floats, own: Floats) -> Floats:
    return np.divide(values, own, out=np.zeros(len(own)), where=own > 0.0)


def _rule(wanted: Wanted, whole: Simple, part: _Part) -> str:
    """The quotient of both functions as an expression, at most 1."""
    if part.preference is None:
        return wanted.columns.text(whole.preference.scaled(1.0 / part.highest))
    below = wanted.columns.text(part.preference.scaled(part.highest))
    return f"{wanted.columns.text(whole.preference)} / {below}"


def _countable(features: Sequence[Feature], grammar: Grammar, learned: LearnedGrammar) -> bool:
    """Whether the draws of features have the same names and meanings in the new grammar."""
    changed = {parts.name for parts in learned.attributes}
    for feature in features:
        inner = feature.feature if isinstance(feature, Present) else feature
        if not isinstance(inner, Draw | Threshold | HalfSpace | Sum):
            continue
        for site in _sites(inner):
            if site not in grammar.attributes or (site in changed and not range_ends(grammar, site)):
                return False
    return True


def _sites(feature: Draw | Threshold | HalfSpace | Sum) -> tuple[str, ...]:
    """Names of the draws that a feature reads."""
    if isinstance(feature, Sum):
        return tuple(term.site for term in feature.terms)
    return feature.sites if isinstance(feature, HalfSpace) else (feature.site,)


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
