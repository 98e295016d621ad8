"""Learning curves: divergence of a learned density from the target density, by number of labels."""

from __future__ import annotations

from bisect import bisect_right
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

LEARNED_JS = 0.01
"""Jensen-Shannon divergence in nats at which the paper calls a density learned (section 4.7)."""


class Point(NamedTuple):
    """One round of a curve."""

    labels: int
    """Number of scores so far, all factors together."""
    js: float
    """Jensen-Shannon divergence in nats, 0 to ln 2."""
    correlation: float
    """Pearson correlation of the weights, -1 to 1 (appendix B of the paper)."""
    liked: int
    """Number of scores so far of models with a true score above 0."""


@dataclass(frozen=True, slots=True)
class Curve:
    """Rounds of one simulated person, by increasing number of labels."""

    points: tuple[Point, ...]

    def labels_to(self, js: float = LEARNED_JS) -> int | None:
        """The first number of labels with a divergence of at most ``js``; None if no round reaches it."""
        return next((point.labels for point in self.points if point.js <= js), None)

    def labels_until_below(self, js: float = LEARNED_JS) -> int | None:
        """The number of labels from which the divergence stays at most ``js``; None if the last round is above."""
        stays = None
        for point in reversed(self.points):
            if point.js > js:
                break
            stays = point.labels
        return stays

    def labels_before_first_liked(self) -> int | None:
        """Number of labels before the round that showed the first liked model; None if no round did."""
        before = 0
        for point in self.points:
            if point.liked:
                return before
            before = point.labels
        return None

    def since_first_liked(self) -> Curve:
        """The rounds from the one that showed the first liked model, as if they were the first ones.

        All labels of that round count, even those before the liked model. There are no rounds if no model is liked.
        """
        before = self.labels_before_first_liked()
        if before is None:
            return Curve(())
        later = (point for point in self.points if point.labels > before)
        return Curve(tuple(point._replace(labels=point.labels - before) for point in later))

    def until(self, max_labels: int) -> Curve:
        """The rounds with at most ``max_labels`` labels."""
        return Curve(tuple(point for point in self.points if point.labels <= max_labels))

    def js_at(self, labels: int, before: float) -> float:
        """Divergence after ``labels`` scores: that of the last round with at most this number.

        Args:
            labels: number of labels, any integer.
            before: the divergence before the first round.
        """
        index = bisect_right([point.labels for point in self.points], labels)
        return self.points[index - 1].js if index else before


@dataclass(frozen=True, slots=True)
class Summary:
    """Summary of numbers of labels, some of which may be missing for runs that never reach the target."""

    median: float | None
    """Median number of labels; None if at least half of the runs never reach the target."""
    lowest: int | None
    """Smallest number of labels; None if no run reaches the target."""
    highest: int | None
    """Largest number of labels; None if some run never reaches the target."""
    reached: int
    """Number of runs that reach the target."""
    runs: int


def summarize(labels: list[int | None]) -> Summary:
    """Median and spread over runs; a run that never reaches the target counts as later than all others."""
    values = np.array([np.inf if value is None else value for value in labels])
    finite = values[np.isfinite(values)].astype(int).tolist()
    # The upper of two middle values if one is missing: infinity wins.
    median = float(np.median(values)) if len(values) else np.inf
    return Summary(
        median if np.isfinite(median) else None,
        min(finite, default=None),
        max(finite) if finite and len(finite) == len(values) else None,
        len(finite),
        len(values),
    )
