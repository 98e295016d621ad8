"""Letters: occurrences of symbols in words (paper 003, section 3)."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Letter:
    """An occurrence of a symbol in a word."""

    symbol: str
    size: float | None
    """Preferred size, metres, > 0; None: the letter takes the remaining length."""
    opaque: bool = True
    """Whether it hides the layers below it."""
    attached: bool = False
    """Whether its neighbours in the word stay adjacent to it."""
    unoccludable: bool = False
    """Whether no element that covers only a part may lie over it."""
    transparent: bool = False
    """Whether it is invisible: a letter of a control pattern without content."""
    mirrored: bool = False
    """Whether a reflection made it."""
    covers: bool = True
    """Whether it is visible along the whole other axis, so that it can hide an empty place below it."""

    def __hash__(self) -> int:
        """Hash of the symbol only: words are looked up often, and letters of a symbol are mostly equal."""
        return hash(self.symbol)

    @property
    def hides(self) -> bool:
        """Whether layers below may leave gaps for it."""
        return self.opaque and self.covers and not self.transparent


Word = tuple[Letter, ...]
"""One layer along one axis, from the left or from the bottom."""
