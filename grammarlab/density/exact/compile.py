"""Exact compile: from a grammar and a preference that reads counts to a grammar of their product.

The density is p(m) u(m) / Z, with p the density of the grammar, u the preference and Z the mean of u under p
(``base="grammar"``). With ``base="uniform"``, all outcomes of the choices that the preference can reach have the same
weight: p is left out for all symbols with finitely many trees, and drawn numbers stay uniform. `Exactness` says which
features an exact grammar can express.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import Floats, Ints
from grammarlab.asset_roots import AssetRoot
from grammarlab.density.exact.attributes import AttributeParts, attribute_parts
from grammarlab.density.exact.automaton import Automaton, count_automaton
from grammarlab.density.exact.grammar_text import write
from grammarlab.density.exact.inside import InsideWeights
from grammarlab.density.exact.learned import LearnedGrammar
from grammarlab.density.exact.readings import Read, read
from grammarlab.density.exact.splitting import MAX_WAYS, Base, split
from grammarlab.density.exact.subtree_counts import NO_CAP, PatternComponents, Reading
from grammarlab.density.grammar_skeleton import TreeGrammar
from grammarlab.density.rounding import EXACT
from grammarlab.derivation.forest import Forest
from grammarlab.errors import GrammarlabError, InexactError
from grammarlab.features.expression import Expression
from grammarlab.features.patterns.pattern import Draw, Feature, Formula, Pattern, Present, Threshold
from grammarlab.language.call_order import groups
from grammarlab.language.grammar import Grammar

Preference = Callable[[Floats], Floats]
"""Function from the values [n, reads] of readings to values [n], finite and at least 0, row by row."""
_RECURSIVE_CAP = 12
"""Default cap of counts in recursive grammars: counts of this or more are treated as equal."""


@dataclass(frozen=True)
class Exactness:
    """Features that exact grammars made from one grammar can express."""

    grammar: Grammar
    forest: Forest
    """Derivations for the numbers of successors inside blocks."""

    def reason_against(self, feature: Feature) -> str:
        """Reason why an exact grammar cannot express a feature; empty if it can."""
        reads = read(Expression.of(feature))[0] if isinstance(feature, Formula) else (feature,)
        try:
            items = [_countable(item) for item in reads]
            readings = [replace(item, cap=min(item.cap, _RECURSIVE_CAP)) for item in items if isinstance(item, Reading)]
            if readings:
                count_automaton(PatternComponents(self._tree, tuple(readings)))
            for item in items:
                if not isinstance(item, Reading):
                    attribute_parts(self.grammar, item.site, [item])
        except InexactError as error:
            return str(error)
        return ""

    @cached_property
    def _tree(self) -> TreeGrammar:
        return TreeGrammar.of(self.grammar).observed(self.forest)


def compile_density(
    grammar: Grammar,
    reads: Sequence[Read],
    preference: Preference,
    *,
    base: Base = "grammar",
    forest: Forest | None = None,
    cap: int | None = None,
    max_ways: int = MAX_WAYS,
    step: float = EXACT,
    min_share: float = 0.0,
    header: Sequence[str] = (),
    assets: AssetRoot | None = None,
) -> LearnedGrammar:
    """Grammar whose density is that of a grammar times a preference.

    Args:
        grammar: the original grammar.
        reads: what the preference reads: patterns, sums of them, and thresholds or choices of drawn attributes.
        preference: from their values to a score.
        base: the density that the preference multiplies.
        forest: derivations of the grammar for the numbers of successors inside blocks, if the text does not determine
            them; without it, only parts of splits that do not repeat are assumed to occur once.
        cap: counts of this or more are treated as equal; by default only in recursive grammars.
        max_ways: largest number of alternatives of the split symbols.
        step: probabilities are rounded to multiples of this: the density is then only near the target density.
        min_share: less probable branches may be left out (`grammarlab.density.exact.trimming`).
        header: lines of a comment at the top of the new file.
        assets: folder of meshes and images, for sampling.

    Raises:
        InexactError: If no grammar of this form has that density, or it would be too large; it states the reason.
        GrammarlabError: If the preference is 0 for every model, or no derivation ends.
    """
    tree = TreeGrammar.of(grammar)
    if forest is not None:
        tree = tree.observed(forest)
    readings = _Readings.of(grammar, reads, preference)
    automaton, findings = _counting(tree, readings, cap)
    if not len(automaton.states[tree.start]):
        raise GrammarlabError(f"no derivation of {tree.start[0]} ends: all its alternatives lead back to itself")
    splitting = split(automaton, readings.attributes, readings.scores, base, max_ways)
    weights = InsideWeights(splitting)
    total = sum(
        component.weight * weights.of(component.start) * _drawn_mean(readings.attributes, component.attributes, base)
        for component in splitting.components
    )
    if not total > 0.0:
        raise GrammarlabError(_nothing_liked(automaton, readings.counted))
    written = write(grammar, splitting, weights, header, step=step, min_share=min_share)
    return LearnedGrammar(
        text=written.text,
        original=grammar,
        method="compile",
        base=base,
        origins=written.origins,
        start=written.start,
        components=written.components,
        attributes=readings.attributes,
        mean_preference=total,
        findings=findings,
        assets=assets,
    )


def _countable(item: Read) -> Reading | Threshold | Draw:
    """Readings of a preference in forms that can be computed exactly."""
    if isinstance(item, Present):
        inner = _countable(item.feature)
        return replace(inner, cap=1) if isinstance(inner, Reading) else inner
    if isinstance(item, Formula):
        raise InexactError(f"{item} is a function of other features: give these, and the function in the preference")
    return Reading.of(item) if isinstance(item, Pattern) else item


@dataclass(frozen=True)
class _Readings:
    """Readings of a preference, by kind."""

    preference: Preference
    counted: tuple[Reading, ...]
    """Readings of counts in trees."""
    attributes: tuple[AttributeParts, ...]
    """Drawn attributes that the preference reads."""
    order: tuple[int, ...]
    """[reads] index of each reading: first the counts, then the attribute features."""

    @classmethod
    def of(cls, grammar: Grammar, reads: Sequence[Read], preference: Preference) -> _Readings:
        items = tuple(_countable(item) for item in reads)
        counted = tuple(dict.fromkeys(item for item in items if isinstance(item, Reading)))
        drawn: dict[str, list[Threshold | Draw]] = {}
        for item in dict.fromkeys(items):
            if isinstance(item, Threshold | Draw):
                drawn.setdefault(item.site, []).append(item)
        attributes = tuple(attribute_parts(grammar, name, features) for name, features in drawn.items())
        index_of = {item: i for i, item in enumerate([*counted, *(f for features in drawn.values() for f in features)])}
        return cls(preference, counted, attributes, tuple(index_of[item] for item in items))

    def scores(self, counts: Ints, parts: Ints) -> Floats:
        """The preference [n] of counts [n, counted] and attribute features [n, attribute features]."""
        values = np.concatenate([counts, parts], axis=1)[:, self.order].astype(np.float64)
        result = np.asarray(self.preference(values), dtype=np.float64)
        if result.shape != (len(values),) or not np.isfinite(result).all() or (result < 0.0).any():
            raise GrammarlabError(
                f"expected a preference with one value per model, finite and at least 0; found shape {result.shape}"
                + (f" with {result.min()} to {result.max()}" if result.size else "")
            )
        return result

    def scores_of_counts(self, counts: Ints) -> Floats:
        """The preference [n] of counts [n, counted], without attribute features."""
        return self.scores(counts, np.zeros((len(counts), sum(a.counts.shape[1] for a in self.attributes)), dtype=int))


def _counting(tree: TreeGrammar, readings: _Readings, cap: int | None) -> tuple[Automaton, tuple[str, ...]]:
    """The counting automaton, and remarks for the user about it."""
    components = PatternComponents(tree, readings.counted)
    limit = cap if cap is not None else _RECURSIVE_CAP if _is_recursive(components) else NO_CAP
    cut = tuple(replace(reading, cap=min(reading.cap, limit)) for reading in readings.counted)
    automaton = count_automaton(components if cut == readings.counted else PatternComponents(tree, cut))
    imposed = np.array([new.cap < old.cap for new, old in zip(cut, readings.counted, strict=True)], dtype=bool)
    if not (automaton.totals >= limit)[:, imposed].any():
        return automaton, ()
    _check_cap(automaton.totals, imposed, limit, readings.scores_of_counts)
    return automaton, (f"counts from {limit} on are treated as equal, because the grammar is recursive",)


def _is_recursive(components: PatternComponents) -> bool:
    """Whether a relevant symbol is recursive."""
    calls = components.calls
    return any(len(group) > 1 or any(key in calls[key] for key in group) for group in groups(calls))


def _check_cap(counts: Ints, imposed: NDArray[np.bool_], cap: int, scores: Callable[[Ints], Floats]) -> None:
    """Check that a preference does not distinguish counts that are treated as equal.

    Raises:
        InexactError: If it does, tested with a few larger counts.
    """
    usual = scores(counts)
    for more in (1, 2, 7, cap):
        larger = np.where(imposed & (counts >= cap), counts + more, counts)
        if (scores(larger) != usual).any():
            raise InexactError(
                f"the grammar is recursive and the preference still changes where something occurs more than {cap} "
                "times: score with comparisons such as {Branch} >= 3, or give a larger cap"
            )


def _drawn_mean(attributes: Sequence[AttributeParts], futures: Sequence[Floats], base: Base) -> float:
    """Mean weight of the drawn attributes in a component."""
    probabilities = [parts.probabilities if base == "grammar" else parts.shares for parts in attributes]
    return float(np.prod([p @ future for p, future in zip(probabilities, futures, strict=True)]))


def _nothing_liked(automaton: Automaton, readings: Sequence[Reading]) -> str:
    totals = automaton.totals
    absent = [str(reading) for i, reading in enumerate(readings) if not totals[:, i].any()]
    hint = f"; {', '.join(absent[:3])} never occurs in this grammar" if absent else ""
    return f"the preference is 0 for every model that the grammar makes: there is nothing to sample{hint}"
