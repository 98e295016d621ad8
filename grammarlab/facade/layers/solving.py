"""Counters, alignment and sizes together: the layouts of least energy."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass

from grammarlab.facade.layers.alignment import Alignment
from grammarlab.facade.layers.letters import Word
from grammarlab.facade.layers.sizing import Sizing
from grammarlab.facade.layers.weights import Weights

Group = tuple[int, str]
"""An axis, 0 for x and 1 for y, and the name of an alignment group on it."""


@dataclass(frozen=True)
class Candidate:
    """A word for each layer and axis."""

    counters: Mapping[str, int]
    words: Mapping[Group, tuple[Word, ...]]
    """Of each group, from its top layer down."""


@dataclass(frozen=True)
class Layout:
    """A candidate that is aligned and sized."""

    candidate: Candidate
    alignments: Mapping[Group, Alignment]
    sizing: Sizing
    energy: float
    bound: float
    """No layout that comes after those before it in the list has less energy than this, within `tolerance`."""
    proven: bool
    tolerance: float
    """Metres, mu."""

    @property
    def groups(self) -> tuple[Group, ...]:
        """In the order of `sizing.placed`."""
        return tuple(self.alignments)


Candidates = Callable[[float], Iterable[Candidate]]
"""All candidates whose words fit the canvas within a tolerance, metres."""


def solve(
    candidates: Candidates,
    canvas: tuple[float, float],
    weights: Weights,
    count: int = 1,
    *,
    tolerances: Sequence[float],
    gaps: bool = False,
    effort: int = 200_000,
) -> list[Layout]:
    """The best different layouts, best first; none where even the last tolerance has none.

    Args:
        candidates: of a tolerance.
        canvas: width and height, metres.
        weights: of the energy.
        count: how many.
        tolerances: metres, growing; the first with a layout is what is searched whole.
        gaps: see `size_letters`.
        effort: see `alignments`.
    """
    raise NotImplementedError
