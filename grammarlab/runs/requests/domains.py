"""Kinds of files that describe designs, found by their suffix.

A package adds a kind by an entry point of the group ``grammarlab.domains``, which is called after the suffix without
its dot and names an `AbstractDomain` with a constructor without arguments. Rule files are one kind among others.
"""

from __future__ import annotations

import sys
from abc import ABC, abstractmethod
from functools import lru_cache
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path
from typing import TYPE_CHECKING, Any, Generic, TypeVar

from grammarlab.errors import UsageError

if TYPE_CHECKING:  # these load what learns, which drawing need not wait for
    from grammarlab.learning.designs.design_space import AbstractDesignSpace
    from grammarlab.learning.targets.target import AbstractTargetWriter

GROUP = "grammarlab.domains"
DEFAULT = ".cga"
"""How files whose suffix nobody has claimed are read."""
OWN = (EntryPoint("cga", "grammarlab.runs.models.grammar_domain:GrammarDomain", GROUP),)
"""Named here rather than by the installation, so that a checkout that was never installed reads its rule files."""

Space = TypeVar("Space", bound="AbstractDesignSpace[Any]")
Models = TypeVar("Models")
"""An `AbstractModels` (`grammarlab.runs.models.abstract`)."""


class AbstractDomain(ABC, Generic[Space, Models]):
    """What files of one kind mean."""

    @abstractmethod
    def read(self, path: Path) -> str:
        """What a file says, with all other files that it needs but assets.

        Raises:
            LanguageError: when it cannot be read or is too large.
        """

    @abstractmethod
    def open(self, text: str, name: str, assets: Path) -> Space:
        """The designs that a text describes.

        Args:
            text: as `read` gives it; `AbstractDesignSpace.hashes` are `hashes_of` its SHA-256.
            name: of the file, without its suffix, for messages.
            assets: folder of meshes and images.

        Raises:
            LanguageError: when the text has errors.
        """

    @abstractmethod
    def writer(self, space: Space) -> AbstractTargetWriter[Any]:
        """What makes files of this kind from what was learned about a space."""

    @abstractmethod
    def models(self, space: Space) -> Models:
        """The designs of a space as runs make them; `grammarlab.runs.models.abstract.RealizedModels` fits any space."""


def domain_of(suffix: str) -> AbstractDomain[Any, Any]:
    """What files with a suffix mean.

    Raises:
        UsageError: when no installed package says so.
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
    """The designs that a text describes: made once a process; see `AbstractDomain.open`."""
    return domain_of(suffix).open(text, name, assets)


@lru_cache(maxsize=1)
def _known(_path: tuple[str, ...]) -> dict[str, EntryPoint]:
    """The entry points by suffix on a path of packages; of two for one suffix the first one counts."""
    return {f".{point.name}": point for point in reversed((*OWN, *entry_points(group=GROUP)))}
