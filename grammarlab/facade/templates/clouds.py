"""Points of elements as one array: a bounded number per element, relative to the centre of its box."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from grammarlab.facade.templates.elements import Elements, Floats, Ints

MOST = 64
"""Largest number of points per element; a larger cloud is sampled evenly, and each point gets more weight."""
_STEP = 16
_HEAVIEST = 2.0
"""Largest weight of a point: errors of nearby points are not independent."""
_TRIM = 0.04
"""Fraction of the points on each side that is ignored for the extent of an element."""


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


def clouds_of(elements: Elements, which: Ints) -> Clouds:
    """The points of some elements."""
    counts = elements.counts[which]
    most = int(min(MOST, max(int(counts.max(initial=1)), 1)))
    most = _STEP * -(-most // _STEP)
    middle = (elements.low + elements.high)[which] / 2
    points = np.zeros((len(which), most, 2))
    weight = np.zeros((len(which), most))
    reach = np.zeros((len(which), 2, 2))
    for place, element in enumerate(which.tolist()):
        own = elements.of(element)[:, :2] - middle[place]
        reach[place] = np.quantile(own, (_TRIM, 1.0 - _TRIM), axis=0)
        if len(own) > most:
            # Evenly over the file, since scanners write points in the order of their sweep.
            own = own[np.linspace(0, len(own) - 1, most).astype(np.int64)]
        points[place, : len(own)], weight[place, : len(own)] = own, min(counts[place] / len(own), _HEAVIEST)
    area = (elements.high - elements.low)[which].prod(axis=1)
    return Clouds(which, points, weight, middle, area, reach=reach)
