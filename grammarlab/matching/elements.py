"""Elements of a scan: the points in the box of each window, door or column.

For fits they are one array: a bounded number of points per element, relative to the centre of its box.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from grammarlab.arrays import Floats, Ints, row_of_value
from grammarlab.errors import FacadeError

MOST_ELEMENTS = 10_000
"""Largest number of elements."""
MOST_POINTS = 50_000_000
"""Largest number of points of a scan."""
FARTHEST = 1e9
"""Largest coordinate, metres."""
_MIN_POINTS = 8
"""Least number of points of an element that can be matched."""
_MAX_POINTS = 64
"""Largest number of points per element; a larger cloud is sampled evenly, and each point gets more weight."""
_COMMON_ERROR_RATIO = 0.2
"""Standard deviation of the common error of all sizes, in point distances: simulated openings came out up to .3 too
large, the more the more of their jambs is scanned."""
_POINT_STEP = 16
"""Step of the number of points, so that few sizes are compiled."""
_MAX_WEIGHT = 2.0
"""Largest weight of a point: errors of nearby points are not independent."""
_TRIM_SHARE = 0.04
"""Fraction of the points on each side that is ignored for the extent of an element."""


@dataclass(frozen=True, eq=False)
class Truth:
    """Ground truth of a synthetic scene."""

    kind: Ints
    """[N] kind of each element, from 0; elements of one kind are replicas of each other."""
    names: tuple[str, ...]
    """[K] template of each kind."""
    parameters: tuple[dict[str, float], ...]
    """[K] parameters of each kind, metres."""


@dataclass(frozen=True, eq=False)
class Elements:
    """N elements and their points; x to the right, y up, z out of the wall, in metres."""

    offsets: Ints
    """[N + 1] offsets of the points of each element."""
    points: Floats
    """[P, 2] or [P, 3] points."""
    low: Floats
    """[N, 2] lower left corner of each box on the facade."""
    high: Floats
    """[N, 2] upper right corner of each box."""
    row: Ints
    """[N] row of the facade, from 0 at the top; -1 for none."""
    column: Ints
    """[N] column, from 0 at the left; -1 for none."""
    truth: Truth | None = None
    spacing: float = 0.0
    """Distance of the points of the scan between which the outlines lie, metres; 0 for points on the outlines."""
    notes: tuple[str, ...] = ()
    """Notes for the user on the reading of the file."""

    def __len__(self) -> int:
        return len(self.low)

    @property
    def counts(self) -> Ints:
        """[N] number of points of each element."""
        return np.diff(self.offsets)

    @property
    def common_error(self) -> float:
        """Standard deviation of an error that is the same for all sizes, metres: no element averages it out."""
        return _COMMON_ERROR_RATIO * self.spacing

    def points_of(self, element: int) -> Floats:
        """[P, 2 or 3] points of an element."""
        return self.points[self.offsets[element] : self.offsets[element + 1]]


@dataclass(frozen=True, eq=False)
class Clouds:
    """N elements, in metres from the centre of each box."""

    element: Ints
    """[N] index of each element among all."""
    points: Floats
    """[N, P, 2] points."""
    weight: Floats
    """[N, P] weights; 0 for padding."""
    middle: Floats
    """[N, 2] centres of the boxes, on the facade."""
    area: Floats
    """[N] areas of the boxes, square metres."""
    reach: Floats
    """[N, 2, 2] lowest and highest coordinates, without the outermost points."""

    def __len__(self) -> int:
        return len(self.element)


def check(elements: Elements) -> Elements:
    """The elements themselves, if they can be matched; defects of single ones are reported later.

    Raises:
        FacadeError: If there are none or too many, numbers are not finite, or boxes have no size.
    """
    if not len(elements):
        raise FacadeError("There are no elements: expected at least one box with points in it.")
    if len(elements) > MOST_ELEMENTS or len(elements.points) > MOST_POINTS:
        raise FacadeError(
            f"There are {len(elements):,} elements with {len(elements.points):,} points; expected at most "
            f"{MOST_ELEMENTS:,} with {MOST_POINTS:,}. Thin out the points, or crop the scan."
        )
    for name, values in (("point", elements.points), ("box", elements.low), ("box", elements.high)):
        wrong = ~(np.abs(values) <= FARTHEST).all(axis=1)
        if wrong.any():
            index = int(np.flatnonzero(wrong)[0])
            owner = int(row_of_value(elements.counts)[index]) if name == "point" else index
            raise FacadeError(
                f"Element {owner}: a {name} has a coordinate that is not a finite number within {FARTHEST:g} m."
            )
    flat = (elements.high <= elements.low).any(axis=1)
    if flat.any():
        index = int(np.flatnonzero(flat)[0])
        raise FacadeError(f"Element {index}: expected a box with a width and a height above 0.")
    if not elements.counts.any():
        raise FacadeError("All boxes are empty: no point lies in any of them. Give boxes and points in one frame.")
    return elements


def too_poor(elements: Elements) -> dict[int, str]:
    """Elements that cannot be matched, with the reasons."""
    reasons: dict[int, str] = {}
    for element in range(len(elements)):
        points = elements.points_of(element)[:, :2]
        if not len(points):
            reasons[element] = "its box is empty"
        elif len(points) < _MIN_POINTS:
            reasons[element] = f"it has {len(points)} points; at least {_MIN_POINTS} are needed"
        else:
            spread = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
            if spread[1] <= 1e-3 * max(spread[0], 1e-12):
                reasons[element] = "its points lie on one line" if spread[0] > 0.0 else "its points are all the same"
    return reasons


def clouds_of(elements: Elements, indices: Ints) -> Clouds:
    """The points of some elements."""
    counts = elements.counts[indices]
    most = int(min(_MAX_POINTS, max(int(counts.max(initial=1)), 1)))
    most = _POINT_STEP * -(-most // _POINT_STEP)
    middle = (elements.low + elements.high)[indices] / 2
    points = np.zeros((len(indices), most, 2))
    weight = np.zeros((len(indices), most))
    reach = np.zeros((len(indices), 2, 2))
    for index, element in enumerate(indices.tolist()):
        cloud = elements.points_of(element)[:, :2] - middle[index]
        reach[index] = np.quantile(cloud, (_TRIM_SHARE, 1.0 - _TRIM_SHARE), axis=0)
        if len(cloud) > most:
            # Evenly over the file, since scanners write points in the order of their sweep.
            cloud = cloud[np.linspace(0, len(cloud) - 1, most).astype(np.int64)]
        points[index, : len(cloud)], weight[index, : len(cloud)] = cloud, min(counts[index] / len(cloud), _MAX_WEIGHT)
    area = (elements.high - elements.low)[indices].prod(axis=1)
    return Clouds(indices, points, weight, middle, area, reach=reach)
