"""Outlines of the features of a map: taken apart, in metres, repaired, each with a reason if it cannot be used."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from hashlib import sha256
from itertools import groupby, pairwise
from operator import itemgetter

import numpy as np
import shapely
from numpy.typing import NDArray

from grammarlab.arrays import Flags, Floats, Ints, offsets_from_counts
from grammarlab.city import parcel_reasons
from grammarlab.city.outline_heights import heights_of
from grammarlab.city.outline_repair import valid_parts
from grammarlab.city.packed_outlines import Outlines, PackedOutlines
from grammarlab.errors import AssetError

_MAX_CORNERS = 10_000
"""Most corners of an outline."""
_MAX_TOTAL_CORNERS = 100_000_000
_MAX_DISTANCE = 1e6
"""Metres from the middle of a map beyond which an outline is a mistake."""
_DECIMALS = 3
"""Of metres, to which outlines are compared."""
_SLIVER = 1.0
"""Square metres below which a part is left out if another one is larger: rounding makes some, and the numbers of the
parts should not depend on them."""


@dataclass(frozen=True, eq=False, kw_only=True)
class Pieces:
    """P polygons of N features, at least one of each feature, in the order of the features and of their places."""

    feature: Ints
    """[P] row of the feature."""
    outlines: PackedOutlines
    """[P] polygons in metres of a system on the earth; empty where there is none."""
    elevation: Floats
    """[P] mean height of the corners in metres, NaN if unknown."""
    reason: NDArray[np.object_]
    """[P] see `grammarlab.city.parcel_reasons`; empty for usable outlines."""
    key: Sequence[bytes]
    """[N] hashes of the outlines of features, to the millimetre, wherever their rings start and however they turn."""
    num_repaired: int = 0
    """Outlines that crossed themselves and are used."""
    num_slivers: int = 0
    """Parts of several that are left out, since they are too small to be drawn on purpose."""

    @property
    def usable(self) -> Flags:
        """[P] whether an outline has no reason."""
        return self.reason == ""


@dataclass(frozen=True, eq=False, kw_only=True)
class _Block:
    """The polygons of some consecutive features, in any order; columns as those of `Pieces`."""

    feature: Ints
    """[P] row of the feature in the block."""
    outline: Outlines
    elevation: Floats
    reason: NDArray[np.object_]
    num_repaired: int = 0
    num_slivers: int = 0


@dataclass(frozen=True, eq=False, kw_only=True)
class _Placed:
    """All polygons of a map in metres."""

    outlines: list[PackedOutlines]
    """Those of each block."""
    elevation: Floats
    is_tilted: Flags
    feature: list[Ints]
    """Rows of the features of the polygons within each block."""
    num_features: list[int]
    """Numbers of the features of each block."""


def polygons_of(geometry: NDArray[np.object_]) -> tuple[Outlines, Ints]:
    """All polygons of geometries [N], also in collections, and the row of each."""
    parts, row = shapely.get_parts(geometry, return_index=True)
    parts, inner = shapely.get_parts(parts, return_index=True)
    is_polygon = (shapely.get_type_id(parts) == shapely.GeometryType.POLYGON) & ~shapely.is_empty(parts)
    return parts[is_polygon], row[inner][is_polygon]


def pieces_of(
    geometry: Iterable[NDArray[np.object_]], metres: Callable[[Floats], Floats], height_unit: float = 1.0
) -> Pieces:
    """The polygons of features in metres.

    Args:
        geometry: [N] geometries of a map in blocks, None where there are none.
        metres: turns points [n, 2] of the map into metres.
        height_unit: metres per unit of heights.

    Raises:
        AssetError: If they have too many corners; it does not name the file.
    """
    placed = _placed(geometry, metres, height_unit)
    middle = _middle(placed.outlines)
    blocks: list[_Block] = []
    keys: list[bytes] = []
    offsets = offsets_from_counts(np.array([len(rows) for rows in placed.feature], np.int64)).tolist()
    for number, (start, end) in enumerate(pairwise(offsets)):
        outline = placed.outlines[number][:]
        reason = np.full(len(outline), "", dtype=object)
        _set_reason(reason, ~_is_near(placed.outlines[number], middle), parcel_reasons.COORDINATES)
        outline[reason != ""] = shapely.Polygon()
        _set_reason(reason, shapely.get_num_coordinates(outline) > _MAX_CORNERS, parcel_reasons.CORNERS)
        _set_reason(reason, placed.is_tilted[start:end], parcel_reasons.TILTED)
        elevation = placed.elevation[start:end]
        block = _Block(feature=placed.feature[number], outline=outline, elevation=elevation, reason=reason)
        block = _in_order(_without_slivers(_repaired(_with_all_features(block, placed.num_features[number]))))
        keys += _keys(block)
        # What is finished takes the place of what it is made from.
        placed.outlines[number] = PackedOutlines.of(block.outline)
        blocks.append(replace(block, outline=np.zeros(0, object)))
    return _joined(blocks, placed.outlines, keys, placed.num_features)


def _joined(
    blocks: Sequence[_Block], packed: Sequence[PackedOutlines], keys: list[bytes], num_features: Sequence[int]
) -> Pieces:
    starts = offsets_from_counts(np.array(num_features, np.int64)).tolist()
    features = [block.feature + start for block, start in zip(blocks, starts, strict=False)]
    return Pieces(
        feature=np.concatenate([np.zeros(0, np.int64), *features]),
        outlines=PackedOutlines.concatenate(packed),
        elevation=np.concatenate([np.zeros(0), *(block.elevation for block in blocks)]),
        reason=np.concatenate([np.zeros(0, object), *(block.reason for block in blocks)]),
        key=keys,
        num_repaired=sum(block.num_repaired for block in blocks),
        num_slivers=sum(block.num_slivers for block in blocks),
    )


def _with_all_features(block: _Block, num_features: int) -> _Block:
    """The same, with an empty piece of each feature without polygons."""
    rest = np.setdiff1d(np.arange(num_features), block.feature)
    return _Block(
        feature=np.concatenate([block.feature, rest]),
        outline=np.concatenate([block.outline, np.full(len(rest), shapely.Polygon(), dtype=object)]),
        elevation=np.concatenate([block.elevation, np.full(len(rest), np.nan)]),
        reason=np.concatenate([block.reason, np.full(len(rest), parcel_reasons.GEOMETRY, dtype=object)]),
    )


def _keys(block: _Block) -> list[bytes]:
    """Keys of the features of a block whose pieces are in the order of their features."""
    rounded = shapely.transform(block.outline, lambda points: np.round(points, _DECIMALS) + 0.0)
    texts = shapely.to_wkb(shapely.normalize(rounded))
    keys = []
    for _, pieces in groupby(zip(block.feature.tolist(), texts, strict=True), key=itemgetter(0)):
        digests = [sha256(text).digest() for _, text in pieces]
        keys.append(digests[0] if len(digests) == 1 else sha256(b"".join(sorted(digests))).digest())
    return keys


def _set_reason(reason: NDArray[np.object_], rows: Flags, word: str) -> None:
    """Set the reason of rows that have none."""
    reason[rows & (reason == "")] = word


def _placed(geometry: Iterable[NDArray[np.object_]], metres: Callable[[Floats], Floats], height_unit: float) -> _Placed:
    """The polygons of blocks of geometries, in metres, with their heights and whether they are inclined."""
    outlines, heights = list[PackedOutlines](), list[tuple[Floats, Flags]]()
    features, num_features = list[Ints](), list[int]()
    num_corners = 0
    has_heights = False
    for block in geometry:
        polygons, feature = polygons_of(block)
        num_corners += int(shapely.get_num_coordinates(block).sum())
        if num_corners > _MAX_TOTAL_CORNERS:
            raise AssetError(f"expected at most {_MAX_TOTAL_CORNERS:,} corners. Cut out a smaller area")
        flat = shapely.transform(polygons, metres)
        elevation, is_tilted, is_high = heights_of(polygons, flat, height_unit)
        has_heights |= is_high
        outlines.append(PackedOutlines.of(flat))
        heights.append((elevation, is_tilted))
        features.append(feature)
        num_features.append(len(block))
    elevation = np.concatenate([np.zeros(0), *(elevation for elevation, _ in heights)])
    is_tilted = np.concatenate([np.zeros(0, np.bool_), *(is_tilted for _, is_tilted in heights)])
    if not has_heights:  # a map without heights in a format that has them
        elevation, is_tilted = np.full(len(elevation), np.nan), np.zeros(len(elevation), np.bool_)
    return _Placed(
        outlines=outlines,
        elevation=elevation,
        is_tilted=is_tilted,
        feature=features,
        num_features=num_features,
    )


def _middle(blocks: Sequence[PackedOutlines]) -> Floats:
    """[2] median of all finite corners."""
    middle = np.zeros(2)
    is_finite = [np.isfinite(block.points).all(axis=1) for block in blocks]
    if any(finite.any() for finite in is_finite):
        for axis in range(2):
            column = np.concatenate([b.points[finite, axis] for b, finite in zip(blocks, is_finite, strict=True)])
            middle[axis] = np.median(column, overwrite_input=True)
    return middle


def _is_near(outlines: PackedOutlines, middle: Floats) -> Flags:
    """[P] whether all corners of an outline are finite and near the middle of all outlines."""
    with np.errstate(invalid="ignore"):
        is_corner_near = (np.abs(outlines.points - middle) <= _MAX_DISTANCE).all(axis=1)
    near = np.ones(len(outlines), dtype=np.bool_)
    near[np.searchsorted(outlines.point_offsets, np.flatnonzero(~is_corner_near), side="right") - 1] = False
    return near


def _repaired(block: _Block) -> _Block:
    """The same, with valid polygons instead of those that cross themselves."""
    rows = np.flatnonzero((block.reason == "") & ~shapely.is_valid(block.outline))
    if len(rows) == 0:
        return block
    reason, outline = block.reason.copy(), block.outline.copy()
    feature, elevation = [block.feature], [block.elevation]
    outlines: list[Outlines] = [outline]
    num_more = 0
    for row in rows:
        polygons = valid_parts(outline[row])
        outline[row] = polygons[0] if polygons else shapely.Polygon()
        if not polygons:
            reason[row] = parcel_reasons.INVALID
        elif len(polygons) > 1:
            num_more += len(polygons) - 1
            outlines.append(np.array(polygons[1:], dtype=object))
            feature.append(np.repeat(block.feature[row], len(polygons) - 1))
            elevation.append(np.repeat(block.elevation[row], len(polygons) - 1))
    return _Block(
        feature=np.concatenate(feature),
        outline=np.concatenate(outlines),
        elevation=np.concatenate(elevation),
        reason=np.concatenate([reason, np.full(num_more, "", dtype=object)]),
        num_repaired=int((reason[rows] == "").sum()),
    )


def _without_slivers(block: _Block) -> _Block:
    """The same without parts that are too small, if their features have a larger one."""
    is_large = (shapely.area(block.outline) >= _SLIVER) & (block.reason == "")
    has_large = np.zeros(block.feature.max(initial=0) + 1, dtype=np.bool_)
    has_large[block.feature[is_large]] = True
    is_sliver = has_large[block.feature] & (shapely.area(block.outline) < _SLIVER)
    num_slivers = int(is_sliver.sum())
    return replace(_taken(block, np.flatnonzero(~is_sliver)), num_slivers=num_slivers) if num_slivers else block


def _taken(block: _Block, rows: Ints) -> _Block:
    """The pieces at some rows."""
    return replace(
        block,
        feature=block.feature[rows],
        outline=block.outline[rows],
        elevation=block.elevation[rows],
        reason=block.reason[rows],
    )


def _in_order(block: _Block) -> _Block:
    """The same, the pieces of each feature in the order of their lower left corners."""
    counts = np.bincount(block.feature)
    order = np.argsort(block.feature, kind="stable")
    if (counts > 1).any():
        shared = np.flatnonzero(counts[block.feature] > 1)
        texts = np.array(
            [text.hex() for text in shapely.to_wkb(shapely.normalize(block.outline[shared]))], dtype=object
        )
        ranks = np.zeros(len(order), dtype=np.int64)
        ranks[shared[np.argsort(texts, kind="stable")]] = np.arange(len(shared))
        bounds = np.nan_to_num(shapely.bounds(block.outline), nan=np.inf)
        order = np.lexsort((ranks, bounds[:, 1], bounds[:, 0], block.feature))
    return _taken(block, order)
