"""Species of trees by the names on a map: botanical or common ones, of species, genera or varieties."""

from __future__ import annotations

import unicodedata
from collections.abc import Iterable, Mapping

Words = tuple[str, ...]
MAX_SPECIES = 32
"""Most species of an intensity."""


def words_of(name: str) -> Words:
    """Words of a name as they are compared: composed (NFC), without regard to case.

    >>> words_of(" Quercus  robur 'Fastigiata'")
    ('quercus', 'robur', "'fastigiata'")
    """
    return tuple(unicodedata.normalize("NFC", name).casefold().split())


class SpeciesNames:
    """The species of a name: that of its longest beginning, word by word, that is known.

    >>> names = SpeciesNames({"oak": ["Quercus"], "holly": ["Quercus ilex", "Ilex"]})
    >>> names.of("QUERCUS ROBUR"), names.of("Quercus ilex"), names.of("Quercusoides")
    ('oak', 'holly', None)
    """

    def __init__(self, names: Mapping[str, Iterable[str]]) -> None:
        """Known names by species."""
        self._species = {words_of(name): species for species, known in names.items() for name in known}
        self._longest = max(map(len, self._species), default=0)

    def of(self, name: str) -> str | None:
        """The species of a name; None if it has no known beginning."""
        words = words_of(name)
        for length in range(min(len(words), self._longest), 0, -1):
            if words[:length] in self._species:
                return self._species[words[:length]]
        return None
