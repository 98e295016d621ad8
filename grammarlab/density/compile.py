"""Exact compile: from a grammar and a preference that reads counts, to a grammar in proportion to both.

The density is p(m) u(m) / Z, with p the density of the grammar, u the preference and Z the mean of u under p
(``base="grammar"``). With ``base="uniform"``, every way to carry out the choices that the preference can reach counts
the same: p is left out for all symbols whose trees can be counted, and drawn numbers stay even.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from grammarlab.density.attributes import AttributeParts, attribute_parts
from grammarlab.density.automaton import Automaton, count_automaton
from grammarlab.density.components import NO_CAP, Components, Reading
from grammarlab.density.graph import groups
from grammarlab.density.learned import LearnedGrammar
from grammarlab.density.reading import Read, read
from grammarlab.density.skeleton import TreeGrammar
from grammarlab.density.splitting import Base, split
from grammarlab.density.weights import Weights
from grammarlab.density.writing import write
from grammarlab.derivation.forest import Forest
from grammarlab.errors import GrammarlabError, InexactError
from grammarlab.features.pattern import Draw, HalfSpace, Pattern, Present, Threshold
from grammarlab.features.score import Score
from grammarlab.language.grammar import Grammar

Floats = NDArray[np.float64]
Preference = Callable[[Floats], Floats]
"""From the values [n, reads] of what it reads to values [n], finite and at least 0; each row on its own."""

RECURSIVE_CAP = 12
"""Where a grammar is recursive, counts from here on are taken to be one unless a cap is given."""


def compile_score(
    grammar: Grammar,
    score: Score,
    *,
    base: Base = "grammar",
    forest: Forest | None = None,
    header: Sequence[str] = (),
    assets: Path | None = None,
) -> LearnedGrammar:
    """The grammar whose density is that of a grammar times a score; see `compile_density`."""
    reads, rest = read(score.expression)

    def preference(values: Floats) -> Floats:
        return np.clip(rest(values), 0.0, 100.0)

    return compile_density(grammar, reads, preference, base=base, forest=forest, header=header, assets=assets)


def compile_density(
    grammar: Grammar,
    reads: Sequence[Read],
    preference: Preference,
    *,
    base: Base = "grammar",
    forest: Forest | None = None,
    cap: int | None = None,
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
        header: lines of a comment at the top of the new file.
        assets: folder of meshes and images, for sampling.

    Raises:
        InexactError: when no grammar of this form has that density, or it would be too large; says why.
        GrammarlabError: when the preference is 0 for every model, or no derivation ends.
    """
    tree = TreeGrammar.of(grammar)
    if forest is not None:
        tree = tree.observed(forest)
    wanted = tuple(countable(item) for item in reads)
    counted = tuple(dict.fromkeys(item for item in wanted if isinstance(item, Reading)))
    drawn = _by_attribute(wanted)
    attributes = tuple(attribute_parts(grammar, name, found) for name, found in drawn.items())
    components = Components(tree, counted)
    limit = cap if cap is not None else RECURSIVE_CAP if _is_recursive(components) else NO_CAP
    cut = tuple(replace(reading, cap=min(reading.cap, limit)) for reading in counted)
    automaton = count_automaton(components if cut == counted else Components(tree, cut))
    if not len(automaton.states[tree.start]):
        raise GrammarlabError(f"no derivation of {tree.start[0]} ends: every way to rewrite it leads back to itself")
    columns = {item: i for i, item in enumerate([*counted, *(f for found in drawn.values() for f in found)])}
    order = [columns[item] for item in wanted]

    def scores(counts: NDArray[np.int64], parts: NDArray[np.int64]) -> Floats:
        return _checked(preference, np.concatenate([counts, parts], axis=1)[:, order].astype(np.float64))

    imposed = np.array([new.cap < old.cap for new, old in zip(cut, counted, strict=True)], dtype=bool)
    findings: list[str] = []
    if (automaton.totals >= limit)[:, imposed].any():
        _check_cap(automaton.totals, imposed, limit, lambda counts: scores(counts, _no_parts(counts, drawn)))
        findings.append(f"counts from {limit} on are taken to be one, because the grammar is recursive")
    splitting = split(automaton, attributes, scores, base)
    weights = Weights(splitting)
    total = sum(
        component.weight * weights.of(component.start) * _drawn_mean(attributes, component.attributes, base)
        for component in splitting.components
    )
    if not total > 0.0:
        raise GrammarlabError(_nothing_liked(automaton, counted))
    written = write(grammar, splitting, weights, header)
    return LearnedGrammar(
        written.text,
        grammar,
        "compile",
        base,
        written.origins,
        written.start,
        written.components,
        attributes,
        total,
        tuple(findings),
        assets,
    )


def countable(item: Read) -> Reading | Threshold | Draw:
    """What a preference reads, in the forms that can be computed exactly."""
    if isinstance(item, Present):
        inner = countable(item.feature)
        return replace(inner, cap=1) if isinstance(inner, Reading) else inner
    if isinstance(item, HalfSpace):
        raise InexactError(f"{item} joins several drawn numbers: an exact grammar can only cut each on its own")
    return Reading.of(item) if isinstance(item, Pattern) else item


def _by_attribute(reads: Sequence[Reading | Threshold | Draw]) -> dict[str, list[Threshold | Draw]]:
    """The features of drawn attributes, by the name of the attribute."""
    found: dict[str, list[Threshold | Draw]] = {}
    for item in dict.fromkeys(reads):
        if isinstance(item, Threshold | Draw):
            found.setdefault(item.site, []).append(item)
    return found


def _is_recursive(components: Components) -> bool:
    """Whether a symbol that matters leads back to itself."""
    calls = {
        key: [below for below in found if components.active[below]]
        for key, found in components.calls.items()
        if components.active[key]
    }
    return any(len(group) > 1 or any(key in calls[key] for key in group) for group in groups(calls))


def _checked(preference: Preference, values: Floats) -> Floats:
    found = np.asarray(preference(values), dtype=np.float64)
    if found.shape != (len(values),) or not np.isfinite(found).all() or (found < 0.0).any():
        raise GrammarlabError(
            f"expected a preference with one value a model, finite and at least 0; found shape {found.shape}"
            + (f" with {found.min()} to {found.max()}" if found.size else "")
        )
    return found


def _no_parts(counts: NDArray[np.int64], drawn: dict[str, list[Threshold | Draw]]) -> NDArray[np.int64]:
    return np.zeros((len(counts), sum(map(len, drawn.values()))), dtype=np.int64)


def _check_cap(
    counts: NDArray[np.int64], imposed: NDArray[np.bool_], cap: int, scores: Callable[[NDArray[np.int64]], Floats]
) -> None:
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
