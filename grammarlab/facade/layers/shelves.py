"""Alignments of words on demand: the best, the next best, and so on, each searched for once."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property

from grammarlab.facade.layers.alignment.align import Aligned, Alignment, align, problem_of
from grammarlab.facade.layers.alignment.naming import Element
from grammarlab.facade.layers.alignment.pairs import PairProblem
from grammarlab.facade.layers.letters import Word
from grammarlab.facade.layers.sizing.demands import SizeEquations, demands
from grammarlab.facade.layers.weights import Weights


@dataclass
class SearchBudget:
    """Remaining steps of searches."""

    left: int
    stop: Callable[[], bool] = lambda: False
    """Whether the caller has cancelled the search."""

    @property
    def is_spent(self) -> bool:
        """Whether searches have to end now."""
        return self.left <= 0 or self.stop()


@dataclass
class Shelf:
    """Alignments of the same words."""

    words: tuple[Word, ...]
    canvas: float
    weights: Weights
    tolerance: float
    budget: SearchBudget
    sizing: float
    """Weight of strains in the energy."""
    gaps: bool
    known: Aligned = field(default_factory=lambda: Aligned((), 0.0, done=False))
    asked: int = 0
    """Number of alignments that have been requested from searches."""
    cutoff: float = -math.inf
    """Largest energy of the last search."""
    demanded: dict[tuple[tuple[Element, ...], ...], SizeEquations] = field(default_factory=dict)

    @property
    def varied(self) -> bool:
        """Whether the words differ: alignments of equal words all look the same."""
        return any(word != self.words[0] for word in self.words)

    def at(self, place: int, cutoff: float) -> Alignment | None:
        """The alignment of this rank in energy; None if its energy is above the cutoff or effort ran out."""
        missing = place >= len(self.known.best) and not self.sure(place, cutoff)
        if missing and not self.budget.is_spent:
            self._search(max(place + 1, 2 * place), max(cutoff, self.cutoff))
        if place < len(self.known.best) and self.energy(place) <= cutoff:
            return self.known.best[place]
        return None

    def demands(self, place: int) -> SizeEquations:
        """Size equations of a known alignment."""
        cells = self.known.best[place].cells
        if cells not in self.demanded:
            self.demanded[cells] = demands(self.known.best[place], self.canvas, gaps=self.gaps)
        return self.demanded[cells]

    def energy(self, place: int) -> float:
        """Lower bound of the energy of a layout with this alignment."""
        found = self.known.best[place]
        return found.energy + self.sizing * found.strain

    def sure(self, place: int, cutoff: float) -> bool:
        """Whether it is certain that there is no alignment at this place."""
        exhausted = self.known.done and len(self.known.best) < self.asked and cutoff <= self.cutoff
        return place < len(self.known.best) or exhausted

    @cached_property
    def _problem(self) -> PairProblem:
        return problem_of(
            self.words, self.canvas, self.weights, tolerance=self.tolerance, sizing=self.sizing, gaps=self.gaps,
            finest=True,
        )  # fmt: skip

    def _search(self, count: int, cutoff: float) -> None:
        found = align(
            self.words, self.canvas, self.weights, count,
            tolerance=self.tolerance, effort=max(self.budget.left // 4, 1_000), cutoff=cutoff,
            sizing=self.sizing, gaps=self.gaps, problem=self._problem,
        )  # fmt: skip
        self.budget.left -= found.steps
        if found.done or len(found.best) >= len(self.known.best):
            self.known, self.asked, self.cutoff = found, count, cutoff
