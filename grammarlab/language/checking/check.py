"""Errors, warnings and unsupported features of a grammar, or of a rule file and the files that it imports."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path

from grammarlab.errors import Finding, LanguageError
from grammarlab.language.checking.declarations import check_declarations
from grammarlab.language.checking.flow import check_endless, check_reachable, check_shadowed
from grammarlab.language.checking.inference import ExpressionChecker
from grammarlab.language.checking.symbols import EVERYTHING, Remarks, SupportedFeatures, Symbols, collect
from grammarlab.language.checking.usage import BodyChecker
from grammarlab.language.grammar import Grammar, read_text, start_rules
from grammarlab.language.importing import MAX_FILES, ImportProblemError, import_roots, locate, unusable
from grammarlab.language.syntax.keywords import Scope
from grammarlab.language.syntax.parse import Parsed, parse
from grammarlab.language.syntax.syntax_tree import Attribute, Function, Import, Rule, RuleFile, Style, Variable

__all__ = ["EVERYTHING", "SupportedFeatures", "check", "check_text"]


@dataclass(frozen=True, slots=True)
class CheckedFile:
    """A parsed rule file."""

    file: str
    text: str
    findings: tuple[Finding, ...]
    """Findings in the order of its text."""
    tree: RuleFile
    """Syntax tree without the definitions that have syntax errors."""


def check(grammar: Grammar, supported: SupportedFeatures = EVERYTHING) -> tuple[Finding, ...]:
    """Findings about a grammar, in the order of its text; only the names of imported files are used.

    Args:
        grammar: the grammar.
        supported: the supported features; all others are reported with the severity ``unsupported``.
    """
    remarks = Remarks()
    for finding in grammar.import_findings:
        remarks.take(finding)
    _check_tree(grammar.tree, _symbols_of(grammar), supported, remarks)
    return remarks.in_order()


def check_text(text: str, file: str = "<text>", supported: SupportedFeatures = EVERYTHING) -> tuple[Finding, ...]:
    """Findings about a rule file, syntax errors included. Never raises, for any text.

    Args:
        text: the whole file.
        file: name of the file, for messages.
        supported: the supported features.
    """
    return _check_parsed(parse(text.removeprefix("\ufeff"), file), supported, {}, ())[0]


def check_files(
    path: Path,
    name: str,
    supported: SupportedFeatures = EVERYTHING,
    root: Path | None = None,
    library: Path | str | None = None,
    known: Grammar | None = None,
) -> tuple[CheckedFile, ...]:
    """Findings about a rule file and every file that it imports, directly or not.

    Args:
        path: the rule file.
        name: name of the file in messages; imported files are named by their paths relative to it.
        supported: the supported features; all others are reported with the severity ``unsupported``.
        root: the folder that no import may leave, and that paths beginning with a slash start from. Default:
            `rules_folder`.
        library: a folder of further projects, see `grammarlab.language.importing.load`.
        known: a grammar; a file with its text is not parsed again.

    Returns:
        The file, then those it imports, each once.

    Raises:
        LanguageError: If the file cannot be read, or is too large.
    """
    text = read_text(path)  # first, since links to themselves cannot be resolved
    folder = path.resolve().parent
    checker = _Checker(supported, import_roots(folder, root, library), folder, Path(name).parent, known)
    checker.read(path.resolve(), name, text, ())
    return tuple(checker.checked.values())


def _symbols_of(grammar: Grammar) -> Symbols:
    libraries: Mapping[str, Symbols | None] = {
        alias: None if library is None else _symbols_of(library) for alias, library in grammar.libraries.items()
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
                pass
    check_shadowed(tree, remarks)
    check_endless(tree, remarks)
    if whole:
        _check_start(tree, remarks)


def _variables(expressions: ExpressionChecker, variables: tuple[Variable, ...], scope: Scope) -> Scope:
    """Check the local variables of a definition; returns the scope of its body."""
    for variable in variables:
        kind = "a local variable"
        expressions.remarks.unsupported(expressions.supported.constructs, "variables", variable.location, kind)
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


def _check_parsed(
    parsed: Parsed,
    supported: SupportedFeatures,
    libraries: Mapping[str, Symbols | None],
    problems: Iterable[Finding],
    imported: bool = False,
) -> tuple[tuple[Finding, ...], Symbols]:
    """Findings about a parsed rule file, in the order of its text, and its definitions.

    Args:
        parsed: the file.
        supported: the supported features.
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


class _Checker:
    """Checks each file once."""

    def __init__(
        self,
        supported: SupportedFeatures,
        roots: tuple[Path, ...],
        folder: Path,
        display_folder: Path,
        known: Grammar | None,
    ) -> None:
        self.supported = supported
        self.roots = roots
        self.folder = folder
        self.display_folder = display_folder
        """The folder, as the user gave it."""
        self.known = known
        self.checked: dict[Path, CheckedFile] = {}
        self.symbols: dict[Path, Symbols | None] = {}
        """Definitions of each file; None if it has syntax errors."""

    def read(self, path: Path, name: str, text: str, users: tuple[Path, ...]) -> None:
        text = text.removeprefix("\ufeff")
        if self.known is not None and self.known.text == text:
            parsed = Parsed(self.known.tree, (), (), frozenset())
        else:
            parsed = parse(text, name)
        # Reserves the file's place in the order while its imports are read.
        self.checked[path] = CheckedFile(name, text, (), parsed.tree)
        libraries, problems = self._libraries(parsed.tree, path, (*users, path))
        findings, symbols = _check_parsed(parsed, self.supported, libraries, problems, imported=bool(users))
        self.checked[path] = CheckedFile(name, text, findings, parsed.tree)
        self.symbols[path] = None if parsed.findings else symbols

    def _libraries(
        self, tree: RuleFile, path: Path, users: tuple[Path, ...]
    ) -> tuple[dict[str, Symbols | None], list[Finding]]:
        """Symbols of imported files by alias, and findings about the imports."""
        libraries: dict[str, Symbols | None] = {}
        problems: list[Finding] = []
        for statement in tree.definitions:
            if not isinstance(statement, Import):
                continue
            try:
                libraries[statement.alias] = self._library(statement, path.parent, users)
            except ImportProblemError as error:
                libraries[statement.alias] = None
                problems.append(Finding("error", "bad-import", str(error), statement.location, error.hint))
        return libraries, problems

    def _library(self, statement: Import, folder: Path, users: tuple[Path, ...]) -> Symbols | None:
        path = locate(statement, folder, self.roots, users)
        if path not in self.checked:
            if len(self.checked) > MAX_FILES:
                raise ImportProblemError(f"expected at most {MAX_FILES} imported files", "")
            try:
                text = read_text(path)
            except LanguageError as error:
                raise unusable(statement, error.findings[0]) from error
            self.read(path, self._name(path), text, users)
        return self.symbols.get(path)

    def _name(self, path: Path) -> str:
        return (
            str(self.display_folder / path.relative_to(self.folder)) if path.is_relative_to(self.folder) else str(path)
        )
