"""Domains: kinds of files that describe designs, found by their suffix.

A package adds a kind by an entry point of the group `GROUP`. Its name is the suffix without the dot,
and its object an `AbstractDomain` with a constructor without arguments. Rule files are one kind among others.
"""

from __future__ import annotations

import sys
from abc import ABC, abstractmethod
from functools import lru_cache
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path
from typing import TYPE_CHECKING, Any, Generic, TypeVar

from grammarlab.errors import UsageError

if TYPE_CHECKING:  # these load learning libraries, which drawing does not need
    from grammarlab.learning.designs.design_space import AbstractDesignSpace
    from grammarlab.learning.targets.writers import AbstractTargetWriter

GROUP = "grammarlab.domains"
DEFAULT = ".cga"
"""Default suffix for files of unknown suffixes."""
OWN = (EntryPoint("cga", "grammarlab.runs.sample.grammar_models:GrammarDomain", GROUP),)
"""Built-in domain of rule files, so that it works in a checkout that is not installed."""

Space = TypeVar("Space", bound="AbstractDesignSpace[Any]")
Models = TypeVar("Models")
"""An `AbstractModels` (`grammarlab.runs.sample.models`)."""


class AbstractDomain(ABC, Generic[Space, Models]):
    """A kind of files that describe designs."""

    @abstractmethod
    def read(self, path: Path) -> str:
        """Text of a file, merged with all other files that it needs except assets.

        Raises:
            LanguageError: If it cannot be read or is too large.
        """

    @abstractmethod
    def open(self, text: str, name: str, assets: Path) -> Space:
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
    def models(self, space: Space) -> Models:
        """Models of a space for runs; `grammarlab.runs.sample.models.RealizedModels` fits any space."""


def domain_of(suffix: str) -> AbstractDomain[Any, Any]:
    """Domain of files with a suffix.

    Raises:
        UsageError: If no installed package has it.
    """
    known = _known(tuple(sys.path))
    if suffix not in known:
        raise UsageError(
            f"nothing that is installed reads files that end in {suffix!r}; expected one of "
            f"{', '.join(sorted(known))}. Install the package that reads them, or install it anew."
        )
    return known[suffix].load()()


def suffix_of(path: Path) -> str:
    """The suffix of a file if it is a known one; that of rule files otherwise."""
    return path.suffix if path.suffix in _known(tuple(sys.path)) else DEFAULT


@lru_cache(maxsize=4)
def opened(suffix: str, text: str, name: str, assets: Path) -> AbstractDesignSpace[Any]:
    """Design space of a text, made once per process; see `AbstractDomain.open`."""
    return domain_of(suffix).open(text, name, assets)


@lru_cache(maxsize=1)
def _known(_path: tuple[str, ...]) -> dict[str, EntryPoint]:
    """Entry points by suffix on a path of packages; of two for one suffix the first one is used."""
    return {f".{point.name}": point for point in reversed((*OWN, *entry_points(group=GROUP)))}
