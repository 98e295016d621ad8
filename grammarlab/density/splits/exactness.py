"""Features that an exact grammar can express."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

from grammarlab.density.counting.attributes import attribute_parts
from grammarlab.density.counting.automaton import count_automaton
from grammarlab.density.counting.components import PatternComponents, Reading
from grammarlab.density.skeleton import TreeGrammar
from grammarlab.density.splits.compile import RECURSIVE_CAP, countable
from grammarlab.derivation.forest import Forest
from grammarlab.errors import InexactError
from grammarlab.features.patterns.pattern import Feature, Total
from grammarlab.language.grammar import Grammar


@dataclass(frozen=True)
class Exactness:
    """Features that exact grammars made from one grammar can express."""

    grammar: Grammar
    forest: Forest
    """Derivations for the numbers of successors inside blocks."""

    def reason_against(self, feature: Feature) -> str:
        """Reason why an exact grammar cannot express a feature; empty if it can."""
        if isinstance(feature, Total):
            return next(filter(None, (self.reason_against(term) for term, _ in feature.terms)), "")
        try:
            found = countable(feature)
            if isinstance(found, Reading):
                reading = replace(found, cap=min(found.cap, RECURSIVE_CAP))
                count_automaton(PatternComponents(self._tree, (reading,)))
            else:
                attribute_parts(self.grammar, found.site, [found])
        except InexactError as error:
            return str(error)
        return ""

    @cached_property
    def _tree(self) -> TreeGrammar:
        return TreeGrammar.of(self.grammar).observed(self.forest)
