"""Variations of a document to choose from."""

from __future__ import annotations

from dataclasses import dataclass

from grammarlab.errors import FacadeError
from grammarlab.facade.editing.edit_sequences import distinct, ranked
from grammarlab.facade.editing.faults import find_faults
from grammarlab.facade.editing.grids import aligned, following, grid_of, kinds
from grammarlab.facade.editing.retarget import affordable
from grammarlab.facade.editing.slab_counts import changed_slabs
from grammarlab.facade.editing.variations import unedited, vary
from grammarlab.facade.sizes.solve import Resized
from grammarlab.facade.tree import X
from grammarlab.pages.editor.document import Document, varied

_WORK = 400_000
"""Largest number of leaves of all variations: some seconds."""


@dataclass(frozen=True, eq=False)
class Suggestion:
    """A variation with solved sizes."""

    document: Document
    words: str
    resized: Resized
    missing: tuple[str, ...]
    """Parts of the edit that were not possible."""
    faults: tuple[str, ...]
    """Kinds of faults that a person sees."""

    @property
    def is_flawed(self) -> bool:
        """Whether it has contradictions or missing parts."""
        return bool(self.missing or self.resized.conflict)


@dataclass(frozen=True, eq=False)
class Suggestions:
    """Results of adding or removing one column or row."""

    document: Document
    """The document before the edit."""
    variations: tuple[Suggestion, ...]
    """Those with fewer kinds of faults first, flawed ones last."""
    total: int
    """Number of different ones."""
    discarded: tuple[str, ...]
    """Impossible edits, with reasons."""


def suggest(document: Document, grid: str, axis: int, *, more: bool, most: int) -> Suggestions:
    """Variations of a grid and of those that follow it; of the largest one also columns or rows of the whole facade.

    Args:
        document: the document to vary.
        grid: name of the active grid.
        axis: X for columns, Y for rows.
        more: whether to add a column or row; otherwise one is removed.
        most: largest number of results.

    Raises:
        FacadeError: If the facade is too large to try all, or has no such grid.
    """
    facade = document.facade
    grid_of(facade, grid)
    if not affordable(facade, grid, axis, _WORK):
        raise FacadeError("The facade is too large to try all variations of this grid; choose a smaller grid.")
    also = tuple(dict.fromkeys((*following(facade, grid), *aligned(facade, grid, axis))))
    variations = vary(facade, grid, axis, also=also, insertions=more, removals=not more)
    kind = kinds(facade)
    order = [
        variation
        for flawed in (False, True)
        for variation in ranked([v for v in variations.variations if bool(v.missing) == flawed], kind, different=most)
    ]
    whole: dict[int, str] = {}
    if grid == max(facade.grids, key=lambda one: len(one.node)).name:
        choices = list(changed_slabs(unedited(facade), axis, 1 if more else -1))
        whole = {id(choice.variation): str(choice) for choice in choices}
        order = list(distinct([*(choice.variation for choice in choices), *order], kind))
    suggestions = []
    for variation in order[:most]:
        edited, resized = varied(document, variation, axis, in_line=id(variation) in whole)
        steps = (whole[id(variation)],) if id(variation) in whole else variation.steps
        faults = find_faults(facade, variation, resized.facade).words
        suggestions.append(Suggestion(edited, _words(steps), resized, variation.missing, faults))
    suggestions.sort(key=lambda suggestion: (suggestion.is_flawed, len(suggestion.faults)))
    return Suggestions(document, tuple(suggestions), len(order), variations.discarded)


def none_found(suggestions: Suggestions, grid: str, axis: int, *, more: bool) -> str:
    """Reason why there is nothing to choose from; empty if there is something."""
    if suggestions.variations:
        return ""
    name = "column" if axis == X else "row"
    why = suggestions.discarded[0] if suggestions.discarded else f"it has one {name}"
    return f"No {name} of {grid} can be {'added' if more else 'removed'}: {why}"


def _words(steps: tuple[str, ...]) -> str:
    """The steps without the names of the grids, which the person chose."""
    return "; ".join(step.rpartition(": ")[2] for step in steps).capitalize()
