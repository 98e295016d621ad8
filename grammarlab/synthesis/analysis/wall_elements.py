"""Elements of a wall: parts outside of its plane, such as windows, doors and balconies, each with its box."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy import ndimage

from grammarlab.arrays import Flags, Floats
from grammarlab.synthesis.analysis.walls import BEHIND, Wall

_MIN_OFFSET_M, _NOISE_FACTOR = 0.02, 4.0
"""Least distance from the plane of a wall, in metres, and as a multiple of the noise."""
NEAR = 0.06
"""Largest distance between parts of one element, metres."""
MIN_SIDE_M, MIN_AREA_M2 = 0.15, 0.05
"""Least side, metres, and least area, square metres, of an element."""
_MIN_HOLE_SHARE = 0.65
"""Least part of its box that a hole through a wall fills; other holes are missing triangles."""
_MAX_RETURN_M = 0.3
"""Largest width of a return at the end of a wall that belongs to other walls, such as their plinth, metres."""
LONGEST = 0.6
"""Largest part of a wall's side that an element takes; longer parts are bands, cornices or pilasters."""
_MAX_ENTRANCE_M, _MAX_SILL_M = 3.0, 0.85
"""Largest height of a door or a shop, and of its lower side above the ground, metres: in a wall of one storey, it takes
more of the height than other elements."""
_MAX_DISTANCE_PIXELS, _MAX_SPREAD_M = 1.0, 0.002
"""Distance of an element's side from the points that determine it, pixels, and spread of these points, metres."""


@dataclass(frozen=True, slots=True)
class WallElements:
    """E elements."""

    low: Floats
    """[E, 2] lower left corners, metres, in the coordinates of the wall's view."""
    high: Floats
    """[E, 2] upper right corners, metres."""
    whole: Floats
    """[E, 2, 2] low and high corners of the elements with the sills, frames and shutters that touch them, metres."""

    @classmethod
    def of(cls, boxes: Floats) -> WallElements:
        """Elements of boxes [E, 2, 2] that nothing touches."""
        return cls(boxes[:, 0], boxes[:, 1], boxes)

    def take(self, chosen: Flags) -> WallElements:
        """Some of the elements."""
        return WallElements(self.low[chosen], self.high[chosen], self.whole[chosen])

    def __add__(self, others: WallElements) -> WallElements:
        return WallElements(
            np.concatenate([self.low, others.low]),
            np.concatenate([self.high, others.high]),
            np.concatenate([self.whole, others.whole]),
        )

    def contains_any(self, others: WallElements) -> Flags:
        """[E] whether an element contains the centre of one of the others."""
        return np.any(self.contains(others), axis=1)

    def contains(self, others: WallElements) -> Flags:
        """[E, O] whether each element contains the centre of each of the others."""
        middle = (others.low + others.high) / 2.0
        return np.all((self.low[:, None] < middle) & (middle < self.high[:, None]), axis=2)

    def with_panes(self, panes: WallElements) -> WallElements:
        """These elements and panes; a pane replaces the element around it, and the elements inside it."""
        return self.take(~self.contains_any(panes) & ~np.any(panes.contains(self), axis=0)) + panes

    def with_openings(self, openings: WallElements) -> WallElements:
        """The openings, and these elements as far as they touch none: sills, frames and shutters belong to theirs."""
        away = (self.low[:, None] > openings.high + 2.0 * NEAR) | (self.high[:, None] < openings.low - 2.0 * NEAR)
        touches = ~np.any(away, axis=2)
        whole = openings.whole.copy()
        # What touches several openings, such as a balcony before two of them, is part of none.
        for element in np.flatnonzero(np.sum(touches, axis=1) == 1).tolist():
            opening = int(touches[element].argmax())
            whole[opening, 0] = np.minimum(whole[opening, 0], self.low[element])
            whole[opening, 1] = np.maximum(whole[opening, 1], self.high[element])
        return self.take(~np.any(touches, axis=1)) + WallElements(openings.low, openings.high, whole)


def slack_of(wall: Wall) -> float:
    """Largest distance from a plane of points that still belong to it, metres."""
    return _MIN_OFFSET_M + _NOISE_FACTOR * wall.noise


def off_plane(wall: Wall) -> Flags:
    """[H, W] pixels of the wall in front of or behind its plane, or empty."""
    return wall.mask & ~(np.abs(wall.map.depth - wall.depth) <= slack_of(wall))


def band_of(wall: Wall) -> float:
    """Depth of a recessed ground floor or other full-width band, metres towards the viewer; else the wall's."""
    depth = wall.map.depth
    behind = wall.mask & (depth < wall.depth - slack_of(wall)) & (depth >= wall.depth - BEHIND)
    labelled: Any = ndimage.label(behind)
    label, num = labelled
    width = (wall.high - wall.low)[0] / wall.map.step
    extents = ndimage.find_objects(label, num)
    long = [k for k, extent in enumerate(extents, 1) if extent[1].stop - extent[1].start > LONGEST * width]
    return float(np.median(depth[np.isin(label, long)])) if long else wall.depth


