"""Parcels on which nothing can be built because of their shapes."""

from __future__ import annotations

import numpy as np
import shapely
from numpy.typing import NDArray

from grammarlab.arrays import Flags, Floats
from grammarlab.city import parcel_reasons
from grammarlab.city.packed_outlines import Outlines

_MIN_AREA, _MIN_SIDE = 30.0, 2.0
"""Square metres and metres of the smallest parcel."""
_STREET_AREA, _STREET_COMPACTNESS = 500.0, 0.1
"""Square metres and 4πA/P² of parcels that are streets."""


def unbuildable(outline: Outlines) -> NDArray[np.object_]:
    """[N] why nothing can be built inside valid outlines because of their shapes; empty for the others."""
    reason = np.full(len(outline), "", dtype=object)
    area = shapely.area(outline)
    with np.errstate(divide="ignore", invalid="ignore"):
        compactness = 4 * np.pi * area / shapely.length(outline) ** 2
    reason[_is_narrow(outline, area)] = parcel_reasons.NARROW
    reason[area < _MIN_AREA] = parcel_reasons.SMALL
    reason[(compactness < _STREET_COMPACTNESS) & (area > _STREET_AREA)] = parcel_reasons.STREET
    return reason


def _is_narrow(outline: Outlines, area: Floats) -> Flags:
    """[N] whether the smallest box around an outline has a side below `_MIN_SIDE`."""
    bounds = shapely.bounds(outline)
    diagonal = np.hypot(bounds[:, 2] - bounds[:, 0], bounds[:, 3] - bounds[:, 1])
    # The box is no longer than the diagonal, so a larger area has a wider box.
    rows = np.flatnonzero((area > 0) & (area < _MIN_SIDE * diagonal))
    narrow = np.zeros(len(outline), dtype=np.bool_)
    corners = [shapely.get_coordinates(box)[:3] for box in shapely.oriented_envelope(outline[rows])]
    for row, corner in zip(rows, corners, strict=True):
        sides = np.hypot(*np.diff(corner, axis=0).T) if len(corner) == 3 else np.zeros(1)
        narrow[row] = sides.min() < _MIN_SIDE
    return narrow
