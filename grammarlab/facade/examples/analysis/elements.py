"""Elements of a wall: whatever is not in its plane, such as windows, doors and balconies, each with its box."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy import ndimage

from grammarlab.facade.examples.analysis.walls import BEHIND, Wall
from grammarlab.facade.examples.mesh.surface import Bools, Floats

_OFF, _NOISES = 0.02, 4.0
"""Metres, and multiples of the noise, from which something is not in the plane of a wall."""
NEAR = 0.06
"""Metres between parts of one element."""
_LEAST_SIDE, _LEAST_AREA = 0.15, 0.05
"""Metres and square metres of an element."""
_TORN = 0.65
"""Part of its box that a hole through a wall fills at least; others are triangles that are missing."""
_CORNER = 0.3
"""Metres up to which something at the end of a wall is what other walls show of themselves, such as their plinth."""
LONGEST = 0.6
"""Part of a wall's side; what is longer is a band, a cornice or a pilaster, which all units share."""
_BESIDE, _ONE_PLACE = 1.0, 0.002
"""Pixels between the side of an element on the map and the points that make it, and metres within which these lie."""


@dataclass(frozen=True, slots=True)
class WallElements:
    """E elements."""

    low: Floats
    """[E, 2] metres, lower left corners, in the coordinates of the wall's view."""
    high: Floats
    """[E, 2] metres, upper right corners."""

    def around(self, others: WallElements) -> Bools:
        """[E] which of these have the middle of one of others inside."""
        return np.any(self.of(others), axis=1)

    def of(self, others: WallElements) -> Bools:
        """[E, O] whether the middle of each of the others lies in each of these."""
        middle = (others.low + others.high) / 2.0
        return np.all((self.low[:, None] < middle) & (middle < self.high[:, None]), axis=2)

    def with_panes(self, panes: WallElements) -> WallElements:
        """These and panes; a pane takes the place of what it lies in, and of what lies in it."""
        left = ~self.around(panes) & ~np.any(panes.of(self), axis=0)
        return WallElements(np.concatenate([self.low[left], panes.low]), np.concatenate([self.high[left], panes.high]))


def slack_of(wall: Wall) -> float:
    """Metres by which something differs from a plane at most and is still seen as part of it."""
    return _OFF + _NOISES * wall.noise


def off_plane(wall: Wall) -> Bools:
    """[H, W] pixels of the wall that show something before or behind its plane, or nothing."""
    return wall.seen & ~(np.abs(wall.map.depth - wall.depth) <= slack_of(wall))


def band_of(wall: Wall) -> float:
    """Metres towards the viewer of a ground floor, or another band from end to end, that stands back; else the wall."""
    depth = wall.map.depth
    behind = wall.seen & (depth < wall.depth - slack_of(wall)) & (depth >= wall.depth - BEHIND)
    found: Any = ndimage.label(behind)
    label, num = found
    width = (wall.high - wall.low)[0] / wall.map.step
    places = ndimage.find_objects(label, num)
    long = [k for k, place in enumerate(places, 1) if place[1].stop - place[1].start > LONGEST * width]
    return float(np.median(depth[np.isin(label, long)])) if long else wall.depth


def bare_of(wall: Wall) -> Floats:
    """[2, 2] low and high corner of the wall without bands along its sides, such as a plinth, that lie before it."""
    map_ = wall.map
    before = wall.seen & (map_.depth > wall.depth + slack_of(wall))
    place = map_.columns(wall.low[0], wall.high[0]), map_.rows(wall.low[1], wall.high[1])
    part = before[place[1], place[0]]
    corners = np.stack([wall.low, wall.high])
    for axis in (0, 1):
        free = np.flatnonzero(part.mean(axis=axis) < LONGEST)
        if len(free):
            count = part.shape[1 - axis]
            corners[0, axis] += free[0] * map_.step
            corners[1, axis] -= (count - 1 - free[-1]) * map_.step
    return corners


def elements_of(wall: Wall, corners: Floats) -> WallElements:
    """The elements of a wall.

    Their sides are those of the points that are seen near them, averaged, so that they are exact where the mesh is and
    noise of points cancels out; where no points are near, they are as exact as the map.

    Args:
        wall: the wall.
        corners: [T, 3, 3] of all triangles of the building, in the coordinates of the view.
    """
    mask = off_plane(wall)
    boxes, long = _boxes(mask, wall, corners)
    # A plinth or a cornice before the wall takes what adjoins it along: what lies behind the wall is looked at alone,
    # and in a ground floor that stands back what is not in its own plane.
    behind = long & ~(wall.map.depth > wall.depth)
    beneath, _ = _boxes(behind & ~(np.abs(wall.map.depth - band_of(wall)) <= slack_of(wall)), wall, corners)
    boxes = np.array([*boxes, *beneath]).reshape(-1, 2, 2)
    return WallElements(boxes[:, 0], boxes[:, 1])


def _boxes(mask: Bools, wall: Wall, corners: Floats) -> tuple[list[Floats], Bools]:
    """[2, 2] low and high corner of each connected part that is large enough, and the pixels of parts too long."""
    map_ = wall.map
    reach = max(1, round(NEAR / map_.step / 2.0))
    grown = ndimage.binary_dilation(mask, iterations=reach, structure=np.ones((3, 3)))
    found: Any = ndimage.label(grown, structure=np.ones((3, 3)))
    label, num = found
    label[~mask] = 0
    boxes, long = [], np.zeros_like(mask)
    for number, place in enumerate(ndimage.find_objects(label, num), start=1):
        if place is None:
            continue
        own = label[place] == number
        low = map_.low + np.array([place[1].start, place[0].start]) * map_.step
        high = map_.low + np.array([place[1].stop, place[0].stop]) * map_.step
        if (high - low > LONGEST * (wall.high - wall.low)).any():
            long[place] |= own
            continue
        if (high - low).min() < _LEAST_SIDE or own.sum() * map_.step**2 < _LEAST_AREA:
            continue
        through = wall.map.depth[place][own] < wall.depth - BEHIND
        if through.mean() > 0.5 and own.sum() < _TORN * own.size:
            continue
        at_corner = low[0] <= wall.low[0] + map_.step or high[0] >= wall.high[0] - map_.step
        if at_corner and (high - low)[0] < _CORNER:
            continue
        if through.mean() > 0.5:  # what is around a hole makes its sides, not what is seen through it
            grown = tuple(slice(max(each.start - 1, 0), each.stop + 1) for each in place)
            seen = np.unique(map_.triangle[grown][map_.depth[grown] >= wall.depth - BEHIND])
        else:
            seen = np.unique(map_.triangle[place][own])
        points = corners[seen[seen >= 0], :, :2].reshape(-1, 2)
        boxes.append(np.stack([_exact(side, points, map_.step, wall.noise) for side in (low, high)]))
    return boxes, long


def _exact(side: Floats, points: Floats, step: float, noise: float) -> Floats:
    """[2] the mean of the coordinates that make each side, or itself where there are none near."""
    exact = side.copy()
    for axis in range(2):
        place = np.unique(points[:, axis])
        nearest = place[np.abs(place - side[axis]).argmin()] if len(place) else np.inf
        if abs(nearest - side[axis]) <= _BESIDE * step + noise:
            exact[axis] = float(place[np.abs(place - nearest) <= max(_ONE_PLACE, _NOISES * noise)].mean())
    return exact
