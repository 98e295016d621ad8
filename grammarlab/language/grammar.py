"""Rule file as a value: text, syntax tree, and look-ups by name."""

from __future__ import annotations

import codecs
import hashlib
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from itertools import takewhile
from pathlib import Path
from typing import TypeVar

from grammarlab.asset_roots import AssetRoot
from grammarlab.errors import AssetError, Finding, LanguageError, Location
from grammarlab.files import read_bounded
from grammarlab.language.syntax.parse import MAX_CHARACTERS, parse
from grammarlab.language.syntax.syntax_tree import (
    Attribute,
    Definition,
    Function,
    Import,
    Rule,
    RuleFile,
    Style,
    number,
)

_UTF_16 = codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE
_NO_TEXT = re.compile(r"[\x00-\x06\x0e-\x1a\x1c-\x1f\x7f]")
"""Control characters that no text has: all but bell, backspace, white space and escape."""
_K = TypeVar("_K")
_T = TypeVar("_T")

EXAMPLE = 'gl.load("toy") or gl.Grammar.parse("Lot --> extrude(3)")'
"""Expressions of a grammar, for messages."""


@dataclass(frozen=True)
class Grammar:
    """A rule file without syntax errors; grammars of equal text are equal.

    >>> import grammarlab as gl
    >>> grammar = gl.Grammar.parse("Lot --> 50% : extrude(3) Low else : extrude(9) High")
    >>> [rule.name for rule in grammar.start_rules]
    ['Lot']
    """

    text: str
    """The whole rule file, without a byte order mark and with Unix line ends."""
    tree: RuleFile = field(compare=False, repr=False)
    """Syntax tree of the text."""
    file: str = field(default="<text>", compare=False)
    """Name of the file as the user gave it, for messages."""
    libraries: Mapping[str, Grammar | None] = field(default_factory=dict, compare=False, repr=False)
    """The imported rule files by alias; None for one that could not be read. See `grammarlab.language.importing`."""
    import_findings: tuple[Finding, ...] = field(default=(), compare=False, repr=False)
    """Findings about the imports."""
    assets: AssetRoot | None = field(default=None, compare=False, repr=False)
    """Folder of the meshes and images that the rules name, if it is known: derivations use it unless given another."""

    @classmethod
    def parse(cls, text: str, file: str = "<text>") -> Grammar:
        """Parse a rule file.

        Args:
            text: the whole file, with any line ends.
            file: name of the file, for messages.

        Raises:
            LanguageError: If the file has syntax errors; it lists all of them.
        """
        text = normal(text)
        parsed = parse(text, file)
        if parsed.findings:
            raise LanguageError(parsed.findings, text)
        number(parsed.tree)
        return cls(text, parsed.tree, file)

    @cached_property
    def hash(self) -> str:
        """SHA-256 of the text in UTF-8, in hexadecimal: the same for all encodings and line ends of a file."""
        return hash_of(self.text)

    @cached_property
    def rules(self) -> dict[tuple[str, int], Rule]:
        """Rules by name and number of parameters, without those of styles; of duplicates the first."""
        return _first_by_key(((rule.name, len(rule.parameters)), rule) for rule in self._of_default_style(Rule))

    @cached_property
    def attributes(self) -> dict[str, Attribute]:
        """The attributes and constants by name."""
        return _first_by_key((attribute.name, attribute) for attribute in self._of_default_style(Attribute))

    @cached_property
    def functions(self) -> dict[tuple[str, int], Function]:
        """The functions by name and number of parameters."""
        definitions = self._of_default_style(Function)
        return _first_by_key(((function.name, len(function.parameters)), function) for function in definitions)

    @cached_property
    def imports(self) -> dict[str, Import]:
        """The import statements by alias."""
        return _first_by_key((statement.alias, statement) for statement in self._of_default_style(Import))

    @property
    def start_rules(self) -> tuple[Rule, ...]:
        """Start rules: those marked ``@StartRule`` or ``start``, otherwise the first rule."""
        return start_rules(self.tree)

    @property
    def start_rule(self) -> Rule | None:
        """The first of `start_rules`; None in a file without rules."""
        return next(iter(self.start_rules), None)

    def _of_default_style(self, kind: type[_T]) -> tuple[_T, ...]:
        return tuple(definition for definition in default_style(self.tree) if isinstance(definition, kind))


def is_start_rule(rule: Rule) -> bool:
    """Whether a rule is marked as a start rule."""
    return rule.keyword == "start" or any(mark.name.lower() == "startrule" for mark in rule.annotations)


def start_rules(tree: RuleFile) -> tuple[Rule, ...]:
    """Start rules of the default style: the marked ones, otherwise the first rule."""
    rules = tuple(node for node in default_style(tree) if isinstance(node, Rule))
    return tuple(rule for rule in rules if is_start_rule(rule)) or rules[:1]


def default_style(tree: RuleFile) -> Iterable[Definition]:
    """Definitions of the default style: those before the first style."""
    return takewhile(lambda definition: not isinstance(definition, Style), tree.definitions)


def hash_of(text: str) -> str:
    r"""SHA-256 of a text in UTF-8, in hexadecimal; byte order mark and kind of line ends do not matter.

    >>> hash_of("Lot --> A\r\n") == hash_of("\ufeffLot --> A\n")
    True
    """
    return hashlib.sha256(normal(text).encode("utf-8", "surrogatepass")).hexdigest()


def normal(text: str) -> str:
    """A text without a byte order mark, with Unix instead of Windows or old Mac line ends."""
    return text.removeprefix("\ufeff").replace("\r\n", "\n").replace("\r", "\n")


def may_import(text: str) -> bool:
    """Whether a text has the word that imports begin with; also in a comment."""
    return re.search(r"\bimport\b", text) is not None


def read_text(path: Path) -> str:
    """Text of a rule file in UTF-8, in UTF-16 with a byte order mark, or otherwise in Windows-1252; see `normal`.

    Raises:
        LanguageError: If the file cannot be read, is too large, or is no text.
    """
    try:
        content = read_bounded(path, 4 * MAX_CHARACTERS)
    except OSError as error:
        reason = error.strerror or str(error)
        raise _unreadable(path, "missing-file", f"cannot read the rule file {path}: {reason}") from error
    except AssetError as error:
        raise _unreadable(path, "unreadable-file", f"cannot read the rule file {error}") from error
    text = _decoded(content)
    # A single one in a text has a place, which is reported.
    if len(_NO_TEXT.findall(text)) > 1:
        reason = "it has control characters, as binary files have, and UTF-16 without a byte order mark; rules are text"
        raise _unreadable(path, "unreadable-file", f"cannot read the rule file {path}: {reason}")
    return normal(text)


def _decoded(content: bytes) -> str:
    encodings = ("utf-16",) if content.startswith(_UTF_16) else ("utf-8", "cp1252")
    for encoding in encodings:
        try:
            return content.decode(encoding)
        except UnicodeDecodeError:
            continue
    return content.decode("latin-1")  # never fails


def _unreadable(path: Path, code: str, message: str) -> LanguageError:
    return LanguageError((Finding("error", code, message, Location(file=str(path))),))


def _first_by_key(pairs: Iterable[tuple[_K, _T]]) -> dict[_K, _T]:
    result: dict[_K, _T] = {}
    for key, value in pairs:
        result.setdefault(key, value)
    return result
