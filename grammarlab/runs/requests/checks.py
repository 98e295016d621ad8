"""Checks of a rule file for a run."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from grammarlab.derivation.functions import BUILTINS, SHAPE_ATTRIBUTES
from grammarlab.derivation.operations import BLOCKS, CHANGE_LOOKS, LEFT_OUT, OPERATIONS
from grammarlab.errors import Finding, LanguageError, UsageError
from grammarlab.features.rules.acceptance import Acceptance, annotations_of
from grammarlab.language.checking.check import SupportedFeatures, check
from grammarlab.language.checking.files import CheckedFile, check_files
from grammarlab.language.grammar import Grammar
from grammarlab.language.syntax.tree import RuleFile
from grammarlab.language.vocabulary.builtins import attributes
from grammarlab.runs.requests.examples import RuleSource
from grammarlab.runs.requests.missing_assets import findings_about

_KEYWORDS = {
    **{name: operation.keywords for name, operation in OPERATIONS.items()},
    **{name: block.keywords | block.selectors for name, block in BLOCKS.items()},
    **{name: function.keywords for name, function in BUILTINS.items()},
}

_MATERIAL = frozenset(name for name in SHAPE_ATTRIBUTES if name.startswith("material."))

SUPPORTED = SupportedFeatures(
    operations=(frozenset(OPERATIONS) - LEFT_OUT) | frozenset(BLOCKS) | {"NIL"},
    functions=frozenset(BUILTINS) | {"sel"},
    attributes=frozenset(SHAPE_ATTRIBUTES),
    keywords=frozenset(f"{name}:{word}" for name, words in _KEYWORDS.items() for word in words),
    constructs=frozenset({"array", "comp-function", "connected", "import"}),
    harmless=CHANGE_LOOKS
    | frozenset(name for name in attributes() if name.startswith(("trim.", "material.")) and name not in _MATERIAL),
)
"""Features that derivations support."""


def check_source(source: RuleSource) -> tuple[CheckedFile, ...]:
    """Findings about a rule file and its imports, including unsupported features and missing meshes.

    Raises:
        LanguageError: If the file cannot be read, or is too large.
    """
    checked = check_files(source.path, str(source.path), SUPPORTED)
    return tuple(replace(one, findings=_with_assets(one, source.assets)) for one in checked)


def _with_assets(one: CheckedFile, assets: Path) -> tuple[Finding, ...]:
    findings = (*one.findings, *findings_about(one.tree, assets), *_acceptance(one.tree))
    return tuple(sorted(findings, key=lambda finding: finding.location))


def _acceptance(tree: RuleFile) -> tuple[Finding, ...]:
    """Findings about an acceptance rule."""
    try:
        Acceptance.of(tree)
    except UsageError as error:
        return (Finding("error", "bad-acceptance", str(error), annotations_of(tree)[0].location),)
    return ()


def grammar_to_run(text: str, file: str) -> Grammar:
    """Grammar of a rule file without errors.

    Unsupported features are allowed: many rule files have some that no model reaches, and a derivation that reaches
    one raises an error.

    Raises:
        LanguageError: If there are errors; it lists all of them.
    """
    grammar = Grammar.parse(text, file)
    found = (*check(grammar, SUPPORTED), *_acceptance(grammar.tree))
    errors = tuple(finding for finding in found if finding.severity == "error")
    if errors:
        raise LanguageError(errors, text)
    return grammar


def not_carried_out(grammar: Grammar) -> tuple[Finding, ...]:
    """Features of a grammar that a derivation ignores or does not support."""
    found = (one for one in check(grammar, SUPPORTED) if one.severity == "unsupported" or one.code == "left-out")
    unread = (
        Finding("unsupported", "bad-import", f'the import "{statement.path}", which cannot be read', statement.location)
        for statement in grammar.imports.values()
    )
    return (*unread, *found)
