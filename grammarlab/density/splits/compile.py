"""Exact compile: from a grammar and a preference that reads counts, to a grammar in proportion to both.

The density is p(m) u(m) / Z, with p the density of the grammar, u the preference and Z the mean of u under p
(``base="grammar"``). With ``base="uniform"``, every way to carry out the choices that the preference can reach counts
the same: p is left out for all symbols whose trees can be counted, and drawn numbers stay even.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from grammarlab.density.counting.attributes import AttributeParts, attribute_parts
from grammarlab.density.counting.automaton import Automaton, count_automaton
from grammarlab.density.counting.components import NO_CAP, PatternComponents, Reading
from grammarlab.density.counting.reading import Read
from grammarlab.density.rounding import EXACT
from grammarlab.density.skeleton import TreeGrammar
from grammarlab.density.splits.inside import InsideWeights
from grammarlab.density.splits.learned import LearnedGrammar
from grammarlab.density.splits.splitting import MOST_WAYS, Base, split
from grammarlab.density.splits.writing import write
from grammarlab.derivation.forest import Forest
from grammarlab.errors import GrammarlabError, InexactError
from grammarlab.features.patterns.pattern import Draw, HalfSpace, Pattern, Present, Sum, Threshold
from grammarlab.language.call_order import groups
from grammarlab.language.grammar import Grammar

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Preference = Callable[[Floats], Floats]
"""From the values [n, reads] of what it reads to values [n], finite and at least 0; each row on its own."""

RECURSIVE_CAP = 12
"""Where a grammar is recursive, counts from here on are taken to be one unless a cap is given."""


def compile_density(
    grammar: Grammar,
    reads: Sequence[Read],
    preference: Preference,
    *,
    base: Base = "grammar",
    forest: Forest | None = None,
    cap: int | None = None,
    max_ways: int = MOST_WAYS,
    step: float = EXACT,
    header: Sequence[str] = (),
    assets: Path | None = None,
) -> LearnedGrammar:
    """The grammar whose density is that of a grammar times a preference.

    Args:
        grammar: the original grammar.
        reads: what the preference reads: patterns, sums of them, and thresholds or choices of drawn attributes.
        preference: from their values to a score.
        base: what the preference multiplies.
        forest: derivations of the grammar that show how often successors inside blocks occur, where the text does not
            tell; without it, only parts of splits that do not repeat are taken to occur once.
        cap: counts from here on are taken to be one; by default only where the grammar is recursive.
        max_ways: so many alternatives the split symbols may have.
        step: what probabilities are rounded to multiples of: the density is then near the wanted one only.
        header: lines of a comment at the top of the new file.
        assets: folder of meshes and images, for sampling.

    Raises:
        InexactError: when no grammar of this form has that density, or it would be too large; says why.
        GrammarlabError: when the preference is 0 for every model, or no derivation ends.
    """
    tree = TreeGrammar.of(grammar)
    if forest is not None:
        tree = tree.observed(forest)
    wanted = _Wanted.of(grammar, reads, preference)
    automaton, findings = _counting(tree, wanted, cap)
    if not len(automaton.states[tree.start]):
        raise GrammarlabError(f"no derivation of {tree.start[0]} ends: every way to rewrite it leads back to itself")
    splitting = split(automaton, wanted.attributes, wanted.scores, base, max_ways)
    weights = InsideWeights(splitting)
    total = sum(
        component.weight * weights.of(component.start) * _drawn_mean(wanted.attributes, component.attributes, base)
        for component in splitting.components
    )
    if not total > 0.0:
        raise GrammarlabError(_nothing_liked(automaton, wanted.counted))
    written = write(grammar, splitting, weights, header, step=step)
    return LearnedGrammar(
        text=written.text,
        original=grammar,
        method="compile",
        base=base,
        origins=written.origins,
        start=written.start,
        components=written.components,
        attributes=wanted.attributes,
        mean_preference=total,
        findings=findings,
        assets=assets,
    )


@dataclass(frozen=True)
class _Wanted:
    """What a preference reads, sorted by how it is followed."""

    preference: Preference
    counted: tuple[Reading, ...]
    """What is counted in trees."""
    attributes: tuple[AttributeParts, ...]
    """The drawn attributes that are read."""
    order: tuple[int, ...]
    """[reads] where each value that is read stands: among the counts first, then among what attributes say."""

    @classmethod
    def of(cls, grammar: Grammar, reads: Sequence[Read], preference: Preference) -> _Wanted:
        wanted = tuple(countable(item) for item in reads)
        counted = tuple(dict.fromkeys(item for item in wanted if isinstance(item, Reading)))
        drawn: dict[str, list[Threshold | Draw]] = {}
        for item in dict.fromkeys(wanted):
            if isinstance(item, Threshold | Draw):
                drawn.setdefault(item.site, []).append(item)
        attributes = tuple(attribute_parts(grammar, name, found) for name, found in drawn.items())
        place = {item: i for i, item in enumerate([*counted, *(f for found in drawn.values() for f in found)])}
        return cls(preference, counted, attributes, tuple(place[item] for item in wanted))

    def scores(self, counts: Ints, parts: Ints) -> Floats:
        """The preference [n] of counts [n, counted], and of what the attributes say [n, attribute features]."""
        values = np.concatenate([counts, parts], axis=1)[:, self.order].astype(np.float64)
        found = np.asarray(self.preference(values), dtype=np.float64)
        if found.shape != (len(values),) or not np.isfinite(found).all() or (found < 0.0).any():
            raise GrammarlabError(
                f"expected a preference with one value a model, finite and at least 0; found shape {found.shape}"
                + (f" with {found.min()} to {found.max()}" if found.size else "")
            )
        return found

    def scores_of_counts(self, counts: Ints) -> Floats:
        """The preference [n] of counts [n, counted], where attributes say nothing."""
        return self.scores(counts, np.zeros((len(counts), sum(a.counts.shape[1] for a in self.attributes)), dtype=int))


def _counting(tree: TreeGrammar, wanted: _Wanted, cap: int | None) -> tuple[Automaton, tuple[str, ...]]:
    """The automaton that counts what is wanted, and what a person should know about it."""
    components = PatternComponents(tree, wanted.counted)
    limit = cap if cap is not None else RECURSIVE_CAP if _is_recursive(components) else NO_CAP
    cut = tuple(replace(reading, cap=min(reading.cap, limit)) for reading in wanted.counted)
    automaton = count_automaton(components if cut == wanted.counted else PatternComponents(tree, cut))
    imposed = np.array([new.cap < old.cap for new, old in zip(cut, wanted.counted, strict=True)], dtype=bool)
    if not (automaton.totals >= limit)[:, imposed].any():
        return automaton, ()
    _check_cap(automaton.totals, imposed, limit, wanted.scores_of_counts)
    return automaton, (f"counts from {limit} on are taken to be one, because the grammar is recursive",)


def countable(item: Read) -> Reading | Threshold | Draw:
    """What a preference reads, in the forms that can be computed exactly."""
    if isinstance(item, Present):
        inner = countable(item.feature)
        return replace(inner, cap=1) if isinstance(inner, Reading) else inner
    if isinstance(item, HalfSpace | Sum):
        raise InexactError(f"{item} joins several drawn numbers: an exact grammar can only cut each on its own")
    return Reading.of(item) if isinstance(item, Pattern) else item


def _is_recursive(components: PatternComponents) -> bool:
    """Whether a symbol that matters leads back to itself."""
    calls = components.calls
    return any(len(group) > 1 or any(key in calls[key] for key in group) for group in groups(calls))


def _check_cap(counts: Ints, imposed: NDArray[np.bool_], cap: int, scores: Callable[[Ints], Floats]) -> None:
    """Makes sure that a preference does not tell apart counts that are taken to be one.

    Raises:
        InexactError: when it does, as far as a few larger counts show.
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
    """The mean of what a component makes of the drawn attributes."""
    own = [parts.probabilities if base == "grammar" else parts.shares for parts in attributes]
    return float(np.prod([p @ future for p, future in zip(own, futures, strict=True)]))


def _nothing_liked(automaton: Automaton, readings: Sequence[Reading]) -> str:
    totals = automaton.totals
    absent = [str(reading) for i, reading in enumerate(readings) if not totals[:, i].any()]
    hint = f"; {', '.join(absent[:3])} never occurs in this grammar" if absent else ""
    return f"the preference is 0 for every model that the grammar makes: there is nothing to sample{hint}"
