"""What patterns are written in: letters, one for each time that a symbol stands in a word (paper 003, section 3)."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Letter:
    """One symbol where it stands in a word."""

    symbol: str
    size: float | None
    """Metres that are preferred, > 0; None: as much as is left for it."""
    opaque: bool = True
    """Whether it hides what lies below it."""
    attached: bool = False
    """Whether its neighbours in the word stay beside it."""
    unoccludable: bool = False
    """Whether nothing that hides only in part may lie over it."""
    transparent: bool = False
    """Whether nothing of it is seen: a letter of a control pattern that nothing stands for."""
    mirrored: bool = False
    """Whether a reflection put it there."""
    covers: bool = True
    """Whether it is seen all along the other axis, so that it may hide that nothing is below it."""

    def __hash__(self) -> int:
        """Of the symbol alone: words are looked up often, and letters of a symbol mostly are alike."""
        return hash(self.symbol)

    @property
    def hides(self) -> bool:
        """Whether layers below may leave room for it."""
        return self.opaque and self.covers and not self.transparent


Word = tuple[Letter, ...]
"""One layer along one axis, from the left or from the bottom."""
