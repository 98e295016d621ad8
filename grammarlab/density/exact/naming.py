"""Names for split symbols, and their conditions in words."""

from __future__ import annotations

import re
from abc import ABC, abstractmethod
from collections.abc import Collection, Iterator

import numpy as np
from numpy.typing import NDArray

from grammarlab.density.exact.splitting import Splitting, Variant
from grammarlab.density.exact.subtree_counts import Component, Deep, tops
from grammarlab.density.grammar_skeleton import leaves
from grammarlab.features.patterns.pattern import Pattern
from grammarlab.language.numbering import SymbolKey

_LONGEST = 40
"""Characters of a suffix."""
_MOST_WORDS = 3
"""Largest number of kinds of trees in a name."""
_MOST_STATES = 4
"""Largest number of kinds of trees in a comment; of more only the number is given."""


class AbstractNames(ABC):
    """Finds unused names for variants.

    Args:
        splitting: the splitting.
        taken: used names.
    """

    def __init__(self, splitting: Splitting, taken: Collection[str]) -> None:
        self._splitting = splitting
        self._taken = set(taken)

    def name(self, variant: Variant) -> str:
        """A new name for a variant: ``GroundFloor_office``."""
        return self.fresh(f"{variant.key[0]}_{self.suffix(variant)}")

    def fresh(self, base: str) -> str:
        """This name, with a number if it is used; the result is marked as used."""
        name, number = base, 1
        while name in self._taken:
            number += 1
            name = f"{base}_{number}"
        self._taken.add(name)
        return name

    @abstractmethod
    def suffix(self, variant: Variant) -> str:
        """Suffix that distinguishes a variant from its symbol."""

    @abstractmethod
    def condition(self, variant: Variant) -> str:
        """Description of the trees of a variant: ``with GroundFloorOffice``."""


class SplitNames(AbstractNames):
    """Names variants after the states with positive outside weight."""

    def __init__(self, splitting: Splitting, taken: Collection[str]) -> None:
        super().__init__(splitting, taken)
        self._components = splitting.automaton.components
        self._varying_of: dict[SymbolKey, dict[int, int]] = {}

    def condition(self, variant: Variant) -> str:
        wanted = self._order(variant, variant.future > 0.0)
        refused = self._order(variant, variant.future <= 0.0)
        even = bool((variant.future[wanted] == 1.0).all())
        if len(wanted) <= _MOST_STATES:
            states = [self._state(variant, i) + ("" if even else f" ({variant.future[i]:.3g})") for i in wanted]
            return " or ".join(states) + ("" if even else ", in these proportions")
        if even and len(refused) <= _MOST_STATES:
            return "but not " + " or ".join(self._state(variant, i) for i in refused)
        return f"of {len(wanted)} of {len(variant.future)} kinds" + ("" if even else ", in other proportions")

    def _order(self, variant: Variant, chosen: NDArray[np.bool_]) -> list[int]:
        """The chosen states; the state without counts comes last."""
        return sorted(np.flatnonzero(chosen).tolist(), key=lambda state: not list(self._counts(variant, state)))

    def suffix(self, variant: Variant) -> str:
        wanted = self._order(variant, variant.future > 0.0)
        refused = self._order(variant, variant.future <= 0.0)
        if len(refused) == 1 < len(wanted):
            return f"not_{self._word(variant, refused[0])}"[:_LONGEST]
        words = "_or_".join(dict.fromkeys(self._word(variant, state) for state in wanted[:_MOST_WORDS]))
        if len(wanted) <= _MOST_WORDS and len(words) <= _LONGEST:
            return words
        return "some" if refused else "weighted"

    def _state(self, variant: Variant, state: int) -> str:
        """Description of a state."""
        found = [
            self._text(component) if count == 1 else f"{count} x {self._text(component)}"
            for component, count in self._counts(variant, state)
        ]
        if found:
            return "with " + " and ".join(found)
        absent = [self._text(self._components.all[i]) for i in self._varying(variant)]
        more = f" or {len(absent) - _MOST_STATES} others" if len(absent) > _MOST_STATES else ""
        return "without " + " or ".join(absent[:_MOST_STATES]) + more

    def _word(self, variant: Variant, state: int) -> str:
        """A state as a part of a name."""
        words = [self._short(_top(component), variant.key[0]) for component, _ in self._counts(variant, state)]
        return "_".join(list(dict.fromkeys(words))[:2]) or "other"

    def _counts(self, variant: Variant, state: int) -> Iterator[tuple[Component, int]]:
        """The components that are above zero in a state, without those that are the same in all states."""
        for i, column in self._varying(variant).items():
            count = int(self._splitting.automaton.states[variant.key][state, column])
            if count:
                yield self._components.all[i], count

    def _varying(self, variant: Variant) -> dict[int, int]:
        """The components that differ between states, and their columns."""
        found = self._varying_of.get(variant.key)
        if found is None:
            states = self._splitting.automaton.states[variant.key]
            differs = (states != states[:1]).any(axis=0)
            active = self._components.active[variant.key]
            found = {i: column for column, i in enumerate(active) if differs[column]}
            self._varying_of[variant.key] = found
        return found

    def _text(self, component: Component) -> str:
        if isinstance(component, Deep):
            return " + ".join(self._label(pattern) for pattern in component.below.run)
        return " or ".join(self._label(pattern) for pattern in tops(component))

    def _label(self, pattern: Pattern) -> str:
        """Text of a pattern; a single branch is named after the symbol it makes."""
        if pattern.below or not pattern.branch or pattern.symbol is None:
            return str(pattern)
        return self._made_by(pattern) or str(pattern)

    def _made_by(self, pattern: Pattern) -> str:
        """The symbol that only this branch of a rule makes; empty if there is none."""
        tree = self._components.tree
        keys = [key for key in tree.bodies if key[0] == pattern.symbol]
        branches = [a for key in keys for a in leaves(tree.body(key)) if a.branch is not None]
        asked = pattern.branch or ()
        inside = [{s.key[0] for s in a.successors} for a in branches if (a.branch or ())[: len(asked)] == asked]
        outside = {s.key[0] for a in branches if (a.branch or ())[: len(asked)] != asked for s in a.successors}
        own = sorted(set.intersection(*inside) - outside) if inside else []
        return own[0] if len(own) == 1 else ""

    def _short(self, pattern: Pattern, symbol: str) -> str:
        """A word for a pattern inside the name of a symbol: ``GroundFloorOffice`` is ``office`` in ``GroundFloor``."""
        while pattern.below:
            pattern = pattern.below[-1].run[-1]
        made = self._made_by(pattern) if pattern.branch and pattern.symbol else ""
        word = re.sub(r"\W", "", made or pattern.symbol or "any")
        for cut in (word.removeprefix(symbol), word.removesuffix(symbol)):
            if cut and cut != word and re.match(r"[^\W\d]", cut):
                word = cut
                break
        if pattern.branch and not made:
            word += "_".join(map(str, pattern.branch))
        return word[:1].lower() + word[1:]


def _top(component: Component) -> Pattern:
    return component.below.run[-1] if isinstance(component, Deep) else tops(component)[0]
