"""Bands of a facade: its columns and the piers between them, or its rows and the spandrels between them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from grammarlab.facade.looks import is_door, look_of
from grammarlab.facade.tree import Facade

Floats = NDArray[np.float64]

SAME_PLACE = 1e-6
"""Largest difference of equal edges, as a fraction of the facade's size."""


class Band(NamedTuple):
    """A piece of the facade's width or height."""

    start: float
    """Start from the left or from the bottom, metres."""
    end: float
    stands: bool
    """Whether it contains something other than wall; otherwise it is flexible."""

    @property
    def size(self) -> float:
        """Size, metres."""
        return self.end - self.start


def bands(facade: Facade, axis: int) -> list[Band]:
    """The whole width (axis 0) or height (axis 1) as bands that cut no window and no door.

    Windows and doors whose extents overlap share a band. Other elements except walls widen the band of the adjacent
    window, or have a band of their own; elements that extend over several bands, such as cornices, are cut.
    """
    labels = [look_of(name) for name in facade.labels]
    leaves = np.array([leaf for leaf in facade.leaves if not _gives(facade, leaf)], dtype=np.int64)
    core = np.array([labels[label].glazed or is_door(facade.labels[label]) for label in facade.label[leaves]], bool)
    if not core.any():
        core[:] = True
    start = facade.position[leaves, axis] - facade.position[0, axis]
    extents = np.stack([start, start + facade.size[leaves, axis]], axis=1)
    least = SAME_PLACE * facade.size[0, axis]
    standing = _joined(extents[core], least)
    beside = [extent for extent in extents[~core] if _overlaps(standing, extent, least) < 2]
    if len(standing):
        standing = _joined(np.concatenate([standing, *(extent[None] for extent in beside)]), least)
    return _filled(standing, float(facade.size[0, axis]), least)


def _gives(facade: Facade, leaf: int) -> bool:
    return look_of(facade.name_of(leaf)).gives


def _joined(extents: Floats, least: float) -> Floats:
    """[K, 2] disjoint extents with the same union as extents [N, 2]; those that only touch stay separate."""
    found: list[list[float]] = []
    for start, end in sorted(extents.tolist()):
        if found and start < found[-1][1] - least:
            found[-1][1] = max(found[-1][1], end)
        else:
            found.append([start, end])
    return np.array(found).reshape(-1, 2)


def _overlaps(standing: Floats, extent: Floats, least: float) -> int:
    return int(((standing[:, 0] < extent[1] - least) & (standing[:, 1] > extent[0] + least)).sum())


def _filled(standing: Floats, whole: float, least: float) -> list[Band]:
    """Bands of elements, and the bands between them."""
    found, at = [], 0.0
    for start, end in standing.tolist():
        if start - at > least:
            found.append(Band(at, start, stands=False))
            at = start
        found.append(Band(at, end, stands=True))
        at = end
    if whole - at > least:
        found.append(Band(at, whole, stands=False))
    return found
