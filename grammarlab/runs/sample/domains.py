"""Domains: kinds of files that describe designs, found by their suffix: rule files, species, and Arbaro's trees."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any, Generic, Protocol, TypeVar

from grammarlab.asset_roots import AssetRoot
from grammarlab.errors import Finding, LanguageError, UsageError

if TYPE_CHECKING:  # these load learning libraries, which drawing does not need
    from grammarlab.learning.designs.design_space import AbstractDesignSpace
    from grammarlab.learning.targets.writers import AbstractTargetWriter

DEFAULT = ".cga"
"""Default suffix for files of unknown suffixes."""
SPECIES = ".toml"
"""Suffix of files of species."""
DOMAINS = {
    DEFAULT: "grammarlab.runs.sample.grammar_models:GrammarDomain",
    SPECIES: "grammarlab.runs.sample.species_models:SpeciesDomain",
    ".xml": "grammarlab.runs.sample.species_models:ArbaroDomain",
}
"""Module and name of the `AbstractDomain` of each suffix, imported when needed; made without arguments."""
CONVERTED = {".xml": SPECIES}
"""Suffix of the domain of the text from `AbstractDomain.read`, if it is another one."""

Space = TypeVar("Space", bound="AbstractDesignSpace[Any]")
Models = TypeVar("Models")
"""An `AbstractModels` (`grammarlab.runs.sample.models`)."""


class CheckedText(Protocol):
    """The text of a file with what was found in it."""

    @property
    def text(self) -> str:
        """The whole file."""
        ...

    @property
    def findings(self) -> tuple[Finding, ...]:
        """Findings in the order of its text."""
        ...


@dataclass(frozen=True, slots=True)
class _Checked:
    """A `CheckedText`."""

    text: str
    findings: tuple[Finding, ...]


class AbstractDomain(ABC, Generic[Space, Models]):
    """A kind of files that describe designs."""

    @abstractmethod
    def read(self, path: Path, library: Path | str | None = None) -> str:
        """Text of a file, merged with all other files that it needs except assets.

        Args:
            path: the file.
            library: a folder of further projects that rule files import from.

        Raises:
            LanguageError: If it cannot be read or is too large.
        """

    def check(self, path: Path, assets: AssetRoot) -> Sequence[CheckedText]:
        """Findings about a file, then about each further file that it needs.

        Raises:
            LanguageError: If the file cannot be read, or is too large.
        """
        text = self.read(path)
        try:
            self.models(text, path.stem, assets)
        except LanguageError as error:
            return (_Checked(text, error.findings),)
        return (_Checked(text, ()),)

    def formatted(self, text: str, file: str, suffix: str) -> str:
        """A text in the canonical style of files of a suffix.

        Args:
            text: text of one file.
            file: its name, for messages.
            suffix: suffix of the result.

        Raises:
            LanguageError: If the text has errors.
            UsageError: If it cannot be written as such a file.
        """
        raise UsageError(f"{file}: files of this kind cannot be written as {suffix} files.")

    @abstractmethod
    def open(self, text: str, name: str, assets: AssetRoot) -> Space:
        """Design space of a text.

        Args:
            text: text from `read`; `AbstractDesignSpace.hashes` are `hashes_of` its SHA-256.
            name: name of the file without its suffix, for messages.
            assets: folder of meshes and images.

        Raises:
            LanguageError: If the text has errors.
        """

    @abstractmethod
    def writer(self, space: Space) -> AbstractTargetWriter[Any]:
        """Writer of files of this kind for learned densities."""

    @abstractmethod
    def models(self, text: str, name: str, assets: AssetRoot) -> Models:
        """Models of a text for runs, without what only learning needs.

        Args:
            text: text from `read`.
            name: name of the file without its suffix, for messages.
            assets: folder of meshes and images.

        Raises:
            LanguageError: If the text has errors.
        """


def domain_of(suffix: str) -> AbstractDomain[Any, Any]:
    """Domain of files with a suffix.

    Raises:
        UsageError: If no domain has it.
    """
    if suffix not in DOMAINS:
        raise UsageError(f"files that end in {suffix!r} cannot be read; expected one of {', '.join(sorted(DOMAINS))}.")
    module, name = DOMAINS[suffix].split(":")
    return getattr(import_module(module), name)()


def suffix_of(path: Path) -> str:
    """The suffix of a file if it is a known one; that of rule files otherwise."""
    return path.suffix if path.suffix in DOMAINS else DEFAULT


@lru_cache(maxsize=4)
def opened(suffix: str, text: str, name: str, assets: AssetRoot) -> AbstractDesignSpace[Any]:
    """Design space of a text, made once per process; see `AbstractDomain.open`."""
    return domain_of(suffix).open(text, name, assets)


@lru_cache(maxsize=4)
def opened_models(suffix: str, text: str, name: str, assets: AssetRoot) -> Any:
    """Models of a text for runs, made once per process; see `AbstractDomain.models`."""
    return domain_of(suffix).models(text, name, assets)