def bare_of(wall: Wall) -> Floats:
    """[2, 2] low and high corner of the wall without projecting bands along its sides, such as a plinth."""
    map_ = wall.map
    before = wall.mask & (map_.depth > wall.depth + slack_of(wall))
    slices = map_.columns(wall.low[0], wall.high[0]), map_.rows(wall.low[1], wall.high[1])
    part = before[slices[1], slices[0]]
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

    Their sides are means of the nearby visible points, so that they are exact if the mesh is, and noise of points
    averages out; sides without nearby points are as exact as the map.

    Args:
        wall: the wall.
        corners: [T, 3, 3] of all triangles of the building, in the coordinates of the view.
    """
    mask = off_plane(wall)
    boxes, long = _boxes(mask, wall, corners)
    # A plinth or a cornice in front of the wall would join the elements along it, so recesses are searched separately;
    # so are elements of a recessed ground floor, relative to its own plane.
    behind = long & ~(wall.map.depth > wall.depth)
    beneath, _ = _boxes(behind & ~(np.abs(wall.map.depth - band_of(wall)) <= slack_of(wall)), wall, corners)
    boxes = np.array([*boxes, *beneath]).reshape(-1, 2, 2)
    return WallElements.of(boxes)


def _boxes(mask: Flags, wall: Wall, corners: Floats) -> tuple[list[Floats], Flags]:
    """[2, 2] low and high corner of each connected part that is large enough, and the pixels of parts too long."""
    map_ = wall.map
    reach = max(1, round(NEAR / map_.step / 2.0))
    grown = ndimage.binary_dilation(mask, iterations=reach, structure=np.ones((3, 3)))
    labelled: Any = ndimage.label(grown, structure=np.ones((3, 3)))
    label, num = labelled
    label[~mask] = 0
    boxes, long = [], np.zeros_like(mask)
    for number, extent in enumerate(ndimage.find_objects(label, num), start=1):
        if extent is None:
            continue
        component = label[extent] == number
        low = map_.low + np.array([extent[1].start, extent[0].start]) * map_.step
        high = map_.low + np.array([extent[1].stop, extent[0].stop]) * map_.step
        if _is_long(low, high, map_.depth[extent][component], wall, float(corners[..., 1].min())):
            long[extent] |= component
            continue
        if (high - low).min() < MIN_SIDE_M or component.sum() * map_.step**2 < MIN_AREA_M2:
            continue
        through = wall.map.depth[extent][component] < wall.depth - BEHIND
        if through.mean() > 0.5 and component.sum() < _MIN_HOLE_SHARE * component.size:
            continue
        at_corner = low[0] <= wall.low[0] + map_.step or high[0] >= wall.high[0] - map_.step
        if at_corner and (high - low)[0] < _MAX_RETURN_M:
            continue
        if through.mean() > 0.5:  # the sides of a hole are those of its surroundings
            grown = tuple(slice(max(span.start - 1, 0), span.stop + 1) for span in extent)
            triangles = np.unique(map_.triangle[grown][map_.depth[grown] >= wall.depth - BEHIND])
        else:
            triangles = np.unique(map_.triangle[extent][component])
        near = coordinates_of(corners[triangles[triangles >= 0], :, :2].reshape(-1, 2))
        boxes.append(np.stack([exact(side, near, map_.step, wall.noise) for side in (low, high)]))
    return boxes, long


def _is_long(low: Floats, high: Floats, depth: Floats, wall: Wall, ground: float) -> bool:
    """Whether a part of a wall is a band, cornice or pilaster rather than an element.

    Args:
        low: [2] its low corner, metres.
        high: [2] its high corner, metres.
        depth: depth of its pixels, metres.
        wall: the wall.
        ground: lowest height of the building, metres.
    """
    width, height = (high - low > LONGEST * (wall.high - wall.low)).tolist()
    entrance = (
        high[1] - low[1] <= _MAX_ENTRANCE_M and low[1] - ground <= _MAX_SILL_M and bool(np.median(depth) < wall.depth)
    )
    return width or (height and not entrance)


def is_too_long(low: Floats, high: Floats, wall: Wall) -> bool:
    """Whether an opening from one corner [2] to another is rather a gap of the wall: across most of its width."""
    return bool((high - low)[0] > LONGEST * (wall.high - wall.low)[0])


def coordinates_of(points: Floats) -> tuple[Floats, Floats]:
    """The different x and y of points [P, 2], ascending."""
    return np.unique(points[:, 0]), np.unique(points[:, 1])


def exact(side: Floats, coordinates: tuple[Floats, Floats], step: float, noise: float) -> Floats:
    """[2] the mean of the coordinates near each side, or the side itself if there are none.

    Args:
        side: [2] about where it is, metres.
        coordinates: ascending coordinates of points along both axes, metres.
        step: metres per pixel.
        noise: deviation of points, metres.
    """
    exact = side.copy()
    spread = max(_MAX_SPREAD_M, _NOISE_FACTOR * noise)
    for axis, ascending in enumerate(coordinates):
        above = int(np.searchsorted(ascending, side[axis]))
        near = ascending[max(above - 1, 0) : above + 1]
        if not len(near):
            continue
        nearest = near[np.abs(near - side[axis]).argmin()]
        if abs(nearest - side[axis]) <= _MAX_DISTANCE_PIXELS * step + noise:
            first, last = (
                np.searchsorted(ascending, nearest - spread),
                np.searchsorted(ascending, nearest + spread, "right"),
            )
            exact[axis] = float(ascending[first:last].mean())
    return exact
