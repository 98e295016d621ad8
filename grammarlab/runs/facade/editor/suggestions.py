"""Variations of a document to choose from."""

from __future__ import annotations

from dataclasses import dataclass

from grammarlab.errors import FacadeError
from grammarlab.facade.grids.editing import aligned, following, grid_of
from grammarlab.facade.grids.kinds import kinds
from grammarlab.facade.retargeting.stepwise import affordable
from grammarlab.facade.sizes.solve import Resized
from grammarlab.facade.tree import X
from grammarlab.facade.variations.ranking import ranked
from grammarlab.facade.variations.single import vary
from grammarlab.runs.facade.editor.document import Document, varied

_WORK = 400_000
"""Leaves of all variations: some seconds."""


@dataclass(frozen=True, eq=False)
class Suggestion:
    """A variation whose sizes have been solved for."""

    document: Document
    words: str
    resized: Resized
    missing: tuple[str, ...]
    """What it could not do."""

    @property
    def is_flawed(self) -> bool:
        """Whether something of it contradicts something, or is not there."""
        return bool(self.missing or self.resized.conflict)


@dataclass(frozen=True, eq=False)
class Suggestions:
    """What one column or row more or less leads to."""

    of: Document
    found: tuple[Suggestion, ...]
    """The best and most different first, flawed ones last."""
    total: int
    """How many different ones there are."""
    discarded: tuple[str, ...]
    """What is not possible, and why."""


def suggest(document: Document, grid: str, axis: int, *, more: bool, most: int) -> Suggestions:
    """Variations of a grid and of those that go with it.

    Args:
        document: what is varied.
        grid: name of the active grid.
        axis: X for columns, Y for rows.
        more: one more, or else one fewer.
        most: how many.

    Raises:
        FacadeError: when the facade is too large to try all, or has no such grid.
    """
    facade = document.facade
    grid_of(facade, grid)
    if not affordable(facade, grid, axis, _WORK):
        raise FacadeError("The facade is too large for all variations of this grid to be tried; choose a smaller grid.")
    also = tuple(dict.fromkeys((*following(facade, grid), *aligned(facade, grid, axis))))
    tried = vary(facade, grid, axis, also=also, insertions=more, removals=not more)
    kind = kinds(facade)
    order = [
        each
        for flawed in (False, True)
        for each in ranked([one for one in tried.found if bool(one.missing) == flawed], kind, different=most)
    ]
    found = []
    for variation in order[:most]:
        made, resized = varied(document, variation, axis)
        found.append(Suggestion(made, _words(variation.steps), resized, variation.missing))
    return Suggestions(document, tuple(sorted(found, key=lambda one: one.is_flawed)), len(order), tried.discarded)


def none_found(suggestions: Suggestions, grid: str, axis: int, *, more: bool) -> str:
    """Why there is nothing to choose from; empty when there is."""
    if suggestions.found:
        return ""
    name = "column" if axis == X else "row"
    why = suggestions.discarded[0] if suggestions.discarded else f"it has one {name}"
    return f"No {name} of {grid} can be {'added' if more else 'removed'}: {why}"


def _words(steps: tuple[str, ...]) -> str:
    """The steps without the names of the grids, which are those that the person chose."""
    return "; ".join(step.rpartition(": ")[2] for step in steps).capitalize()
