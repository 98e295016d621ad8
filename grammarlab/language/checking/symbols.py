"""Definitions behind the names of a rule file, and suggestions for unknown names."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from difflib import get_close_matches

from grammarlab.errors import Finding, Location, Severity
from grammarlab.language.syntax.syntax_tree import Attribute, Function, Import, Rule, RuleFile


@dataclass(frozen=True, slots=True)
class SupportedFeatures:
    """Supported features; None means all features."""

    operations: frozenset[str] | None = None
    """Operations, with or without a block, and ``inline``, ``union``, …, by name."""
    functions: frozenset[str] | None = None
    attributes: frozenset[str] | None = None
    """Shape attributes."""
    keywords: frozenset[str] | None = None
    """``operation:keyword``, as in ``split:x``, or ``function:keyword``."""
    constructs: frozenset[str] | None = None
    """Parts of the language: ``array``, ``element-wise``, ``import``, ``dynamic-import``, ``style``, ``variables``,
    ``comp-function``, ``connected`` (the separator ``=:``)."""
    harmless: frozenset[str] = frozenset()
    """Ignored operations and settable shape attributes that no shape depends on."""


EVERYTHING = SupportedFeatures()


class Remarks:
    """Collects findings."""

    def __init__(self) -> None:
        self._findings: dict[Finding, None] = {}

    def take(self, finding: Finding) -> None:
        """Add a finding, unless it was added before."""
        self._findings.setdefault(finding)

    def add(self, severity: Severity, code: str, location: Location, message: str, hint: str = "") -> None:
        """Make a finding."""
        self.take(Finding(severity, code, message, location, hint))

    def error(self, code: str, location: Location, message: str, hint: str = "") -> None:
        self.add("error", code, location, message, hint)

    def warning(self, code: str, location: Location, message: str, hint: str = "") -> None:
        self.add("warning", code, location, message, hint)

    def unsupported(self, names: frozenset[str] | None, name: str, location: Location, subject: str) -> None:
        """Report a CGA feature as unsupported, unless it is among `names`."""
        if names is not None and name not in names:
            self.add("unsupported", "unsupported", location, f"{subject} is CGA that grammarlab does not support yet")

    def left_out(self, location: Location, subject: str) -> None:
        """Warn of a feature that affects only texture coordinates, normals and details of materials."""
        self.add("warning", "left-out", location, f"{subject} is left out: no shape or colour depends on it")

    def in_order(self) -> tuple[Finding, ...]:
        """Findings in the order of the text."""
        return tuple(sorted(self._findings, key=lambda f: (f.location, f.severity, f.code, f.message)))


@dataclass(frozen=True, slots=True)
class Symbols:
    """Definitions of a rule file by name, including those of its styles."""

    rules: dict[str, set[int]] = field(default_factory=dict)
    """Numbers of parameters."""
    attributes: dict[str, Attribute] = field(default_factory=dict)
    functions: dict[str, dict[int, Function]] = field(default_factory=dict)
    """Overloads of each function by number of parameters."""
    libraries: dict[str, Symbols | None] = field(default_factory=dict)
    """Symbols of imported files, by alias; None for a file that was not read."""
    broken: frozenset[str] = frozenset()
    """Names in definitions with syntax errors, which may define them."""

    def library_of(self, name: str) -> Library | None:
        """The imported file that a dotted name begins with; None if there is none.

        A name may lead through imports of imports: ``distributor.Plant.Generate`` is the rule of the file that the
        file ``distributor`` imports as ``Plant``.
        """
        dots = (i for i, character in enumerate(name) if character == "." and name[:i] in self.libraries)
        dot = next(dots, 0)
        if not dot:
            return None
        alias, rest, symbols = name[:dot], name[dot + 1 :], self.libraries[name[:dot]]
        inner = symbols.library_of(rest) if symbols is not None else None
        return Library(alias, rest, symbols) if inner is None else replace(inner, alias=f"{alias}.{inner.alias}")

    def is_value(self, name: str) -> bool:
        """Whether a name without arguments has a value: an attribute, constant or function without parameters."""
        return name in self.attributes or 0 in self.functions.get(name, {})


@dataclass(frozen=True, slots=True)
class Library:
    """The imported file of a dotted name."""

    alias: str
    """The beginning of the name that means the file."""
    rest: str
    """The name within that file."""
    symbols: Symbols | None
    """Definitions of the file; None if it was not read."""


def collect(tree: RuleFile, libraries: Mapping[str, Symbols | None], broken: frozenset[str] = frozenset()) -> Symbols:
    """The symbols of a rule file.

    Args:
        tree: the file.
        libraries: symbols of imported files, by alias.
        broken: names in definitions with syntax errors.
    """
    symbols = Symbols(broken=broken)
    for definition in tree.definitions:
        if isinstance(definition, Rule):
            symbols.rules.setdefault(definition.name, set()).add(len(definition.parameters))
            if definition.keyword == "start":
                symbols.rules.setdefault("start", set()).add(len(definition.parameters))
        elif isinstance(definition, Attribute):
            symbols.attributes.setdefault(definition.name, definition)
        elif isinstance(definition, Function):
            symbols.functions.setdefault(definition.name, {}).setdefault(len(definition.parameters), definition)
        elif isinstance(definition, Import):
            symbols.libraries[definition.alias] = libraries.get(definition.alias)
    return symbols


def suggestion(name: str, candidates: Iterable[str]) -> str:
    """A hint with the nearest candidate; empty if none is near."""
    choices = sorted(set(candidates) - {name})
    folded = {choice.lower(): choice for choice in choices}
    if name.lower() in folded:
        return f"did you mean '{folded[name.lower()]}'?"
    # One of a few words was surely meant; among all names of a file and of CGA, a weak similarity is chance.
    nearest = get_close_matches(name, choices, n=1, cutoff=0.6 if len(choices) < 100 else 0.75)
    return f"did you mean '{nearest[0]}'?" if nearest else ""
