"""Names of units by appearance: window, door, shop, wall, unit.

A door is distinguished from a tall window by its foot. It is at the ground, behind a threshold no higher than a step;
or a few steps above it, and then below the feet of the windows beside it, which keep their own line. Openings that make
up most of a storey are no doors: they are French windows, or the fronts of shops.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from grammarlab.arrays import Flags, Floats, Ints

_STEP_M = 0.21
"""Largest height of a step or a threshold, metres: the riser that building codes allow."""
_MAX_FOOT_M = 0.85
"""Largest height of a door's foot above the ground, metres: five steps; sills are higher."""
_MIN_DOOR_HEIGHT_M, _MAX_DOOR_WIDTH_M = 1.8, 2.2
"""Least height of a door, and largest width of one above steps, metres; at the ground it may be a gate. No door is
wider than high."""
_MIN_USUAL = 3
"""Least number of openings of a kind that makes up most of a storey."""


@dataclass(frozen=True, slots=True)
class NamedOpenings:
    """The elements of a wall, E of them."""

    boxes: Floats
    """[E, 4] low and high corners, metres."""
    kind: Ints
    """[E] label of the unit that each is part of."""
    ground: float
    """Lowest height of the wall, metres."""

    @property
    def foot(self) -> Floats:
        """[E] heights of lower sides above the ground, metres."""
        return self.boxes[:, 1] - self.ground


def names_of(openings: NamedOpenings, counts: Sequence[int]) -> list[str]:
    """A unique name for each label.

    Args:
        openings: the elements of the wall.
        counts: number of elements of a unit of each label.
    """
    names = [
        ("wall", _opening(openings, openings.kind == label), "unit")[min(count, 2)]
        for label, count in enumerate(counts)
    ]
    return [
        name if (before := names[:index].count(name)) == 0 else f"{name}-{before + 1}"
        for index, name in enumerate(names)
    ]


def may_be_doors(boxes: Floats, ground: float) -> Flags:
    """[E] whether elements are as high as a door and near the ground.

    Args:
        boxes: [E, 4] low and high corners, metres.
        ground: lowest height of the wall, metres.
    """
    return (boxes[:, 3] - boxes[:, 1] >= _MIN_DOOR_HEIGHT_M) & (boxes[:, 1] - ground <= _MAX_FOOT_M)


def _opening(openings: NamedOpenings, members: Flags) -> str:
    """The name of units of one element: members [E] are the elements of all these units."""
    if not members.any():
        return "window"
    width, height = (openings.boxes[members, 2:] - openings.boxes[members, :2]).mean(axis=0).tolist()
    foot = openings.foot[members]
    if height < _MIN_DOOR_HEIGHT_M or foot.max() > _MAX_FOOT_M:
        return "window"
    is_at_ground = foot.max() <= _STEP_M
    if width > (height if is_at_ground else min(_MAX_DOOR_WIDTH_M, height)):
        return "shop"
    beside = _beside(openings, members) & ~members
    if members.sum() >= max(_MIN_USUAL, beside.sum() + 1):
        return "shop" if is_at_ground else "window"
    is_lower = is_at_ground or not beside.any() or foot.max() <= float(np.median(openings.foot[beside])) - _STEP_M
    return "door" if is_lower else "window"


def _beside(openings: NamedOpenings, members: Flags) -> Flags:
    """[E] elements at heights of some members."""
    low, high = openings.boxes[members, 1].min(), openings.boxes[members, 3].max()
    middle = (openings.boxes[:, 1] + openings.boxes[:, 3]) / 2.0
    return (middle > low) & (middle < high)
