"""Names of inferred symbols: single letters, capitals for elements."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import count
from string import ascii_lowercase, ascii_uppercase


class SymbolNames:
    """Unused letters; after all of them, letters with primes."""

    def __init__(self) -> None:
        self.used: set[str] = set()

    def new(self, label: str) -> str:
        """A capital for an element, preferably the first letter of its label; a small letter for no label."""
        name = next(each for each in _tried(label) if each not in self.used)
        self.used.add(name)
        return name


def _tried(label: str) -> Iterator[str]:
    initials = [word[0].upper() for word in label.split() if word[0].isalpha() and len(word[0].upper()) == 1]
    letters = [*initials, *ascii_uppercase] if label else ascii_lowercase
    for primes in count():
        yield from (letter + "'" * primes for letter in letters)
