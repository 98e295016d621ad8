"""Outlines of the features of a map: taken apart, in metres, repaired, each with a reason if it cannot be used."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from hashlib import sha256

import numpy as np
import shapely
from numpy.typing import NDArray

from grammarlab.arrays import Flags, Floats, Ints
from grammarlab.city import parcel_reasons
from grammarlab.city.parcels import Outlines
from grammarlab.errors import AssetError

MAX_AREA_CHANGE = 0.05
"""Largest change of the area of an outline by a repair, as a share."""
_MIN_PIECE = 0.01
"""Share of the area of a repaired outline below which a piece is left out."""
_MAX_CORNERS = 10_000
"""Most corners of an outline."""
_MAX_CROSSINGS = 500_000
"""Most pairs of edges of an outline that is repaired whose boxes meet: each may be a crossing."""
_SAMPLE = 100
"""Edges whose neighbours are counted to estimate all such pairs."""
_MAX_TOTAL_CORNERS = 100_000_000
_MAX_DISTANCE = 1e6
"""Metres from the middle of a map beyond which an outline is a mistake."""
_MAX_TILT = np.cos(np.radians(30.0))
"""Smallest vertical part of the normal of an outline."""
_HEIGHTS = (-500.0, 9_000.0)
"""Metres between which land lies."""
_ROWS = 65_536
"""Outlines that are compared at a time, so that there are few copies of a large map."""
_DECIMALS = 3
"""Of metres, to which outlines are compared."""
_SLIVER = 1.0
"""Square metres below which a part is left out if another one is larger: rounding makes some, and the numbers of the
parts should not depend on them."""
_MIN_AREA, _MIN_SIDE = 30.0, 2.0
"""Square metres and metres of the smallest parcel."""
_STREET_AREA, _STREET_COMPACTNESS = 500.0, 0.1
"""Square metres and 4πA/P² of parcels that are streets."""


@dataclass(frozen=True, eq=False, kw_only=True)
class Pieces:
    """P polygons of N features, at least one of each feature, in the order of the features and of their places."""

    feature: Ints
    """[P] row of the feature."""
    outline: Outlines
    """[P] polygons in metres of a system on the earth; empty where there is none."""
    elevation: Floats
    """[P] mean height of the corners in metres, NaN if unknown."""
    reason: NDArray[np.object_]
    """[P] see `grammarlab.city.parcel_reasons`; empty for usable outlines."""
    num_repaired: int = 0
    """Outlines that crossed themselves and are used."""
    num_slivers: int = 0
    """Parts of several that are left out, since they are too small to be drawn on purpose."""

    @property
    def usable(self) -> Flags:
        """[P] whether an outline has no reason."""
        return self.reason == ""


def polygons_of(geometry: NDArray[np.object_]) -> tuple[Outlines, Ints]:
    """All polygons of geometries [N], also in collections, and the row of each.

    Raises:
        AssetError: If they have too many corners; it does not name the file.
    """
    parts, row = shapely.get_parts(geometry, return_index=True)
    parts, inner = shapely.get_parts(parts, return_index=True)
    is_polygon = (shapely.get_type_id(parts) == shapely.GeometryType.POLYGON) & ~shapely.is_empty(parts)
    if shapely.get_num_coordinates(parts).sum() > _MAX_TOTAL_CORNERS:
        raise AssetError(f"expected at most {_MAX_TOTAL_CORNERS:,} corners. Cut out a smaller area")
    return parts[is_polygon], row[inner][is_polygon]


def pieces_of(geometry: NDArray[np.object_], metres: Callable[[Floats], Floats], height_unit: float = 1.0) -> Pieces:
    """The polygons of features in metres.

    Args:
        geometry: [N] geometries of a map, None where there are none.
        metres: turns points [n, 2] of the map into metres.
        height_unit: metres per unit of heights.
    """
    polygons, feature = polygons_of(geometry)
    reason = np.full(len(polygons), "", dtype=object)
    elevation, is_tilted, outline = _placed(polygons, metres, height_unit)
    _set_reason(reason, ~_is_near(outline), parcel_reasons.COORDINATES)
    outline[reason != ""] = shapely.Polygon()
    _set_reason(reason, shapely.get_num_coordinates(outline) > _MAX_CORNERS, parcel_reasons.CORNERS)
    _set_reason(reason, is_tilted, parcel_reasons.TILTED)
    rest = np.setdiff1d(np.arange(len(geometry)), feature)
    pieces = Pieces(
        feature=np.concatenate([feature, rest]),
        outline=np.concatenate([outline, np.full(len(rest), shapely.Polygon(), dtype=object)]),
        elevation=np.concatenate([elevation, np.full(len(rest), np.nan)]),
        reason=np.concatenate([reason, np.full(len(rest), parcel_reasons.GEOMETRY, dtype=object)]),
    )
    return _in_order(_without_slivers(_repaired(pieces)))


def canonical_outlines(pieces: Pieces, num_features: int) -> list[bytes]:
    """[N] hashes of the outlines of features, to the millimetre, wherever their rings start and however they turn."""
    digests: list[list[bytes]] = [[] for _ in range(num_features)]
    for start in range(0, len(pieces.outline), _ROWS):
        rows = slice(start, start + _ROWS)
        rounded = shapely.transform(pieces.outline[rows], lambda points: np.round(points, _DECIMALS) + 0.0)
        texts = shapely.to_wkb(shapely.normalize(rounded))
        for row, text in zip(pieces.feature[rows].tolist(), texts, strict=True):
            digests[row].append(sha256(text).digest())
    return [one[0] if len(one) == 1 else sha256(b"".join(sorted(one))).digest() for one in digests]


def unbuildable(outline: Outlines) -> NDArray[np.object_]:
    """[N] why nothing can be built inside valid outlines because of their shapes; empty for the others."""
    reason = np.full(len(outline), "", dtype=object)
    area = shapely.area(outline)
    with np.errstate(divide="ignore", invalid="ignore"):
        compactness = 4 * np.pi * area / shapely.length(outline) ** 2
    _set_reason(reason, (compactness < _STREET_COMPACTNESS) & (area > _STREET_AREA), parcel_reasons.STREET)
    _set_reason(reason, area < _MIN_AREA, parcel_reasons.SMALL)
    _set_reason(reason, _is_narrow(outline, area), parcel_reasons.NARROW)
    return reason


def _set_reason(reason: NDArray[np.object_], rows: Flags, word: str) -> None:
    """Set the reason of rows that have none."""
    reason[rows & (reason == "")] = word


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


def _placed(
    polygons: Outlines, metres: Callable[[Floats], Floats], height_unit: float
) -> tuple[Floats, Flags, Outlines]:
    """Heights of polygons, whether they are inclined, and their outlines in metres."""
    flat = shapely.transform(polygons, metres)
    elevation, is_tilted = np.full(len(flat), np.nan), np.zeros(len(flat), dtype=np.bool_)
    rows = np.flatnonzero(shapely.has_z(polygons))
    if len(rows) == 0:
        return elevation, is_tilted, flat
    heights = shapely.get_coordinates(shapely.get_exterior_ring(polygons[rows]), include_z=True)[:, 2] * height_unit
    points, ring = shapely.get_coordinates(shapely.get_exterior_ring(flat[rows]), return_index=True)
    if not heights.any():  # a map without heights in a format that has them
        return elevation, is_tilted, flat
    with np.errstate(invalid="ignore", over="ignore"):
        is_plausible = np.ones(len(rows), dtype=np.bool_)
        np.logical_and.at(is_plausible, ring, (heights >= _HEIGHTS[0]) & (heights <= _HEIGHTS[1]))
        normal = _normals(np.column_stack([points, heights]), ring, len(rows))
        length = np.linalg.norm(normal, axis=1)
        is_tilted[rows] = is_plausible & (np.abs(normal[:, 2]) < _MAX_TILT * length)
        counts = np.bincount(ring, minlength=len(rows))
        mean = np.bincount(ring, heights, minlength=len(rows)) / counts
    elevation[rows[is_plausible]] = mean[is_plausible]
    return elevation, is_tilted, flat


def _normals(points: Floats, ring: Ints, num_rings: int) -> Floats:
    """[R, 3] normals of rings by Newell's method, twice as long as their areas."""
    starts = np.searchsorted(ring, np.arange(num_rings))
    local = points - points[starts][ring]
    is_edge = ring[:-1] == ring[1:]
    cross = np.cross(local[:-1], local[1:])[is_edge]
    normals = np.zeros((num_rings, 3))
    for axis in range(3):
        normals[:, axis] = np.bincount(ring[:-1][is_edge], cross[:, axis], minlength=num_rings)
    return normals


