"""What a rule file must be for a run: free of errors."""

from __future__ import annotations

from grammarlab.derivation.functions import BUILTINS, SHAPE_ATTRIBUTES
from grammarlab.derivation.operations import BLOCKS, OPERATIONS, WITHOUT_EFFECT
from grammarlab.errors import Finding, LanguageError
from grammarlab.language.checking import SupportedFeatures, check, check_text
from grammarlab.language.grammar import Grammar

SUPPORTED = SupportedFeatures(
    operations=(frozenset(OPERATIONS) - WITHOUT_EFFECT) | frozenset(BLOCKS) | {"NIL"},
    functions=frozenset(BUILTINS),
    attributes=frozenset(SHAPE_ATTRIBUTES),
    constructs=frozenset(),
)
"""What derivations carry out."""


def findings_of(text: str, file: str) -> tuple[Finding, ...]:
    """Everything wrong with a rule file, whatever its text, and every feature in it that is not carried out."""
    return check_text(text, file, SUPPORTED)


def grammar_to_run(text: str, file: str) -> Grammar:
    """The grammar of a rule file without errors.

    Features that are not supported do not keep it from being derived: many a rule file holds some that its models never
    reach, and a derivation that comes to one says so.

    Raises:
        LanguageError: with all errors.
    """
    grammar = Grammar.parse(text, file)
    errors = tuple(finding for finding in check(grammar, SUPPORTED) if finding.severity == "error")
    if errors:
        raise LanguageError(errors, text)
    return grammar
