"""Errors, warnings and unsupported features of a rule file."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from grammarlab.errors import Finding
from grammarlab.language.checking.declarations import check_declarations
from grammarlab.language.checking.flow import check_endless, check_reachable, check_shadowed
from grammarlab.language.checking.inference import ExpressionChecker
from grammarlab.language.checking.symbols import EVERYTHING, Remarks, SupportedFeatures, Symbols, collect
from grammarlab.language.checking.usage import BodyChecker
from grammarlab.language.grammar import Grammar, start_rules
from grammarlab.language.parsing.parse import Parsed, parse
from grammarlab.language.syntax.tree import (
    Attribute,
    Function,
    Import,
    Rule,
    RuleFile,
    Style,
    Variable,
)
from grammarlab.language.vocabulary.kinds import Scope

__all__ = ["EVERYTHING", "SupportedFeatures", "check", "check_text"]


def check(grammar: Grammar, supported: SupportedFeatures = EVERYTHING) -> tuple[Finding, ...]:
    """Findings about a grammar, in the order of its text; only the names of imported files are used.

    Args:
        grammar: the grammar.
        supported: the supported features; all others are reported with the severity ``unsupported``.
    """
    remarks = Remarks()
    for finding in grammar.import_findings:
        remarks.take(finding)
    libraries = {alias: library and _symbols_of(library) for alias, library in grammar.libraries.items()}
    _check_tree(grammar.tree, collect(grammar.tree, libraries), supported, remarks)
    return remarks.in_order()


def check_text(text: str, file: str = "<text>", supported: SupportedFeatures = EVERYTHING) -> tuple[Finding, ...]:
    """Findings about a rule file, syntax errors included. Never raises, for any text.

    Args:
        text: the whole file.
        file: its name, for messages.
        supported: the supported features.
    """
    return check_parsed(parse(text.removeprefix("\ufeff"), file), supported, {}, ())[0]


def check_parsed(
    parsed: Parsed,
    supported: SupportedFeatures,
    libraries: Mapping[str, Symbols | None],
    problems: Iterable[Finding],
    imported: bool = False,
) -> tuple[tuple[Finding, ...], Symbols]:
    """Findings about a parsed rule file, in the order of its text, and its definitions.

    Args:
        parsed: the file.
        supported: what can be carried out.
        libraries: definitions of imported files, by alias; None for unknown ones.
        problems: findings about the imports.
        imported: whether other files start with its rules, so that all rules count as reachable.
    """
    remarks = Remarks()
    for finding in (*parsed.findings, *problems):
        remarks.take(finding)
    symbols = collect(parsed.tree, libraries, parsed.broken)
    _check_tree(parsed.tree, symbols, supported, remarks, whole=not parsed.findings and not imported)
    return remarks.in_order(), symbols


def _symbols_of(grammar: Grammar) -> Symbols:
    libraries: Mapping[str, Symbols | None] = {
        alias: library and _symbols_of(library) for alias, library in grammar.libraries.items()
    }
    return collect(grammar.tree, libraries)


def _check_tree(
    tree: RuleFile, symbols: Symbols, supported: SupportedFeatures, remarks: Remarks, whole: bool = True
) -> None:
    """Check a tree; `whole` is False if definitions are missing because of syntax errors."""
    check_declarations(tree, remarks)
    expressions = ExpressionChecker(symbols, supported, remarks)
    bodies = BodyChecker(expressions)
    for definition in tree.definitions:
        match definition:
            case Attribute():
                scope = _variables(expressions, definition.variables, Scope())
                expressions.value(definition.value, scope)
            case Function():
                scope = Scope(frozenset(definition.parameters))
                expressions.value(definition.value, _variables(expressions, definition.variables, scope))
            case Rule():
                scope = Scope(frozenset(definition.parameters))
                bodies.body(definition.body, _variables(expressions, definition.variables, scope))
            case Import():
                _check_import(definition, expressions, bodies)
            case Style():
                remarks.unsupported(supported.constructs, "style", definition.location, "a style")
    check_shadowed(tree, remarks)
    check_endless(tree, remarks)
    if whole:
        _check_start(tree, remarks)


def _variables(expressions: ExpressionChecker, variables: tuple[Variable, ...], scope: Scope) -> Scope:
    """Check the local variables of a definition; returns the scope of its body."""
    for variable in variables:
        what = "a local variable"
        expressions.remarks.unsupported(expressions.supported.constructs, "variables", variable.location, what)
        expressions.value(variable.value, scope)
        scope = Scope(scope.locals | {variable.name})
    return scope


def _check_import(node: Import, expressions: ExpressionChecker, bodies: BodyChecker) -> None:
    expressions.remarks.unsupported(expressions.supported.constructs, "import", node.location, "an import")
    for _, value in node.arguments:
        expressions.value(value, Scope())
    for rule in node.rules:
        bodies.body(rule.body, Scope(frozenset(rule.parameters)))


def _check_start(tree: RuleFile, remarks: Remarks) -> None:
    roots = start_rules(tree)
    if not roots:
        remarks.warning("no-rule", tree.location, "the file has no rule to begin with", "write Lot --> …")
        return
    for rule in roots:
        if rule.parameters:
            message = f"the start rule {rule.name} has parameters without values"
            remarks.warning("start-parameters", rule.location, message, "begin with a rule without parameters")
    check_reachable(tree, roots, remarks)
