"""A facade whose nodes are copies of nodes of another one."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import take_rows
from grammarlab.facade.tree import Facade, laid_out

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

NEW = -1
"""Source of an inner node without a counterpart in the other facade."""


def take(
    facade: Facade,
    parent: Ints,
    axis: NDArray[np.int8],
    source: Ints,
    wanted: Floats | None = None,
    shown: Floats | None = None,
) -> Facade:
    """A tree with the look of its sources: their labels, outlines and parts of pictures; it has no grids.

    Args:
        facade: the facade of the sources.
        parent: [N] as in `Facade`.
        axis: [N] as in `Facade`.
        source: [N] node of the other facade, or `NEW`.
        wanted: [N, 2] target sizes of leaves, metres; those of the sources by default.
        shown: [N, 4] left, bottom, right, top of the visible part of its source; all of it by default.
    """
    given = np.where(source >= 0, source, 0)
    new = source < 0
    wanted = facade.size[given] if wanted is None else wanted
    position, size = laid_out(parent, axis, wanted)
    window = facade.window[given]
    if shown is not None:
        low, extent = window[:, :2], window[:, 2:] - window[:, :2]
        window = np.hstack([low + shown[:, :2] * extent, low + shown[:, 2:] * extent])
    # New nodes have an outline without points.
    counts = np.append(np.diff(facade.outline_offsets), 0)
    offsets = np.append(facade.outline_offsets, facade.outline_offsets[-1])
    points, outline_offsets = take_rows(offsets, np.where(new, len(counts) - 1, given))
    return Facade(
        parent=parent,
        axis=axis,
        position=position,
        size=size,
        label=np.where(new, -1, facade.label[given]),
        labels=facade.labels,
        outline_offsets=outline_offsets,
        outline_points=facade.outline_points[points],
        pictures=facade.pictures,
        picture=np.where(new, -1, facade.picture[given]),
        window=np.where(new[:, None], [0.0, 0.0, 1.0, 1.0], window),
    )
