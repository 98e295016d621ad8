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

_MAX_LENGTH = 40
"""Characters of a suffix."""
_MAX_WORDS = 3
"""Largest number of kinds of trees in a name."""
_MAX_STATES = 4
"""Largest number of kinds of trees in a comment; of more only the number is given."""


class AbstractNames(ABC):
    """Finds unused names for variants.

    Args:
        splitting: the splitting.
        taken: used names.
    """

    def __init__(self, splitting: Splitting, used: Collection[str]) -> None:
        self._splitting = splitting
        self._used = set(used)

    def name(self, variant: Variant) -> str:
        """A new name for a variant: ``GroundFloor_office``."""
        return self.fresh(f"{variant.key[0]}_{self.suffix(variant)}")

    def fresh(self, base: str) -> str:
        """This name, with a number if it is used; the result is marked as used."""
        name, number = base, 1
        while name in self._used:
            number += 1
            name = f"{base}_{number}"
        self._used.add(name)
        return name

    @abstractmethod
    def suffix(self, variant: Variant) -> str:
        """Suffix that distinguishes a variant from its symbol."""

    @abstractmethod
    def condition(self, variant: Variant) -> str:
        """Description of the trees of a variant: ``with GroundFloorOffice``."""


class SplitNames(AbstractNames):
    """Names variants after the states with positive outside weight."""

    def __init__(self, splitting: Splitting, used: Collection[str]) -> None:
        super().__init__(splitting, used)
        self._components = splitting.automaton.components
        self._varying_of: dict[SymbolKey, dict[int, int]] = {}

    def condition(self, variant: Variant) -> str:
        allowed = self._order(variant, variant.future > 0.0)
        refused = self._order(variant, variant.future <= 0.0)
        even = bool((variant.future[allowed] == 1.0).all())
        if len(allowed) <= _MAX_STATES:
            states = [self._state(variant, i) + ("" if even else f" ({variant.future[i]:.3g})") for i in allowed]
            return " or ".join(states) + ("" if even else ", in these proportions")
        if even and len(refused) <= _MAX_STATES:
            return "but not " + " or ".join(self._state(variant, i) for i in refused)
        return f"of {len(allowed)} of {len(variant.future)} kinds" + ("" if even else ", in other proportions")

    def _order(self, variant: Variant, chosen: NDArray[np.bool_]) -> list[int]:
        """The chosen states; the state without counts comes last."""
        return sorted(np.flatnonzero(chosen).tolist(), key=lambda state: not list(self._counts(variant, state)))

    def suffix(self, variant: Variant) -> str:
        allowed = self._order(variant, variant.future > 0.0)
        refused = self._order(variant, variant.future <= 0.0)
        if len(refused) == 1 < len(allowed):
            return f"not_{self._word(variant, refused[0])}"[:_MAX_LENGTH]
        words = "_or_".join(dict.fromkeys(self._word(variant, state) for state in allowed[:_MAX_WORDS]))
        if len(allowed) <= _MAX_WORDS and len(words) <= _MAX_LENGTH:
            return words
        return "some" if refused else "weighted"

    def _state(self, variant: Variant, state: int) -> str:
        """Description of a state."""
        texts = [
            self._text(component) if count == 1 else f"{count} x {self._text(component)}"
            for component, count in self._counts(variant, state)
        ]
        if texts:
            return "with " + " and ".join(texts)
        absent = [self._text(self._components.all[i]) for i in self._varying(variant)]
        more = f" or {len(absent) - _MAX_STATES} others" if len(absent) > _MAX_STATES else ""
        return "without " + " or ".join(absent[:_MAX_STATES]) + more

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
        columns = self._varying_of.get(variant.key)
        if columns is None:
            states = self._splitting.automaton.states[variant.key]
            differs = (states != states[:1]).any(axis=0)
            active = self._components.active[variant.key]
            columns = {i: column for column, i in enumerate(active) if differs[column]}
            self._varying_of[variant.key] = columns
        return columns

    def _text(self, component: Component) -> str:
        if isinstance(component, Deep):
            return " + ".join(self._label(pattern) for pattern in component.below.run)
        return " or ".join(self._label(pattern) for pattern in tops(component))

    def _label(self, pattern: Pattern) -> str:
        """Text of a pattern; a single branch is named after the symbol it makes."""
        if pattern.below or not pattern.branch or pattern.symbol is None:
            return str(pattern)
        return self._unique_successor(pattern) or str(pattern)

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

    def _short(self, pattern: Pattern, symbol: str) -> str:
        """A word for a pattern inside the name of a symbol: ``GroundFloorOffice`` is ``office`` in ``GroundFloor``."""
        while pattern.below:
            pattern = pattern.below[-1].run[-1]
        child = self._unique_successor(pattern) if pattern.branch and pattern.symbol else ""
        word = re.sub(r"\W", "", child or pattern.symbol or "any")
        for cut in (word.removeprefix(symbol), word.removesuffix(symbol)):
            if cut and cut != word and re.match(r"[^\W\d]", cut):
                word = cut
                break
        if pattern.branch and not child:
            word += "_".join(map(str, pattern.branch))
        return word[:1].lower() + word[1:]


def _top(component: Component) -> Pattern:
    return component.below.run[-1] if isinstance(component, Deep) else tops(component)[0]
