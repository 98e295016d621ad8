"""Points of elements as one array: a bounded number of each, from the middle of its box."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from grammarlab.facade.templates.elements import Elements, Floats, Ints

MOST = 64
"""Points of an element that are looked at; of more an even part is taken, which then count for more each."""
_STEP = 16
_HEAVIEST = 2.0
"""How much a point counts at most: errors of points near each other are not independent."""
_TRIM = 0.04
"""Part of the points on each side that does not count for how far an element reaches."""


@dataclass(frozen=True, eq=False)
class Clouds:
    """N elements, in metres from the middle of each box."""

    element: Ints
    """[N] number of each among all elements."""
    points: Floats
    """[N, P, 2]"""
    weight: Floats
    """[N, P] 0 for padding."""
    middle: Floats
    """[N, 2] of the boxes, on the facade."""
    area: Floats
    """[N] of the boxes, square metres."""
    reach: Floats
    """[N, 2, 2] lowest and highest coordinates without the outermost points."""

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
            # Evenly through the file, which scanners write in the order of their sweep.
            own = own[np.linspace(0, len(own) - 1, most).astype(np.int64)]
        points[place, : len(own)], weight[place, : len(own)] = own, min(counts[place] / len(own), _HEAVIEST)
    area = (elements.high - elements.low)[which].prod(axis=1)
    return Clouds(which, points, weight, middle, area, reach=reach)
