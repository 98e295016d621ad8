"""Rule files from disk, with their imported files."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path, PurePosixPath

from grammarlab.errors import Finding, LanguageError
from grammarlab.language.grammar import Grammar, read_text
from grammarlab.language.syntax.syntax_tree import Import

MAX_FILES = 200
"""Largest number of files that a rule file may import, directly or not."""
_MOST_ABOVE = 12
"""Largest number of folders above a rule file in which its imports are searched."""
SUFFIX = ".cga"
"""Suffix of rule files."""
RULES = "rules"
"""Name of the folder of rule files in a CityEngine project."""
_OF_PROJECTS = ("assets", "scenes", ".project")
"""Names of what stands beside that folder in a project."""
LIBRARY_HINT = "`library=DIR` names a folder of further projects, such as ESRI.lib, to import from"
"""Hint about imports of files that are not there."""


def load(path: str | Path, root: str | Path | None = None, library: str | Path | None = None) -> Grammar:
    """Read a rule file and its imports; see `grammarlab.language.grammar.read_text` for encodings.

    Findings about imports are in `Grammar.import_findings`.

    Args:
        path: the rule file.
        root: the folder that no import may leave, and that paths beginning with a slash start from. Default:
            `rules_folder`.
        library: a folder of further projects, such as ``ESRI.lib``, in which paths beginning with a slash are searched
            after the root.

    Raises:
        LanguageError: If the file has syntax errors, cannot be read, or is too large.
    """
    path = Path(path)
    grammar = Grammar.parse(read_text(path), str(path))
    folder = path.resolve().parent
    reader = _ImportReader(import_roots(folder, root, library))
    return reader.with_imports(grammar, folder, (path.resolve(),))


def rules_folder(folder: Path) -> Path:
    """Root folder for imports of the rule files in a folder: the enclosing ``rules`` folder, or the folder itself."""
    return next((candidate for candidate in (folder, *folder.parents) if candidate.name.lower() == RULES), folder)


def import_roots(folder: Path, root: str | Path | None, library: str | Path | None) -> tuple[Path, ...]:
    """Folders in which imports are searched and that they may not leave.

    Args:
        folder: the folder of the importing rule file.
        root: the first of them; by default `rules_folder`, then the project that it is in, if there is one.
        library: the last of them, if there is one.
    """
    first = rules_folder(folder) if root is None else Path(root).resolve()
    project = (first.parent,) if root is None and first.name.lower() == RULES and _is_project(first.parent) else ()
    return (first, *project, *(() if library is None else (Path(library).resolve(),)))


def _is_project(folder: Path) -> bool:
    """Whether a folder with ``rules`` looks like a CityEngine project, and not like somebody's home."""
    return any((folder / name).exists() for name in _OF_PROJECTS)


class _ImportReader:
    """Reads each imported file once."""

    def __init__(self, roots: tuple[Path, ...]) -> None:
        self.roots = roots
        self.read: dict[Path, Grammar] = {}

    def with_imports(self, grammar: Grammar, folder: Path, users: tuple[Path, ...]) -> Grammar:
        """The grammar with its imported files.

        Args:
            grammar: a grammar read from a file.
            folder: the folder of that file.
            users: the chain of importing files, ending with this file.
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
        path = locate(statement, folder, self.roots, users)
        if path not in self.read:
            if len(self.read) >= MAX_FILES:
                raise ImportProblemError(f"expected at most {MAX_FILES} imported files", "")
            try:
                grammar = Grammar.parse(read_text(path), str(path))
            except LanguageError as error:
                raise unusable(statement, error.findings[0], f" ({error.findings[0].location})") from error
            self.read[path] = self.with_imports(grammar, path.parent, (*users, path))
        return self.read[path]


def locate(statement: Import, folder: Path, roots: tuple[Path, ...], users: tuple[Path, ...]) -> Path:
    """Path of an imported file.

    A path is searched in the folder of the importing file, then in the folders above it up to its root; it may begin
    with ``rules``, relative to a project. In CityEngine, a path with a leading slash starts from a workspace of
    projects: it is searched from each root. A path that is nowhere is searched with its leading folders removed one by
    one, since many public rule files have lost the folders of their project. Outside the first root only files that end
    in ``.cga`` are read.

    Args:
        statement: the import statement.
        folder: folder of the importing file.
        roots: the folders that no import may leave, and that paths beginning with a slash start from.
        users: the chain of importing files, ending with the importing file.

    Raises:
        ImportProblemError: If the file lies outside the roots, is not a valid path, or imports the importing file.
    """
    written = PurePosixPath(statement.path.replace("\\", "/"))
    parts = tuple(part for part in written.parts if part != "/")
    within = [
        candidate for candidate in (folder, *folder.parents) if any(candidate.is_relative_to(root) for root in roots)
    ][:_MOST_ABOVE]
    above = within[:1] if ".." in parts else within
    starts = [*roots, *above] if written.is_absolute() else above or [folder]
    deepest = 1 if ".." in parts else min(len(parts), _MOST_ABOVE)
    paths = [_inside(statement, start, parts[first:], roots) for first in range(max(1, deepest)) for start in starts]
    # A file that is where it is said to be is meant, also if it imports itself; others stand in for it.
    path = paths[0] if _is_file(paths[0]) else _stand_in(paths, users)
    if path in users:
        message = f"'{statement.path}' imports the file that imports it"
        raise ImportProblemError(message, "move shared definitions to a third file")
    return path


def _stand_in(paths: list[Path], users: tuple[Path, ...]) -> Path:
    """The first file that does not import itself; else the first file, or the first path."""
    found = list(filter(_is_file, paths))
    return next((path for path in found if path not in users), found[0] if found else paths[0])


def _inside(statement: Import, start: Path, parts: tuple[str, ...], roots: tuple[Path, ...]) -> Path:
    try:
        path = start.joinpath(*parts).resolve()
    except (OSError, ValueError, RuntimeError) as error:  # a name that is too long, a zero byte, circular links
        raise ImportProblemError(f"'{statement.path}' is not a valid path: {error}", "") from error
    if not path.is_relative_to(roots[0]) and not (
        path.suffix.lower() == SUFFIX and any(path.is_relative_to(root) for root in roots)
    ):
        raise ImportProblemError(f"'{statement.path}' lies outside the folder of the rule file", "move it inside")
    return path


def _is_file(path: Path) -> bool:
    try:
        return path.is_file()
    except OSError:
        return False


def unusable(statement: Import, finding: Finding, place: str = "") -> ImportProblemError:
    """The problem of an import whose file cannot be read or parsed, as its first finding says.

    Args:
        statement: the import statement.
        finding: the finding about the imported file.
        place: where in that file it is.
    """
    hint = LIBRARY_HINT if finding.code == "missing-file" else ""
    return ImportProblemError(f"cannot use '{statement.path}': {finding.message}{place}", hint)


class ImportProblemError(Exception):
    """An import that cannot be resolved."""

    def __init__(self, message: str, hint: str) -> None:
        self.hint = hint
        super().__init__(message)
