"""Derivation: from a grammar to a forest; see README.md in this folder."""

from grammarlab.derivation.compiler import compile_grammar as compile_grammar
from grammarlab.derivation.derive import derive as derive
from grammarlab.derivation.derive import derive_chunks as derive_chunks
from grammarlab.derivation.forest import Forest as Forest
from grammarlab.derivation.lots import Lots as Lots
from grammarlab.derivation.program import Program as Program
from grammarlab.derivation.state.workspace import Budget as Budget
