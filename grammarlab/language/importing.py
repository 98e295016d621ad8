"""Rule files from disk, with the files they import."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path, PurePosixPath

from grammarlab.errors import Finding, LanguageError
from grammarlab.language.grammar import Grammar, read_text
from grammarlab.language.syntax.tree import Import

MAX_FILES = 200
"""A rule file may import so many others, directly or not."""
_MOST_ABOVE = 12
RULES = "rules"
"""What CityEngine calls the folder of rule files in a project."""


def load(path: str | Path, root: str | Path | None = None) -> Grammar:
    """Reads a rule file and what it imports: UTF-8, or Latin-1 where it is not UTF-8.

    What is wrong with an import is among the grammar's `Grammar.import_findings`.

    Args:
        path: the rule file.
        root: the folder that no import may leave, and that paths beginning with a slash start from; by default
            what `rules_folder` gives.

    Raises:
        LanguageError: with every syntax error of the file, or because it cannot be read or is too large.
    """
    path = Path(path)
    grammar = Grammar.parse(read_text(path), str(path))
    folder = path.resolve().parent
    reader = _ImportReader(rules_folder(folder) if root is None else Path(root).resolve())
    return reader.with_imports(grammar, folder, (path.resolve(),))


def rules_folder(folder: Path) -> Path:
    """The folder that imports of the rule files in a folder may not leave: the ``rules`` that it is in, or itself."""
    return next((each for each in (folder, *folder.parents) if each.name.lower() == RULES), folder)


class _ImportReader:
    """Reads imported files, each once."""

    def __init__(self, root: Path) -> None:
        self.root = root
        self.read: dict[Path, Grammar] = {}

    def with_imports(self, grammar: Grammar, folder: Path, users: tuple[Path, ...]) -> Grammar:
        """The grammar with the files it imports.

        Args:
            grammar: a grammar read from a file.
            folder: where that file lies.
            users: the file, and before it those whose imports led to it.
        """
        libraries: dict[str, Grammar | None] = {}
        findings: list[Finding] = []
        for statement in grammar.tree.definitions:
            if isinstance(statement, Import):
                try:
                    libraries[statement.alias] = self._library(statement, folder, users)
                except ImportProblemError as error:
                    libraries[statement.alias] = None
                    message, hint = str(error), error.hint
                    findings.append(Finding("error", "bad-import", message, statement.location, hint))
        return replace(grammar, libraries=libraries, import_findings=tuple(findings))

    def _library(self, statement: Import, folder: Path, users: tuple[Path, ...]) -> Grammar:
        path = locate(statement, folder, self.root, users)
        if path not in self.read:
            if len(self.read) >= MAX_FILES:
                raise ImportProblemError(f"expected at most {MAX_FILES} imported files", "")
            try:
                grammar = Grammar.parse(read_text(path), str(path))
            except LanguageError as error:
                first = error.findings[0]
                message = f"cannot use '{statement.path}': {first.message} ({first.location})"
                raise ImportProblemError(message, "") from error
            self.read[path] = self.with_imports(grammar, path.parent, (*users, path))
        return self.read[path]


def locate(statement: Import, folder: Path, root: Path, users: tuple[Path, ...]) -> Path:
    """Where an imported file lies.

    A path is looked for in the folder of the importing file, then in those above it up to the root; it may begin with
    ``rules``, as seen from a project. One that begins with a slash starts in CityEngine from a workspace of projects:
    it is looked for from the root first, and the folders in front are left out one by one.

    Args:
        statement: what imports it.
        folder: of the importing file.
        root: the folder that no import may leave, and that paths beginning with a slash start from.
        users: the importing file, and before it those whose imports led to it.

    Raises:
        ImportProblemError: it lies outside, is no path, or imports the file that imports it.
    """
    written = PurePosixPath(statement.path.replace("\\", "/"))
    parts = tuple(part for part in written.parts if part != "/")
    within = [each for each in (folder, *folder.parents) if each.is_relative_to(root)][:_MOST_ABOVE]
    above = within[:1] if ".." in parts else within
    if written.is_absolute():
        starts, deepest = [root, *above], len(parts)
    else:
        starts, deepest = above or [folder], 2 if parts and parts[0].lower() == RULES else 1
    paths = [
        _inside(statement, start, parts[first:], root)
        for first in range(max(1, min(deepest, _MOST_ABOVE)))
        for start in starts
    ]
    path = next(filter(_is_file, paths), paths[0])
    if path in users:
        message = f"'{statement.path}' imports the file that imports it"
        raise ImportProblemError(message, "move what both need to a third")
    return path


def _inside(statement: Import, start: Path, parts: tuple[str, ...], root: Path) -> Path:
    try:
        path = start.joinpath(*parts).resolve()
    except (OSError, ValueError, RuntimeError) as error:  # a name too long, a zero byte, links in a circle
        raise ImportProblemError(f"'{statement.path}' is no path: {error}", "") from error
    if not path.is_relative_to(root):
        raise ImportProblemError(f"'{statement.path}' lies outside the folder of the rule file", "move it inside")
    return path


def _is_file(path: Path) -> bool:
    try:
        return path.is_file()
    except OSError:
        return False


class ImportProblemError(Exception):
    """An import that cannot be followed."""

    def __init__(self, message: str, hint: str) -> None:
        self.hint = hint
        super().__init__(message)
