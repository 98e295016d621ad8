"""Streets by hierarchical splitting.

The method is that of Y.-L. Yang et al., "Urban pattern: layout design by hierarchical domain splitting", SIGGRAPH Asia
2013, section 4.

A region is divided by a street along the direction field, across its longer extent and near its middle, until it is as
small as a block. The address of a region is its path: 1 for the whole, 2p and 2p + 1 for the parts of region p. A
street begins where one on the other side of the region ends, if there is such a place near the middle, so that streets
cross rather than miss each other by a few metres. Regions are divided level by level, in the order of their paths.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import shapely

from grammarlab.arrays import Flags, Floats
from grammarlab.city.direction_field import Directions
from grammarlab.city.street_chords import (
    Chord,
    Ring,
    bent,
    contains,
    divided,
    following,
    nearest_edge,
    ring_area,
    traced_both_ways,
    traced_inwards,
)
from grammarlab.randomness import root_keys, uniforms

_MAX_LEVELS = 40
"""Budget: splits that follow each other."""
_WINDOW = 0.22
"""Prior: a street goes on from one on the other side if that leaves at least a quarter of the area on both sides."""
_ALTERNATIVES = (0.0, 0.1, -0.1, 0.17, -0.17)
"""Prior: shares of the area by which a split moves when the first place gives a bad one, best first."""
_MIN_SHARE = 0.22
"""Tolerance: smallest share of the area on one side of a split."""
_MIN_COMPACTNESS = 0.3
"""Tolerance: 4 pi area / perimeter^2 of a part; 0.35 is a rectangle of 1 to 7, 0.3 is one of 1 to 8."""
_MIN_CROSSING = 0.64
"""Tolerance: sine of the smallest angle between streets, 40 degrees."""
_SNAP = 28.0
"""Prior: metres, about the depth of a parcel; ends of streets nearer to a crossing or corner are moved onto it."""
_FILLED = 1e-5
"""Tolerance: difference of the areas of a region and of its parts, by the area; ends of streets are rounded."""
_MOST_STREET = 0.4
"""Tolerance: largest estimate of the share of a region that is streets; a rough outline is long."""
_CORNER = 0.5
"""Tolerance: turns of a ring that are larger than this angle in radians are corners."""
_ON_RING = 0.01
"""Tolerance: crossings nearer to a ring than this in metres are on it."""
_SAMPLES = 49
"""Places across a region at which the areas on both sides are measured."""
_LARGE_HALVINGS, _MIDDLE_HALVINGS = 6, 4
"""Prior: halvings from a region to blocks above which its street is one of the first and second class: districts of
more than 64 blocks, about 800 m across, and neighbourhoods of more than 16."""
_PLANNED_HALVINGS = 3
"""Budget: halvings into blocks for which all orders are compared."""
_MOST_DEEP = 1.4
"""Prior: depth of a block by the usual one above which its parcels would be too long."""
_MOST_ELONGATED = 5.0
"""Prior: ratio of the sides of a block above which it is too long to walk around."""
_PLACE_LANE, _STOP_LANE = 0, 1
"""Sites of draws below the key of a region."""


@dataclass(frozen=True, slots=True, eq=False)
class Street:
    """A street that divides a region."""

    points: Floats
    """[k, 2] centre line in metres."""
    width: float
    """Metres."""
    path: int
    """Address of the region."""


@dataclass(frozen=True, slots=True, eq=False)
class Region:
    """A region that streets surround."""

    ring: Ring
    path: int
    """Address: 1 for the whole, 2p and 2p + 1 for the parts of region p."""


@dataclass(frozen=True, slots=True, kw_only=True)
class SplitRules:
    """How regions are divided."""

    widths: tuple[float, ...]
    """Widths of streets in metres, the main ones first."""
    block_area: tuple[float, float]
    """Smallest and largest area of a block in square metres."""
    block_depth: float
    """Narrower side of a typical block in metres: that of two parcels back to back."""
    variation: float
    """Largest distance of a split from the middle, as a share of the area, 0 to 0.2."""
    seed: int
    root: int = 1
    """Address of the whole."""


@dataclass(frozen=True, slots=True)
class StreetNetwork:
    """The streets of a region and the regions between them."""

    streets: tuple[Street, ...]
    regions: tuple[Region, ...]
    """Regions that are not divided, ordered by path."""


def street_network(ring: Ring, directions: Directions, rules: SplitRules) -> StreetNetwork:
    """Divide a region into regions of blocks."""
    streets: list[Street] = []
    leaves: list[Region] = []
    crossings = _Crossings()
    level = [Region(ring, rules.root)]
    for _ in range(_MAX_LEVELS):
        parts: list[Region] = []
        for region in level:
            split = _split(region, directions, rules, crossings)
            if split is None:
                leaves.append(region)
                continue
            street, halves = split
            streets.append(street)
            crossings.add(street.points[[0, -1]])
            if directions.has_centre and (street.points == directions.centre).all(axis=1).any():
                crossings.add(directions.centre[None])
            parts += halves
        level = parts
    leaves += level
    order = sorted(leaves, key=lambda region: region.path)
    return StreetNetwork(tuple(streets), tuple(order))


class _Crossings:
    """Ends of streets so far, in a growing array."""

    def __init__(self) -> None:
        self._points = np.empty((256, 2))
        self._num = 0

    def add(self, points: Floats) -> None:
        if self._num + len(points) > len(self._points):
            self._points = np.concatenate([self._points, np.empty_like(self._points)])
        self._points[self._num : self._num + len(points)] = points
        self._num += len(points)

    def on(self, ring: Floats) -> Floats:
        """[m, 2] those on a ring [n, 2]."""
        points = self._points[: self._num]
        low, high = ring.min(axis=0) - _ON_RING, ring.max(axis=0) + _ON_RING
        points = points[((points >= low) & (points <= high)).all(axis=1)]
        if not len(points):
            return points
        return points[nearest_edge(ring, points)[1] <= _ON_RING]


def _split(
    region: Region, directions: Directions, rules: SplitRules, crossings: _Crossings
) -> tuple[Street, list[Region]] | None:
    """The street that divides a region and both parts, or None for a block."""
    key = root_keys(rules.seed, np.array([region.path]))
    if _is_block(region, directions, rules, float(uniforms(key, _STOP_LANE)[0])):
        return None
    place = 0.5 + rules.variation * (2.0 * float(uniforms(key, _PLACE_LANE)[0]) - 1.0)
    width = _width(region, rules)
    best: tuple[float, _Cut] | None = None
    for cut in _cuts(region.ring, directions, place, width, crossings, rules):
        badness = _badness(cut, rules)
        if badness == 0.0:
            best = (0.0, cut)
            break
        if best is None or badness < best[0]:
            best = (badness, cut)
    if best is None or best[0] >= 1.0:
        return None
    cut = best[1]
    parts = [Region(part, 2 * region.path + number) for number, part in enumerate(cut.parts)]
    return Street(cut.chord.points, width, region.path), parts


def _is_block(region: Region, directions: Directions, rules: SplitRules, draw: float) -> bool:
    """Whether a region is small enough for a block.

    Between twice the smallest and the largest area, a region that is much deeper than two parcels is divided; another
    one is a block with a chance that grows as it gets smaller, so that blocks have all areas between.
    """
    least, most = rules.block_area
    net = _net_area(region.ring)
    divisible = 2.0 * (1.0 + rules.variation) * least + rules.widths[-1] * least**0.5
    if net < divisible:
        return net <= most * 2.0**0.5 or net < 2.0 * least
    depth = min(_extents(region.ring.corners, directions)) - rules.widths[-1]
    return (
        net <= most
        and depth <= _MOST_DEEP * rules.block_depth
        and draw > np.log(net / divisible) / np.log(most / divisible)
    )


def _extents(corners: Floats, directions: Directions) -> tuple[float, float]:
    """Extents of a ring in metres along both directions at its middle."""
    angle = directions.at(*_inner_point(corners).tolist())
    first = corners @ np.array([np.cos(angle), np.sin(angle)])
    second = corners @ np.array([-np.sin(angle), np.cos(angle)])
    return float(np.ptp(first)), float(np.ptp(second))


def _net_area(ring: Ring) -> float:
    """Estimated area of a region without the streets on its edges."""
    along = following(ring.corners) - ring.corners
    streets = float((np.hypot(*along.T) * ring.width).sum()) / 2
    return ring.area - min(streets, _MOST_STREET * ring.area)


def _width(region: Region, rules: SplitRules) -> float:
    """Width of the street that divides a region."""
    block = (rules.block_area[0] * rules.block_area[1]) ** 0.5
    halvings = np.log2(max(region.ring.area / block, 1.0))
    by_area = 0 if halvings >= _LARGE_HALVINGS else 1 if halvings >= _MIDDLE_HALVINGS else 2
    return rules.widths[min(by_area, region.path.bit_length() - rules.root.bit_length(), len(rules.widths) - 1)]


@dataclass(frozen=True, slots=True, eq=False)
class _Cut:
    """A possible split."""

    ring: Ring
    chord: Chord
    parts: tuple[Ring, Ring]
    """Both parts, the one that is lower along the axis of the split first."""


def _cuts(
    ring: Ring, directions: Directions, place: float, width: float, crossings: _Crossings, rules: SplitRules
) -> Iterator[_Cut]:
    """Possible splits of a ring, good ones first."""
    corners = ring.corners
    joints = crossings.on(corners)
    inside = _inner_point(corners)
    angle = directions.at(*inside.tolist())
    axes = _axes(angle)
    if not _splits_first(ring, float(np.ptp(corners @ axes[0])), float(np.ptp(corners @ axes[1])), rules):
        axes.reverse()
    targets = np.concatenate([joints, corners[_is_corner(corners)]])
    ways = [(directions, axis) for axis in axes]
    if not directions.is_straight:  # where no line along the field divides the region, such as circles in a comb
        ways += [(directions.as_grid(), axis) for axis in _axes(directions.angle)]
    for field, axis in ways:
        profile = _Profile.of(corners, axis)
        across = float(np.arctan2(axis[0], -axis[1]))
        for chord in _chords(corners, field, profile, joints, place, across):
            cut = _cut_along(ring, _snapped(corners, chord, targets), width, axis)
            if cut is None or _badness(cut, rules) >= 1.0:
                cut = _cut_along(ring, chord, width, axis)
            if cut is not None:
                yield cut


def _cut_along(ring: Ring, chord: Chord, width: float, axis: Floats) -> _Cut | None:
    """The split of a ring along a chord; None if a part has no area."""
    parts = divided(ring, chord, width)
    if min(part.area for part in parts) <= 0 or min(len(part.corners) for part in parts) < 3:
        return None
    low, high = sorted(parts, key=lambda part: float(part.corners.mean(axis=0) @ axis))
    return _Cut(ring, chord, (low, high))


def _axes(angle: float) -> list[Floats]:
    """Both unit vectors of a cross at an angle in radians."""
    return [np.array([np.cos(turned), np.sin(turned)]) for turned in (angle, angle + np.pi / 2)]


def _splits_first(ring: Ring, first: float, second: float, rules: SplitRules) -> bool:
    """Whether a region is to be divided across its first extent rather than its second, both in metres.

    A large region is divided across the longer one. Of a small one, all ways to halve it into blocks are compared, and
    those blocks are best whose narrower side is nearest to the usual depth of blocks.
    """
    street = rules.widths[-1]
    block = (rules.block_area[0] * rules.block_area[1]) ** 0.5
    halvings = round(np.log2(max(_net_area(ring) / block, 1.0)))
    if halvings > _PLANNED_HALVINGS:
        return first >= second
    halvings = max(halvings, 1)
    across_first = np.arange(halvings + 1)
    sides = np.stack([first / 2.0**across_first, second / 2.0 ** (halvings - across_first)])
    depth = np.maximum(sides.min(axis=0) - street, 1.0)
    elongation = sides.max(axis=0) / sides.min(axis=0)
    misfit = np.abs(np.log(depth / rules.block_depth)) + np.maximum(0.0, elongation / _MOST_ELONGATED - 1.0)
    best = int(across_first[misfit.argmin()])
    return best > 0 and (best == halvings or first >= second)


@dataclass(frozen=True, slots=True, eq=False)
class _Profile:
    """Areas of a ring on one side of lines across an axis."""

    axis: Floats
    places: Floats
    """[s] places along the axis, ascending."""
    shares: Floats
    """[s] share of the area below each place, ascending from 0 to 1."""

    @classmethod
    def of(cls, corners: Floats, axis: Floats) -> _Profile:
        along = corners @ axis
        across = corners @ np.array([-axis[1], axis[0]])
        places = np.linspace(along.min(), along.max(), _SAMPLES)
        side = along - places[:, None]
        after = np.roll(side, -1, axis=1)
        step = following(across) - across
        low, high = np.minimum(side, after), np.maximum(side, after)
        span = np.maximum(high - low, 1e-12)
        # Mean over an edge of its distance below the place: a triangle where the edge crosses it.
        mean = np.where(high <= 0, (low + high) / 2, np.where(low >= 0, 0.0, -(low**2) / (2 * span)))
        shares = np.abs((mean * step).sum(axis=1)) / max(abs(ring_area(corners)), 1e-9)
        return cls(axis, places, np.maximum.accumulate(np.clip(shares, 0.0, 1.0)))

    def place(self, share: float) -> float:
        return float(np.interp(share, self.shares, self.places))

    def share(self, points: Floats) -> Floats:
        return np.interp(points @ self.axis, self.places, self.shares)


def _chords(
    corners: Floats, directions: Directions, profile: _Profile, joints: Floats, place: float, across: float
) -> Iterator[Chord]:
    """Lines across an axis: from ends of other streets near the place, then through points inside."""
    if directions.has_centre and contains(corners, directions.centre):
        diameter = traced_both_ways(corners, directions, directions.centre, across)
        if diameter is not None:
            yield diameter
    shares = profile.share(joints)
    near = np.flatnonzero(np.abs(shares - 0.5) <= _WINDOW)
    order = near[np.argsort(np.abs(shares[near] - place), kind="stable")]
    if len(order):
        edges = nearest_edge(corners, joints[order])[0]
        for joint, edge in zip(joints[order], edges, strict=True):
            heading = _inward(corners, joint, int(edge), across)
            chord = None if heading is None else traced_inwards(corners, directions, joint, int(edge), heading)
            if chord is not None:
                yield chord
    for shift in _ALTERNATIVES:
        start = _middle_of_longest(corners, profile.axis, profile.place(place + shift))
        chord = None if start is None else traced_both_ways(corners, directions, start, across)
        if chord is not None:
            yield chord


def _inward(corners: Floats, point: Floats, edge: int, across: float) -> float | None:
    """That of the two headings across an axis which leads into the ring from a point on its edge."""
    along = corners[(edge + 1) % len(corners)] - corners[edge]
    sine = float(along[0] * np.sin(across) - along[1] * np.cos(across)) / max(float(np.hypot(*along)), 1e-9)
    if abs(sine) < _MIN_CROSSING:
        return None
    return across if sine > 0 else across + np.pi


def _middle_of_longest(corners: Floats, axis: Floats, place: float) -> Floats | None:
    """[2] middle of the longest part inside a ring of the line across an axis at a place."""
    normal = np.array([-axis[1], axis[0]])
    side, across = corners @ axis - place, corners @ normal
    after = following(side)
    crosses = np.flatnonzero((side >= 0) != (after >= 0))
    if len(crosses) < 2:
        return None
    share = side[crosses] / (side[crosses] - after[crosses])
    hits = np.sort(across[crosses] + share * (following(across)[crosses] - across[crosses]))
    longest = int((hits[1::2] - hits[::2]).argmax())
    return place * axis + (hits[2 * longest] + hits[2 * longest + 1]) / 2 * normal


def _inner_point(corners: Floats) -> Floats:
    """[2] a point inside a ring, near its middle."""
    middle = float(_Profile.of(corners, np.array([1.0, 0.0])).place(0.5))
    point = _middle_of_longest(corners, np.array([1.0, 0.0]), middle)
    return corners.mean(axis=0) if point is None else point


def _is_corner(corners: Floats) -> Flags:
    """[n] flags of corners at which a ring turns."""
    along = following(corners) - corners
    before = np.roll(along, 1, axis=0)
    cross = before[:, 0] * along[:, 1] - before[:, 1] * along[:, 0]
    return np.abs(np.arctan2(cross, (before * along).sum(axis=1))) > _CORNER


def _snapped(corners: Floats, chord: Chord, targets: Floats) -> Chord:
    """A chord whose ends are moved onto crossings and corners [m, 2] that are near."""
    if not len(targets):
        return chord
    reach = min(_SNAP, 0.25 * chord.length)
    for end in (0, 1):
        point = chord.points[-1 if end else 0]
        distance = np.linalg.norm(targets - point, axis=1)
        nearest = int(distance.argmin())
        if 0 < distance[nearest] <= reach:
            target = targets[nearest]
            edge = int(nearest_edge(corners, target[None])[0][0])
            chord = bent(chord, end, target, edge)
    return chord


def _badness(cut: _Cut, rules: SplitRules) -> float:
    """0 for a good split, at least 1 for one that is not made at all."""
    areas = [part.area for part in cut.parts]
    share = min(areas) / max(sum(areas), 1e-9)
    compactness = min(4 * np.pi * part.area / part.length**2 for part in cut.parts)
    crossing = min(_crossing_sine(cut.ring.corners, cut.chord, end) for end in (0, 1))
    net = min(_net_area(part) for part in cut.parts)
    if net < 0.5 * rules.block_area[0] or share < 0.1 or crossing < 0.25 or not _is_simple(cut):
        return 1.0
    faults = (
        max(0.0, _MIN_SHARE - share) / _MIN_SHARE,
        max(0.0, _MIN_COMPACTNESS - compactness) / _MIN_COMPACTNESS,
        max(0.0, _MIN_CROSSING - crossing) / _MIN_CROSSING,
        max(0.0, 1.0 - net / rules.block_area[0]),
    )
    return min(sum(faults) / len(faults), 0.99)


def _crossing_sine(corners: Floats, chord: Chord, end: int) -> float:
    """Sine of the angle between a chord and the edge at one of its ends; the smaller one at a corner."""
    edge = chord.edges[end]
    num = len(corners)
    point = chord.points[-1 if end else 0]
    inner = chord.points[-2 if end else 1] - point
    sines = []
    for index in {edge, (edge + 1) % num, (edge - 1) % num}:
        ends = corners[index], corners[(index + 1) % num]
        if index != edge and min(float(np.hypot(*(corner - point))) for corner in ends) > _ON_RING:
            continue
        along = ends[1] - ends[0]
        sines.append(
            abs(float(inner[0] * along[1] - inner[1] * along[0])) / (float(np.hypot(*inner) * np.hypot(*along)) + 1e-12)
        )
    return min(sines)


def _is_simple(cut: _Cut) -> bool:
    """Whether both parts are simple polygons that fill the ring; a bent chord may cross it or itself."""
    shapes = [shapely.Polygon(part.corners) for part in cut.parts]
    whole = cut.ring.area
    return (
        all(shape.is_valid for shape in shapes) and abs(sum(shape.area for shape in shapes) - whole) <= _FILLED * whole
    )
