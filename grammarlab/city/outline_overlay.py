"""Overlays of outlines that always have a result: where exact arithmetic fails, corners are rounded."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import shapely

from grammarlab.city.packed_outlines import Outlines

_GRID = 1e-3
"""Metres to which the corners of an outline are rounded where an overlay fails."""


def overlaid(operation: Callable[..., Any], one: Outlines, other: Outlines) -> Outlines:
    """[N] results of an operation on pairs of geometries.

    Args:
        operation: ``shapely.difference`` or ``shapely.intersection``.
        one: [N] geometries.
        other: [N] geometries.
    """
    try:
        return operation(one, other)
    except shapely.GEOSException:
        return _each(operation, one, other)


def merged(groups: Outlines) -> Outlines:
    """[N] unions of the members of geometry collections."""
    try:
        return np.asarray(shapely.union_all(groups[:, None], axis=1), dtype=object)
    except shapely.GEOSException:
        return _each(shapely.union_all, groups)


def _each(operation: Callable[..., Any], *columns: Outlines) -> Outlines:
    """Results row by row, so that each is what it would be alone."""
    result = np.full(len(columns[0]), None, dtype=object)
    for row, values in enumerate(zip(*columns, strict=True)):
        try:
            result[row] = operation(*values)
        except shapely.GEOSException:
            result[row] = operation(*map(shapely.make_valid, values), grid_size=_GRID)
    return result
