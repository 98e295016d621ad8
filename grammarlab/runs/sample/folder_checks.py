"""All rule files of a folder: how many run, and what the others lack, the most wanted first."""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Literal

from grammarlab.asset_roots import asset_root
from grammarlab.derivation.derive import derive
from grammarlab.derivation.state.workspace import Budget
from grammarlab.errors import GrammarlabError, LanguageError, UsageError
from grammarlab.language.checking.check import check
from grammarlab.language.grammar import Grammar
from grammarlab.language.importing import SUFFIX, load
from grammarlab.language.linking import linked
from grammarlab.runs.sample.checks import SUPPORTED, grammar_to_run
from grammarlab.runs.sample.shipped import assets_folder

Outcome = Literal["runs", "no start rule", "import", "error", "stops"]
"""What becomes of a rule file: a model, no model since it has only definitions for others, an import that is missing,
an error that `check` finds, or a derivation that stops."""
_MOST_FILES = 2_000
"""Largest number of rule files that are tried."""
_MOST_ENTRIES = 200_000
"""Largest number of files and folders that are looked at for rule files."""
_BUDGET = Budget(shapes=50_000)
"""Largest model of each file."""


@dataclass(frozen=True, slots=True)
class TriedFile:
    """One rule file."""

    file: str
    """Path relative to the folder."""
    outcome: Outcome
    reason: str
    """Why it gives no model; empty if it runs."""
    unsupported: tuple[str, ...]
    """Unsupported features that it names, whether a model comes to them or not."""


@dataclass(frozen=True, slots=True)
class FolderCheck:
    """The rule files of a folder, by path."""

    files: tuple[TriedFile, ...]

    def counts(self) -> dict[Outcome, int]:
        """Number of files with each outcome."""
        return dict(Counter(file.outcome for file in self.files))

    def wanted(self) -> tuple[tuple[str, int], ...]:
        """Unsupported features and the number of files that name them, the most wanted first."""
        counts = Counter(feature for file in self.files for feature in file.unsupported)
        return tuple(sorted(counts.items(), key=lambda item: (-item[1], item[0])))

    def as_dict(self) -> dict[str, object]:
        """The check as plain values."""
        return {
            "counts": self.counts(),
            "wanted": dict(self.wanted()),
            "files": [asdict(file) for file in self.files],
        }


def check_folder(folder: Path, library: Path | None = None) -> FolderCheck:
    """Try every rule file of a folder, and of the folders in it, on the default footprint.

    Links are not followed.

    Args:
        folder: the folder.
        library: a folder of further projects that the files import from; by default `folder`, whose projects may import
            from each other.

    Raises:
        UsageError: If it has no rule file, or too many.
    """
    paths = sorted(_rule_files(folder))
    if not paths:
        raise UsageError(f"{folder}: expected {SUFFIX} files in the folder or below it, found none.")
    return FolderCheck(tuple(_tried(path, folder, library or folder) for path in paths))


def _rule_files(folder: Path) -> Iterator[Path]:
    num_rules, num_entries = 0, 0
    for place, folders, files in os.walk(folder):
        rules = [name for name in files if name.lower().endswith(SUFFIX)]
        num_rules, num_entries = num_rules + len(rules), num_entries + len(folders) + len(files)
        if num_rules > _MOST_FILES or num_entries > _MOST_ENTRIES:
            raise UsageError(f"{folder}: expected at most {_MOST_FILES:,} rule files; name a folder in it.")
        yield from (path for name in rules if (path := Path(place, name)).is_file() and not path.is_symlink())


def _tried(path: Path, folder: Path, library: Path | None) -> TriedFile:
    name = path.relative_to(folder).as_posix()
    try:
        grammar = load(path, library=library)
    except LanguageError as error:
        return TriedFile(name, "error", _first(error), ())
    features = tuple(
        sorted({finding.message for finding in check(grammar, SUPPORTED) if finding.severity == "unsupported"})
    )
    outcome, reason = _outcome(grammar, path, library)
    return TriedFile(name, outcome, reason, features)


def _outcome(grammar: Grammar, path: Path, library: Path | None) -> tuple[Outcome, str]:
    if not any(not rule.parameters for rule in (*grammar.start_rules, *grammar.rules.values())):
        return "no start rule", "it has no rule without parameters"
    if grammar.import_findings:
        return "import", grammar.import_findings[0].message
    try:
        whole = grammar_to_run(linked(grammar), str(path))
        derive(whole, 1, 0, assets=asset_root(assets_folder(path), library), budget=_BUDGET)
    except LanguageError as error:
        outcome, reason = "error", _first(error)
    except GrammarlabError as error:
        outcome, reason = "stops", str(error).splitlines()[0]
    else:
        return "runs", ""
    # An imported file that lacks its own imports lacks their attributes, which is what stops the derivation.
    missing = next(_missing_imports(grammar), "")
    return ("import", missing) if missing else (outcome, reason)


def _missing_imports(grammar: Grammar) -> Iterator[str]:
    """Imports that imported files lack; each file is looked at once."""
    seen, waiting = {id(grammar)}, [grammar]
    while waiting:
        for library in waiting.pop().libraries.values():
            if library is not None and id(library) not in seen:
                yield from (finding.message for finding in library.import_findings)
                seen.add(id(library))
                waiting.append(library)


def _first(error: LanguageError) -> str:
    finding = error.findings[0]
    return f"{finding.message} (line {finding.location.line})"
