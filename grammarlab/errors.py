"""Error classes of grammarlab.

GrammarlabError
├── UsageError             wrong options or arguments: the command line exits with 2
├── LanguageError          a rule file that cannot be used: has its findings
├── DerivationError        a rule that cannot be applied to a shape: has a location
│   └── BudgetError        too many shapes, or too deep
├── AssetError             a mesh, image or footprint that is missing, broken or out of bounds
│   ├── MissingAssetError  a file that its folder lacks
│   └── UnreadableAssetError  a mesh in its folder that is broken, too large, or in another format
├── TableError             a table of text that cannot be read: names the line
├── TomlError              a text that is not TOML: has line and column
├── XmlError               a text that is not XML, or declares entities: has line and column
├── WorkerError            a task whose processes have died repeatedly
├── FacadeError            an invalid facade, or constraints that contradict each other
└── InexactError           a density that no grammar has exactly: states the reason

A finding is one remark of the checker about a place in a rule file. Locations count lines and
columns from 1; a column counts characters, not bytes.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Literal

from grammarlab.printable import printable

Severity = Literal["error", "unsupported", "warning"]


_WIDEST = 240
"""Characters of a line that a message shows."""
_MOST_SHOWN = 60
"""Characters of a foreign value that a message shows."""
_MOST_BITS = 200
"""Bits of an integer that a message shows in full; it would be longer than `_MOST_SHOWN` digits."""


@dataclass(frozen=True, slots=True, order=True)
class Location:
    """A place in a rule file."""

    line: int = 1
    """First line of the place, from 1."""
    column: int = 1
    """First character of the place, from 1."""
    length: int = 1
    """Characters to underline on that line, at least 1."""
    file: str = "<text>"
    """Name of the file as the user gave it."""

    def __str__(self) -> str:
        return f"{self.file}:{self.line}:{self.column}"


@dataclass(frozen=True, slots=True)
class Finding:
    """One remark about a rule file: what was expected, what was found, what to try."""

    severity: Severity
    code: str
    """Stable, kebab-case name of the kind of finding, for programs: ``unknown-name``."""
    message: str
    location: Location
    hint: str = ""
    """Advice; empty when the message already says it."""

    def as_dict(self) -> dict[str, object]:
        """The finding as plain values, for ``--json``."""
        return {**asdict(self), "location": asdict(self.location)}

    def render(self, lines: Sequence[str]) -> str:
        """The finding with its line of the rule file and a caret under the place, as `printable` text.

        Args:
            lines: all lines of the rule file; without them only the place is named.
        """
        head = printable(f"{self.location}: {self.severity}: {self.message} [{self.code}]")
        parts = [head]
        if 1 <= self.location.line <= len(lines):
            # Without indentation, since many tabs end beyond the edge of the window.
            line = lines[self.location.line - 1].lstrip()
            indent = len(lines[self.location.line - 1]) - len(line)
            start = min(max(self.location.column - 1 - indent, 0), len(line))
            if len(line) > _WIDEST:  # a window around the place
                first = max(0, start - _WIDEST // 2)
                line, start = line[first : first + _WIDEST], start - first
            pad = re.sub(r"[^\t]", " ", printable(line[:start]))
            underlined = printable(line[start : start + self.location.length])
            parts += ["  " + printable(line), "  " + pad + "^" * max(1, len(underlined))]
        if self.hint:
            parts.append(printable(f"  hint: {self.hint}"))
        return "\n".join(parts)


class GrammarlabError(Exception):
    """Base class of all errors of grammarlab, with a message for the user.

    A message names an argument between backticks, such as "give `width=`"; the command line shows the option instead.

    >>> import grammarlab as gl
    >>> try:
    ...     gl.load("bilding")
    ... except gl.GrammarlabError as error:
    ...     print("Did you mean 'building'?" in str(error))
    True
    """


class UsageError(GrammarlabError):
    """Wrong options or arguments; the command line exits with 2."""


def check_type(name: str, value: object, kinds: type | tuple[type, ...], example: str) -> None:
    """Refuse an argument of another type, in the caller's words.

    Args:
        name: name of the argument.
        value: value of the argument.
        kinds: the expected type, or several.
        example: expression of a value of such a type.

    Raises:
        UsageError: If the value has another type.
    """
    if not isinstance(value, kinds):
        expected = " or ".join(kind.__name__ for kind in (kinds if isinstance(kinds, tuple) else (kinds,)))
        actual = repr(value)[:60] if isinstance(value, str) else type(value).__name__
        raise UsageError(f"{name}: expected {expected} such as {example}, found {actual}.")


def shown(value: object) -> str:
    """A foreign value for a message: Python's form of it, abbreviated.

    >>> shown(None), shown([1, 2]), shown({"a": 1}), shown("b" * 100_000)[-4:]
    ('nothing', 'a list of 2', 'an object of 1', 'bbb…')
    """
    if value is None:
        return "nothing"
    if isinstance(value, list | dict):
        return f"{'a list' if isinstance(value, list) else 'an object'} of {len(value)}"
    if isinstance(value, int) and value.bit_length() > _MOST_BITS:
        return f"an integer of {value.bit_length()} bits"
    text = repr(value[: _MOST_SHOWN + 1] if isinstance(value, str) else value)
    return text if len(text) <= _MOST_SHOWN else f"{text[:_MOST_SHOWN]}…"


class LanguageError(GrammarlabError):
    """A rule file with errors.

    Args:
        findings: findings of the parser or checker; at least one is an error.
        text: the rule file, for the carets in the message.
    """

    def __init__(self, findings: tuple[Finding, ...], text: str = "") -> None:
        self.findings = findings
        self.text = text
        lines = text.splitlines()
        super().__init__("\n".join(finding.render(lines) for finding in findings))

    def __reduce__(self) -> tuple[type[LanguageError], tuple[tuple[Finding, ...], str]]:
        """Arguments to pickle an equal error; by default an exception is pickled with its message only."""
        return type(self), (self.findings, self.text)


class DerivationError(GrammarlabError):
    """An operation that cannot be applied.

    Args:
        message: what was expected and what was found.
        location: the place in the rule file that causes it, if any.
        hint: what to try.
    """

    def __init__(self, message: str, location: Location | None = None, hint: str = "") -> None:
        self.message = message
        self.location = location
        self.hint = hint
        where = f"{location}: " if location is not None else ""
        super().__init__(f"{where}{message}" + (f"\n  hint: {hint}" if hint else ""))

    def __reduce__(self) -> tuple[type[DerivationError], tuple[str, Location | None, str]]:
        """Arguments to pickle an equal error."""
        return type(self), (self.message, self.location, self.hint)


class BudgetError(DerivationError):
    """A model that exceeds its budget of shapes or depth."""


class WorkerError(GrammarlabError):
    """A task that cannot be completed because its worker processes die."""


class FacadeError(GrammarlabError):
    """An invalid facade or facade file, with the place of the mistake."""


class TableError(GrammarlabError):
    """A table of text that cannot be read, with the line of the mistake but without the name of the file."""


class TomlError(GrammarlabError):
    """A text that is not TOML, without the name of the file.

    Args:
        message: what was expected and what was found.
        line: line of the mistake, from 1; None if it is unknown.
        column: column of the error, from 1.
    """

    def __init__(self, message: str, line: int | None = None, column: int | None = None) -> None:
        self.message = message
        self.line = line
        self.column = column
        super().__init__(message if line is None else f"{message} (line {line}, column {column})")

    def __reduce__(self) -> tuple[type[TomlError], tuple[str, int | None, int | None]]:
        """Arguments to pickle an equal error."""
        return type(self), (self.message, self.line, self.column)


class XmlError(GrammarlabError):
    """A text that is not XML, or XML that is not read, without the name of the file.

    Args:
        message: what was expected and what was found.
        line: line of the mistake, from 1; None if it is unknown.
        column: column of the error, from 1.
        code: number of the error, of `xml.parsers.expat.errors.codes`; 0 for other errors.
    """

    def __init__(self, message: str, line: int | None = None, column: int | None = None, code: int = 0) -> None:
        self.message = message
        self.line = line
        self.column = column
        self.code = code
        super().__init__(message)

    def __reduce__(self) -> tuple[type[XmlError], tuple[str, int | None, int | None, int]]:
        """Arguments to pickle an equal error."""
        return type(self), (self.message, self.line, self.column, self.code)


class InexactError(GrammarlabError):
    """A density that no grammar of the same form has exactly, or only one that is too large."""


class AssetError(GrammarlabError):
    """A mesh, image or footprint that is missing, broken, or outside its folder."""


class MissingAssetError(AssetError):
    """A file that is missing in an asset folder."""


class UnreadableAssetError(AssetError):
    """A mesh in an asset folder that is broken, too large, or in a format that is not read."""
