"""The up axis of a scan or mesh, where its points show it.

A wall is vertical for two axes if it faces the third one, and the ground is a wall for the wrong axis; so vertical
planes alone do not decide. Elements do: walls have windows that repeat, and the ground has none.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import islice

import numpy as np

from grammarlab.errors import FacadeError
from grammarlab.facade.templates.elements import Floats
from grammarlab.facade.templates.reading.boxes import FacadePlane, find_boxes
from grammarlab.facade.templates.reading.plane import facades
from grammarlab.facade.templates.reading.repetition import repeated
from grammarlab.facade.units import UP_AXES

_WALL = 0.05
"""Least number of points of a wall, as a share of those of the wall for another axis."""
_FLAT = 0.02
"""Largest distance of points of a wall from its plane, metres."""
_MOST_PLANES = 2
"""Largest number of planes whose elements are compared."""
_CLEARLY_MORE = 1.5
"""Least ratio of numbers of elements that is more than an accident of noise."""
_NEAR = 0.05
"""Least tolerance of equal elements, metres."""
_GROUND = 0.1
"""Part of the height, at the bottom, in which the ground lies."""
_LEAST_GROUND = 0.05
"""Least share of the points on the ground."""
_LEVEL = 0.05
"""Thickness of the ground, metres."""


@dataclass(frozen=True, slots=True)
class _Reading:
    """What the facades of a scan show if an axis is up."""

    num_repeated: int
    """Number of elements that repeat."""
    is_upright: bool
    """Whether most elements are higher than wide."""
    ground: float
    """Share of all points on one level at the bottom."""


def up_axes(points: Floats, num_edges: int, suffix: str) -> tuple[str, ...]:
    """The axes that may be up, the likely one first.

    Args:
        points: [P, 3] points of the file, metres.
        num_edges: number of points at the end that are on edges of a mesh.
        suffix: suffix of the file. LAS and LAZ define that z is up, and glTF that y is; others define nothing.
    """
    if suffix in (".glb", ".gltf"):
        return "y", "z"
    if suffix in (".las", ".laz"):
        return "z", "y"
    planes = {axis: _planes(points[:, columns]) for axis, columns in UP_AXES.items()}
    y, z = (_num_on_wall(planes[axis]) for axis in "yz")
    if min(y, z) <= _WALL * max(y, z):
        return ("y", "z") if y > z else ("z", "y")
    other, usual = (_reading(planes[axis], points[:, UP_AXES[axis][2]], num_edges) for axis in "yz")
    return ("y", "z") if _is_likelier(other, usual) else ("z", "y")


def plane_of(points: Floats, num_edges: int) -> FacadePlane:
    """A facade with its points and the points on edges apart."""
    return FacadePlane(points[: len(points) - num_edges], points[len(points) - num_edges :])


def _planes(points: Floats) -> list[Floats]:
    """The first facades if the third coordinate is up; none without a vertical plane."""
    try:
        return list(islice(facades(points), _MOST_PLANES))
    except FacadeError:
        return []


def _num_on_wall(planes: list[Floats]) -> int:
    return int((np.abs(planes[0][:, 2]) < _FLAT).sum()) if planes else 0


def _is_likelier(other: _Reading, usual: _Reading) -> bool:
    """Whether the other axis is up rather than the usual one."""
    if (
        other.num_repeated > _CLEARLY_MORE * usual.num_repeated
        or usual.num_repeated > _CLEARLY_MORE * other.num_repeated
    ):
        return other.num_repeated > usual.num_repeated
    # The wall is vertical for both axes: the ground, and windows that stand.
    return other.ground > usual.ground + _LEAST_GROUND and other.is_upright and not usual.is_upright


def _reading(planes: list[Floats], height: Floats, num_edges: int) -> _Reading:
    """What facades show, and the heights [P] of all points."""
    num_repeated, sizes = 0, [np.zeros((0, 2))]
    for plane in planes:
        found = find_boxes(plane_of(plane, num_edges))
        num_repeated += int(repeated(found.box, max(_NEAR, found.spacing)).sum())
        sizes.append(found.box[:, 2:] - found.box[:, :2])
    across, up = np.vstack(sizes).T
    return _Reading(num_repeated, 2 * int((up > across).sum()) > len(up), _ground(height))


def _ground(height: Floats) -> float:
    """Share of the points on one level at the bottom."""
    low, high = np.quantile(height, [0.001, 0.999])
    near = height[(height > low - _LEVEL) & (height < low + _GROUND * (high - low))]
    counts = np.unique(np.floor((near - low) / _LEVEL), return_counts=True)[1]
    return float(counts.max(initial=0)) / len(height)