def _is_near(outline: Outlines) -> Flags:
    """[P] whether all corners of an outline are finite and near the middle of all outlines."""
    points, row = shapely.get_coordinates(outline, return_index=True)
    is_finite = np.isfinite(points).all(axis=1)
    middle = np.median(points[is_finite], axis=0) if is_finite.any() else np.zeros(2)
    with np.errstate(invalid="ignore"):
        is_corner_near = (np.abs(points - middle) <= _MAX_DISTANCE).all(axis=1)
    near = np.ones(len(outline), dtype=np.bool_)
    near[row[~is_corner_near]] = False
    return near


def _repaired(pieces: Pieces) -> Pieces:
    """The same, with valid polygons instead of those that cross themselves."""
    rows = np.flatnonzero((pieces.reason == "") & ~shapely.is_valid(pieces.outline))
    if len(rows) == 0:
        return pieces
    reason, outline = pieces.reason.copy(), pieces.outline.copy()
    feature, elevation = [pieces.feature], [pieces.elevation]
    outlines: list[Outlines] = [outline]
    num_more = 0
    for row in rows:
        polygons = _valid(outline[row])
        outline[row] = polygons[0] if polygons else shapely.Polygon()
        if not polygons:
            reason[row] = parcel_reasons.INVALID
        elif len(polygons) > 1:
            num_more += len(polygons) - 1
            outlines.append(np.array(polygons[1:], dtype=object))
            feature.append(np.repeat(pieces.feature[row], len(polygons) - 1))
            elevation.append(np.repeat(pieces.elevation[row], len(polygons) - 1))
    return Pieces(
        feature=np.concatenate(feature),
        outline=np.concatenate(outlines),
        elevation=np.concatenate(elevation),
        reason=np.concatenate([reason, np.full(num_more, "", dtype=object)]),
        num_repaired=int((reason[rows] == "").sum()),
    )


