"""Learning curves: how far a learned density is from the wanted one after each number of labels."""

from __future__ import annotations

from bisect import bisect_right
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

CLOSE = 0.01
"""Nats: the Jensen-Shannon divergence at which the paper calls a density learned (section 4.7)."""


class Point(NamedTuple):
    """One round of a curve."""

    labels: int
    """Scores given so far, all factors together."""
    js: float
    """Jensen-Shannon divergence in nats, 0 to ln 2."""
    correlation: float
    """Pearson correlation of the weights, -1 to 1 (appendix B of the paper)."""
    liked: int
    """How many of the scores so far are of models that the person likes: truly above 0, whatever was said."""


@dataclass(frozen=True, slots=True)
class Curve:
    """One simulated person's rounds, in order; the number of labels grows."""

    points: tuple[Point, ...]

    def labels_to(self, js: float = CLOSE) -> int | None:
        """The first number of labels with a divergence of at most ``js``, None when no round gets there."""
        return next((point.labels for point in self.points if point.js <= js), None)

    def labels_until_below(self, js: float = CLOSE) -> int | None:
        """The number of labels from which on the divergence stays at most ``js``, None when the last round is above."""
        stays = None
        for point in reversed(self.points):
            if point.js > js:
                break
            stays = point.labels
        return stays

    def labels_before_first_liked(self) -> int | None:
        """The labels before the round that showed the first model that is liked; None where none did."""
        before = 0
        for point in self.points:
            if point.liked:
                return before
            before = point.labels
        return None

    def since_first_liked(self) -> Curve:
        """The rounds from the one on that showed the first model that is liked, as if they were the first ones.

        All labels of that round count, also those that were given before the liked model came. Without rounds where no
        model is liked.
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
        """The divergence once ``labels`` scores are given: that of the last round with at most as many.

        Args:
            labels: any number.
            before: the divergence before the first round.
        """
        place = bisect_right([point.labels for point in self.points], labels)
        return self.points[place - 1].js if place else before


@dataclass(frozen=True, slots=True)
class Summary:
    """Several numbers of labels, of which some may be missing: runs that never got there."""

    median: float | None
    """None when at least half of the runs never got there."""
    lowest: int | None
    """None when no run got there."""
    highest: int | None
    """None when some run never got there."""
    reached: int
    """How many runs got there."""
    runs: int


def summarize(labels: list[int | None]) -> Summary:
    """The median and the spread over runs; a run that never got there counts as later than all others."""
    values = np.array([np.inf if value is None else value for value in labels])
    found = values[np.isfinite(values)].astype(int).tolist()
    # The upper of two middle values, where they differ in being there at all: infinity wins.
    median = float(np.median(values)) if len(values) else np.inf
    return Summary(
        median if np.isfinite(median) else None,
        min(found, default=None),
        max(found) if found and len(found) == len(values) else None,
        len(found),
        len(values),
    )
