"""Names for split symbols after what distinguishes them, and their conditions in words."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections import Counter
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import ROUNDING, Ints
from grammarlab.density.exact.name_words import (
    counted,
    joined,
    number_of,
    parts_of,
    place,
    plural,
    shared,
    short,
)
from grammarlab.density.exact.splitting import Splitting, Variant
from grammarlab.density.exact.subtree_counts import Component, Deep, tops
from grammarlab.density.exact.trimming import Ways
from grammarlab.density.grammar_skeleton import Alternative, leaves
from grammarlab.features.columns.formula_names import MOST_NAMED
from grammarlab.features.patterns.pattern import Pattern
from grammarlab.language.numbering import Branch, SymbolKey
from grammarlab.preference.base import LIKED_SHARE, NEGLIGIBLE_SHARE

_MAX_LENGTH = 40
"""Characters of a suffix."""
_DEGREES = {True: ("more", "mostly", "nearlyOnly"), False: ("fewer", "rarely", "hardlyAny")}
"""Words for how much a part that occurs once or not is preferred, or avoided."""


class AbstractNames(ABC):
    """Finds unused names for variants.

    Args:
        splitting: the splitting.
        used: used names.
    """

    def __init__(self, splitting: Splitting, used: Collection[str]) -> None:
        self._splitting = splitting
        self._used = set(used)

    def names(self, variants: Sequence[Variant], ways: Sequence[Ways]) -> list[str]:
        """New names for variants of one symbol: ``GroundFloor_office``, ``House_three_storeys``.

        Args:
            variants: the variants.
            ways: what the rule of each has.
        """
        suffixes = [self.suffixes(variant, way) for variant, way in zip(variants, ways, strict=True)]
        counts = Counter(suffix for own in suffixes for suffix in {*own, *_pairs(own)})
        chosen = [_distinct(own, counts) for own in suffixes]
        return [self.fresh(f"{variant.key[0]}_{suffix}") for variant, suffix in zip(variants, chosen, strict=True)]

    def fresh(self, base: str) -> str:
        """This name, with a number if it is used; the result is marked as used."""
        name, number = base, 1
        while name in self._used:
            number += 1
            name = f"{base}_{number}"
        self._used.add(name)
        return name

    @abstractmethod
    def suffixes(self, variant: Variant, ways: Ways) -> list[str]:
        """Suffixes that distinguish a variant from its symbol, best first; at least one.

        Args:
            variant: the variant.
            ways: what its rule has.
        """

    @abstractmethod
    def condition(self, variant: Variant) -> str:
        """Description of the trees of a variant: ``with GroundFloorOffice``."""


def _distinct(own: Sequence[str], counts: Mapping[str, int]) -> str:
    """The best suffix that no sibling has, or two that are together different; the best one if there is none.

    Args:
        own: suffixes of a variant.
        counts: number of siblings, with itself, that have each of these and of their pairs.
    """
    fitting = [suffix for suffix in (*own, *_pairs(own)) if len(suffix) <= _MAX_LENGTH]
    best = fitting[0] if fitting else own[0][:_MAX_LENGTH].rstrip("_")
    return next((suffix for suffix in fitting if counts[suffix] == 1), best)


def _pairs(suffixes: Sequence[str]) -> list[str]:
    """The best suffix with each other one that is about something else."""
    first, *rest = suffixes
    return [f"{first}_{other}" for other in rest if other.rpartition("_")[2] != first.rpartition("_")[2]]


class _Number(NamedTuple):
    """What the number of one part says about a variant."""

    states: NDArray[np.bool_]
    """States with a number of the part that the variant allows."""
    text: str


class SplitNames(AbstractNames):
    """Names variants after the branches that they have, or after the numbers of parts that have outside weight."""

    def __init__(self, splitting: Splitting, used: Collection[str]) -> None:
        super().__init__(splitting, used)
        self._components = splitting.automaton.components
        self._varying_of: dict[SymbolKey, dict[int, int]] = {}
        self._symbols_below: dict[SymbolKey, frozenset[str]] = {}

    def condition(self, variant: Variant) -> str:
        allowed = self._order(variant, variant.future > 0.0)
        refused = self._order(variant, variant.future <= 0.0)
        rarer = [state for state in allowed if variant.future[state] < 1.0]
        is_without = len(allowed) > 1 and not list(self._counts(variant, allowed[-1]))
        if not rarer and is_without and 0 < len(refused) <= MOST_NAMED:
            # Beside another state, the one without counts would deny what the other one says.
            return f"never {' or '.join(self._state(variant, state) for state in refused)}"
        if not rarer and len(allowed) <= MOST_NAMED:
            return " or ".join(self._state(variant, state) for state in allowed)
        if len(rarer) > MOST_NAMED or len(refused) > MOST_NAMED:
            return f"of {len(allowed)} of {len(variant.future)} kinds" + (", with other percentages" if rarer else "")
        ratios = [f"{variant.future[state]:.2g} times as often {self._state(variant, state)}" for state in rarer]
        never = f"never {' or '.join(self._state(variant, state) for state in refused)}" if refused else ""
        return ", ".join(filter(None, (*ratios, never)))

    def _order(self, variant: Variant, chosen: NDArray[np.bool_]) -> list[int]:
        """The chosen states; the state without counts comes last."""
        return sorted(np.flatnonzero(chosen).tolist(), key=lambda state: not list(self._counts(variant, state)))

    def suffixes(self, variant: Variant, ways: Ways) -> list[str]:
        found = [self._by_branches(variant, ways), self._by_numbers(variant), self._by_weights(variant)]
        return list(dict.fromkeys(filter(None, found))) or ["learned"]

    def _by_branches(self, variant: Variant, ways: Ways) -> str:
        """The branches of its rule, if these are few, or the only one that it lacks."""
        alternatives = [a for a in self._components.tree.alternatives(variant.key) if a.branch is not None]
        words = _branch_words(variant.key, alternatives, self._components.tree.words)
        is_kept = [bool(ways.get(alternative.branch)) for alternative in alternatives]
        present = [word for word, kept in zip(words, is_kept, strict=True) if kept]
        absent = [word for word, kept in zip(words, is_kept, strict=True) if not kept]
        if not absent or not all(words) or len(set(words)) < len(words):
            return ""
        if len(absent) == 1 < len(present):
            return f"not_{absent[0]}"
        return "_or_".join(present) if len(present) <= MOST_NAMED else ""

    def _by_numbers(self, variant: Variant) -> str:
        """The numbers of parts below it, as far as these distinguish the trees that it allows."""
        allowed = variant.future > 0.0
        rest, words = np.ones(len(allowed), dtype=np.bool_), list[str]()
        numbers = list(self._numbers(variant, allowed))
        while numbers and len(words) < MOST_NAMED and (rest & ~allowed).any():
            best = min(numbers, key=lambda number: (int((rest & number.states).sum()), len(number.text), number.text))
            if (rest & best.states).sum() == rest.sum():
                break
            rest, words = rest & best.states, [*words, best.text]
        return "_".join(words)

    def _by_weights(self, variant: Variant) -> str:
        """The part whose number is most preferred, or avoided, and how much."""
        strongest: tuple[float, str] = NEGLIGIBLE_SHARE, "weighted"
        for component, column in self._columns(variant):
            strength = float(np.corrcoef(variant.future, column)[0, 1]) if np.ptp(variant.future) > 0.0 else 0.0
            word = self._word(component, variant.key[0])
            is_liked = strength > 0.0
            if column.max() == 1:
                more, less = (
                    float(variant.future[column == count].max(initial=0.0)) for count in (is_liked, not is_liked)
                )
                text = f"{_DEGREES[is_liked][_degree(less / more)]}_{word}"
            else:
                text = f"{'more' if is_liked else 'fewer'}_{plural(word)}"
            if abs(strength) > strongest[0] + ROUNDING:
                strongest = abs(strength), text
        return strongest[1]

    def _numbers(self, variant: Variant, allowed: NDArray[np.bool_]) -> Iterator[_Number]:
        """What the numbers of parts say about a variant, as far as they exclude something."""
        for component, column in self._columns(variant):
            possible, some = np.unique(column).tolist(), np.unique(column[allowed])
            text = counted(self._word(component, variant.key[0]), set(some.tolist()), possible)
            if text:
                yield _Number(np.isin(column, some), text)

    def _columns(self, variant: Variant) -> Iterator[tuple[Component, Ints]]:
        """Components that differ between the states of a variant, with their values [S]."""
        states = self._splitting.automaton.states[variant.key]
        for i, column in self._varying(variant).items():
            yield self._components.all[i], states[:, column]

    def _word(self, component: Component, symbol: str) -> str:
        """A component as a part of a name of a split symbol."""
        if isinstance(component, Deep):
            return self._short(component.below.run[-1], symbol)
        first, *others = tops(component)
        common = shared([self._named(pattern) for pattern in (first, *others)]) if others else ""
        return common or self._short(first, symbol)

    def _named(self, pattern: Pattern) -> str:
        """The symbol that a pattern is about: that of its lowest node, or of what only its branch makes."""
        while pattern.below:
            pattern = pattern.below[-1].run[-1]
        return (
            (self._unique_successor(pattern) if pattern.branch and pattern.symbol else "") or pattern.symbol or "part"
        )

    def _short(self, pattern: Pattern, symbol: str) -> str:
        """A word for a pattern inside the name of a symbol: ``GroundFloorOffice`` is ``office`` in ``GroundFloor``."""
        named = self._named(pattern)
        word = short(named, symbol)
        while pattern.below:
            pattern = pattern.below[-1].run[-1]
        is_branch = bool(pattern.branch) and named in (pattern.symbol, "part")
        if not is_branch:
            return word
        if said := self._said(pattern):
            return joined(parts_of(said))
        which = place(pattern.branch or ())
        return which if named == symbol else f"{which}{word[:1].upper()}{word[1:]}"

    def _said(self, pattern: Pattern) -> str:
        """What the branch of a pattern of one node alone says; empty if this is no word for a name."""
        words = self._words.get((pattern.symbol, pattern.branch), frozenset())
        word = next(iter(words)) if len(words) == 1 else ""
        return word if word[:1].isalpha() else ""

    @cached_property
    def _words(self) -> Mapping[tuple[str | None, Branch | None], frozenset[str]]:
        """What the branches of all rules of a symbol say."""
        words: dict[tuple[str | None, Branch | None], frozenset[str]] = {}
        for (key, branch), word in self._components.tree.words.items():
            words[key[0], branch] = words.get((key[0], branch), frozenset()) | {word}
        return words

    def _state(self, variant: Variant, state: int) -> str:
        """Description of a state."""
        texts = [
            text if count == 1 else f"{count} {text}"
            for text, count in (
                (self._text(component, variant.key), n) for component, n in self._counts(variant, state)
            )
        ]
        if texts:
            return "with " + " and ".join(texts)
        absent = [self._text(self._components.all[i], variant.key) for i in self._varying(variant)]
        more = f" or {len(absent) - MOST_NAMED} others" if len(absent) > MOST_NAMED else ""
        return "without " + " or ".join(absent[:MOST_NAMED]) + more

    def _counts(self, variant: Variant, state: int) -> Iterator[tuple[Component, int]]:
        """The components that are above zero in a state, without those that are the same in all states.

        Of several that are equal in all states the first one about a symbol with a rule is enough.
        """
        states = self._splitting.automaton.states[variant.key]
        ruled = {key[0] for key in self._components.tree.bodies}
        varying = sorted(self._varying(variant).items(), key=lambda item: self._named_by(item[0]) not in ruled)
        first: dict[bytes, int] = {}
        for i, column in varying:
            first.setdefault(states[:, column].tobytes(), i)
        for i, column in self._varying(variant).items():
            count = int(states[state, column])
            if count and i in first.values():
                yield self._components.all[i], count

    def _named_by(self, component: int) -> str:
        """The symbol that a component is about; empty for one of several nodes."""
        found = self._components.all[component]
        return "" if isinstance(found, Deep) else self._named(tops(found)[0])

    def _varying(self, variant: Variant) -> dict[int, int]:
        """The components that differ between states, and their columns."""
        columns = self._varying_of.get(variant.key)
        if columns is None:
            states = self._splitting.automaton.states[variant.key]
            differs = (states != states[:1]).any(axis=0)
            active = self._components.active[variant.key]
            columns = {i: column for column, i in enumerate(active) if differs[column]}
            self._varying_of[variant.key] = columns
        return columns

    def _text(self, component: Component, key: SymbolKey) -> str:
        """Description of the parts of a component that a symbol can have."""
        if isinstance(component, Deep):
            return " + ".join(self._label(pattern) for pattern in component.below.run)
        patterns, below = tops(component), self._below(key)
        inside = [pattern for pattern in patterns if pattern.symbol is None or pattern.symbol in below]
        return " or ".join(dict.fromkeys(self._label(pattern) for pattern in inside or patterns))

    def _below(self, key: SymbolKey) -> frozenset[str]:
        """The symbols that the trees of a symbol can have, with itself."""
        symbols = self._symbols_below.get(key)
        if symbols is None:
            symbols = frozenset(name for name, _ in replace(self._components.tree, start=key).reachable)
            self._symbols_below[key] = symbols
        return symbols

    def _label(self, pattern: Pattern) -> str:
        """Text of a pattern; a single branch is named after the symbol it makes."""
        if pattern.below or not pattern.branch or pattern.symbol is None:
            return str(pattern)
        said = self._said(pattern)
        return self._unique_successor(pattern) or (f"{pattern.symbol} {said}" if said else str(pattern))

    def _unique_successor(self, pattern: Pattern) -> str:
        """The symbol that only this branch of a rule makes; empty if there is none."""
        tree = self._components.tree
        keys = [key for key in tree.bodies if key[0] == pattern.symbol]
        branches = [a for key in keys for a in leaves(tree.body(key)) if a.branch is not None]
        path = pattern.branch or ()
        inside = [{s.key[0] for s in a.successors} for a in branches if (a.branch or ())[: len(path)] == path]
        outside = {s.key[0] for a in branches if (a.branch or ())[: len(path)] != path for s in a.successors}
        unique = sorted(set.intersection(*inside) - outside) if inside else []
        return unique[0] if len(unique) == 1 else ""


def _degree(ratio: float) -> int:
    """How much rarer designs of a ratio to the others are: 0 if they are still liked beside these, 2 if hardly any is.

    >>> _degree(0.5), _degree(0.25), _degree(0.05), _degree(0.0)
    (0, 1, 2, 2)
    """
    return int(ratio <= LIKED_SHARE) + int(ratio <= LIKED_SHARE**2)


def _branch_words(
    key: SymbolKey, alternatives: Sequence[Alternative], said: Mapping[tuple[SymbolKey, Branch], str]
) -> list[str]:
    """[n] a word for each branch of a rule: what only it makes or says, how much, or else which branch it is."""
    symbol = key[0]
    made = [
        {s.key[0]: sum(o.copies or 1 for o in a.successors if o.key == s.key) for s in a.successors}
        for a in alternatives
    ]
    words: list[str] = []
    for number, own in enumerate(made):
        others = [other for index, other in enumerate(made) if index != number]
        only = [name for name in own if not any(name in other for other in others)]
        counts = [name for name in own if all(other.get(name, 0) != own[name] for other in others)]
        if only:
            words.append(short(only[0], symbol))
        elif counts:
            words.append(number_of(short(counts[0], symbol), own[counts[0]]))
        else:
            branch = alternatives[number].branch or ()
            word = said.get((key, branch), "")
            which = joined(parts_of(word)) if word[:1].isalpha() else place(branch)
            words.append(which if own or word else "nothing")
    return words