def _valid(polygon: shapely.Polygon) -> list[shapely.Polygon]:
    """Valid polygons with the area of an invalid one; none if that changes the area."""
    if _num_meeting(polygon) > _MAX_CROSSINGS:
        return []
    parts = shapely.get_parts(shapely.get_parts(shapely.make_valid(polygon)))  # polygons may be in two levels
    polygons = [part for part in parts if isinstance(part, shapely.Polygon)]
    area = sum(part.area for part in polygons)
    drawn = _drawn_area(polygon)
    if area == 0.0 or abs(area - drawn) > MAX_AREA_CHANGE * drawn:
        return []
    return [part for part in polygons if part.area >= _MIN_PIECE * area]


def _num_meeting(polygon: shapely.Polygon) -> float:
    """About the number of pairs of edges of a polygon whose boxes meet."""
    points, ring = shapely.get_coordinates(shapely.get_rings(polygon), return_index=True)
    is_edge = ring[:-1] == ring[1:]
    lines = shapely.linestrings(np.stack([points[:-1][is_edge], points[1:][is_edge]], axis=1))
    edges = np.asarray(lines, dtype=object)
    sample = edges[:: max(len(edges) // _SAMPLE, 1)]
    pairs = shapely.STRtree(edges).query(sample)
    return pairs.shape[1] * len(edges) / (2 * max(len(sample), 1))


def _drawn_area(polygon: shapely.Polygon) -> float:
    """The area that the rings of a polygon go around, less what they go around in the other direction."""
    outer, *holes = (_ring_area(shapely.get_coordinates(ring)) for ring in (polygon.exterior, *polygon.interiors))
    return outer - sum(holes)


def _ring_area(ring: Floats) -> float:
    x, y = (ring - ring[0]).T
    return abs(float(x[:-1] @ y[1:] - x[1:] @ y[:-1])) / 2


def _without_slivers(pieces: Pieces) -> Pieces:
    """The same without parts that are too small, if their features have a larger one."""
    is_large = (shapely.area(pieces.outline) >= _SLIVER) & (pieces.reason == "")
    has_large = np.zeros(pieces.feature.max(initial=0) + 1, dtype=np.bool_)
    has_large[pieces.feature[is_large]] = True
    is_sliver = has_large[pieces.feature] & (shapely.area(pieces.outline) < _SLIVER)
    num_slivers = int(is_sliver.sum())
    return replace(_taken(pieces, np.flatnonzero(~is_sliver)), num_slivers=num_slivers) if num_slivers else pieces


def _taken(pieces: Pieces, rows: Ints) -> Pieces:
    """The pieces at some rows."""
    return replace(
        pieces,
        feature=pieces.feature[rows],
        outline=pieces.outline[rows],
        elevation=pieces.elevation[rows],
        reason=pieces.reason[rows],
    )


def _in_order(pieces: Pieces) -> Pieces:
    """The same, the pieces of each feature in the order of their lower left corners."""
    counts = np.bincount(pieces.feature)
    order = np.argsort(pieces.feature, kind="stable")
    if (counts > 1).any():
        shared = np.flatnonzero(counts[pieces.feature] > 1)
        texts = np.array(
            [text.hex() for text in shapely.to_wkb(shapely.normalize(pieces.outline[shared]))], dtype=object
        )
        ranks = np.zeros(len(order), dtype=np.int64)
        ranks[shared[np.argsort(texts, kind="stable")]] = np.arange(len(shared))
        bounds = np.nan_to_num(shapely.bounds(pieces.outline), nan=np.inf)
        order = np.lexsort((ranks, bounds[:, 1], bounds[:, 0], pieces.feature))
    return _taken(pieces, order)
