"""Operations and functions of CGA that derivations support."""

from __future__ import annotations

from grammarlab.derivation.functions import BUILTINS
from grammarlab.derivation.operations import BLOCKS, OPERATIONS
from grammarlab.language.grammar import Grammar
from grammarlab.language.numbering import EngineWords, Numbering

VOCABULARY = EngineWords(
    frozenset(OPERATIONS), frozenset(BLOCKS), frozenset(name for name, builtin in BUILTINS.items() if builtin.random)
)


def number_grammar(grammar: Grammar) -> Numbering:
    """Numbering of a grammar shared by all its forests: `Forest.symbols`, `rules`, `sites`, `Nodes.child`."""
    return Numbering.of(grammar, VOCABULARY)
