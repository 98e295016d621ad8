"""Findings about a rule file on disk and about its imported files."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from grammarlab.errors import Finding, LanguageError
from grammarlab.language.checking.check import check_parsed
from grammarlab.language.checking.symbols import EVERYTHING, SupportedFeatures, Symbols
from grammarlab.language.grammar import read_text
from grammarlab.language.importing import MAX_FILES, ImportProblemError, locate, rules_folder
from grammarlab.language.parsing.parse import parse
from grammarlab.language.syntax.tree import Import, RuleFile


@dataclass(frozen=True, slots=True)
class CheckedFile:
    """A parsed rule file."""

    file: str
    text: str
    findings: tuple[Finding, ...]
    """Findings in the order of its text."""
    tree: RuleFile
    """Syntax tree without the definitions that have syntax errors."""


def check_files(
    path: Path, name: str, supported: SupportedFeatures = EVERYTHING, root: Path | None = None
) -> tuple[CheckedFile, ...]:
    """Findings about a rule file and every file that it imports, directly or not.

    Args:
        path: the rule file.
        name: its name in messages; imported files are named by their paths relative to it.
        supported: the supported features; all others are reported with the severity ``unsupported``.
        root: the folder that no import may leave, and that paths beginning with a slash start from. Default:
            `rules_folder`.

    Returns:
        The file, then those it imports, each once.

    Raises:
        LanguageError: If the file cannot be read, or is too large.
    """
    text = read_text(path)  # first, since links to themselves cannot be resolved
    folder = path.resolve().parent
    checker = _Checker(supported, rules_folder(folder) if root is None else root.resolve(), folder, Path(name).parent)
    checker.read(path.resolve(), name, text, ())
    return tuple(checker.checked.values())


class _Checker:
    """Checks each file once."""

    def __init__(self, supported: SupportedFeatures, root: Path, folder: Path, shown: Path) -> None:
        self.supported = supported
        self.root = root
        self.folder = folder
        self.shown = shown
        """The folder, as the user gave it."""
        self.checked: dict[Path, CheckedFile] = {}
        self.symbols: dict[Path, Symbols | None] = {}
        """Definitions of each file; None if it has syntax errors."""

    def read(self, path: Path, name: str, text: str, users: tuple[Path, ...]) -> None:
        text = text.removeprefix("\ufeff")
        parsed = parse(text, name)
        # Reserves the file's place in the order while its imports are read.
        self.checked[path] = CheckedFile(name, text, (), parsed.tree)
        libraries, problems = self._libraries(parsed.tree, path, (*users, path))
        findings, symbols = check_parsed(parsed, self.supported, libraries, problems, imported=bool(users))
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
        path = locate(statement, folder, self.root, users)
        if path not in self.checked:
            if len(self.checked) > MAX_FILES:
                raise ImportProblemError(f"expected at most {MAX_FILES} imported files", "")
            try:
                text = read_text(path)
            except LanguageError as error:
                raise ImportProblemError(f"cannot use '{statement.path}': {error.findings[0].message}", "") from error
            self.read(path, self._name(path), text, users)
        return self.symbols.get(path)

    def _name(self, path: Path) -> str:
        return str(self.shown / path.relative_to(self.folder)) if path.is_relative_to(self.folder) else str(path)
