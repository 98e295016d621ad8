"""What a rule file must be for a run: free of errors, and of features that cannot be carried out."""

from __future__ import annotations

from grammarlab.derivation.functions import BUILTINS, SHAPE_ATTRIBUTES
from grammarlab.derivation.operations import BLOCKS, OPERATIONS
from grammarlab.errors import Finding, LanguageError
from grammarlab.language.checking import SupportedFeatures, check, check_text
from grammarlab.language.grammar import Grammar

SUPPORTED = SupportedFeatures(
    operations=frozenset(OPERATIONS) | frozenset(BLOCKS) | {"NIL"},
    functions=frozenset(BUILTINS),
    attributes=frozenset(SHAPE_ATTRIBUTES),
    constructs=frozenset(),
)
"""What derivations carry out."""


def findings_of(text: str, file: str) -> tuple[Finding, ...]:
    """Everything wrong with a rule file, whatever its text, and every feature in it that is not carried out."""
    return check_text(text, file, SUPPORTED)


def grammar_to_run(text: str, file: str) -> Grammar:
    """The grammar of a rule file that can be derived.

    Raises:
        LanguageError: with all findings, when one of them is an error or an unsupported feature.
    """
    grammar = Grammar.parse(text, file)
    findings = check(grammar, SUPPORTED)
    serious = tuple(finding for finding in findings if finding.severity != "warning")
    if serious:
        raise LanguageError(serious, text)
    return grammar
