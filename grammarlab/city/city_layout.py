"""Layouts: streets, blocks and parcels where there is no map.

What a layout depends on:

- The streets depend on the outline, the field, the widths, the areas of blocks, the sizes of parcels, the variation and
  the seed. The first street follows from the shape of the whole, so another outline is another layout.
- The parcels of a block depend on its outline, its sizes, its seed and its id. An edit changes nothing but its block:
  all other blocks stay the same to the last bit.
"""

from __future__ import annotations

import difflib
from dataclasses import dataclass

import numpy as np
import pyarrow as pa
import shapely
from numpy.typing import NDArray
from shapely.geometry.base import BaseGeometry

from grammarlab.arrays import Flags, Ints, offsets_from_counts
from grammarlab.city.city_blocks import BlockOutlines, block_outlines, ring_of, street_edges
from grammarlab.city.direction_field import Directions, directions_on
from grammarlab.city.layout_request import LayoutRequest, ParcelSizes
from grammarlab.city.packed_outlines import Outlines, PackedOutlines
from grammarlab.city.parcels import Parcels
from grammarlab.city.plot_cuts import Plots, smallest_boxes
from grammarlab.city.shared_corners import with_shared_corners
from grammarlab.city.street_chords import DECIMALS
from grammarlab.city.street_lines import StreetLines
from grammarlab.city.streets import SplitRules, street_network
from grammarlab.city.subdivision import PlotTree, SizeColumns, subdivided
from grammarlab.errors import UsageError
from grammarlab.randomness import Keys, fold, root_keys, uniforms

_BLOCK_LANE, _USE_LANE = 0, 1
"""Words below the key of a block: of its parcels, and of its use."""
_SIMPLER, _LEAST_SIMPLER, _MOST_SIMPLER = 0.25, 0.05, 4.0
"""Tolerance: distance by which the outline is simplified, as a share of the width of the street along it, half of which
is inside; and its limits in metres."""
_LEAST_STREET = 0.1
"""Tolerance: metres; shorter pieces, between holes that touch, are left out."""
_PLACE_RADIUS = 1.25
"""Prior: radius of the open place at the centre of a radial field, in widths of the widest street."""
_LEAST_BREADTH = 10.0
"""Prior: metres; narrower blocks are parks, as no house and garden fits."""
_LEAST_PART = 400.0
"""Tolerance: square metres; smaller parts of an outline have no blocks."""


@dataclass(frozen=True, eq=False)
class Blocks:
    """B areas between streets, ordered by id."""

    id: NDArray[np.object_]
    """[B] different texts: ``b`` and the path of the splits that lead to the block, in hexadecimal digits."""
    outline: Outlines
    """[B] polygons in metres of the frame."""
    use: NDArray[np.object_]
    """[B] ``lots``, ``park`` or ``open``."""

    def __len__(self) -> int:
        return len(self.id)


@dataclass(frozen=True, eq=False)
class Layout:
    """Streets, blocks and parcels of an area."""

    parcels: Parcels
    """Parcels with ids such as ``b002f-p07``: the block, and the path of cuts within it. Attributes: ``block``, the id
    of the block, ``use``, ``lots`` or ``park``, and ``frontage``, metres along streets."""
    streets: StreetLines
    """Streets between blocks, along the outline and around its holes."""
    blocks: Blocks


def laid_out(request: LayoutRequest) -> Layout:
    """Divide an area into blocks by streets, and blocks into parcels.

    Raises:
        UsageError: If no block fits, or an edit names a block that does not exist.
    """
    parts = _parts(request)
    drawn = [_divided(request, part, number, len(parts)) for number, part in enumerate(parts)]
    lines = StreetLines(
        np.concatenate([np.empty(0, dtype=object), *(streets.line for streets, _ in drawn)]),
        np.concatenate([np.empty(0), *(streets.width for streets, _ in drawn)]),
    )
    blocks = BlockOutlines.concatenate([outlines for _, outlines in drawn])
    if not len(blocks):
        raise UsageError(
            f"no block fits: the outline has {request.outline.area:,.0f} m², and a street of "
            f"{request.outline_street:g} m is along it. Give a larger area, or a smaller edge_width."
        )
    path = _paths(blocks)
    ids = np.array([f"b{number:04x}" for number in path.tolist()], dtype=object)
    _check_edits(request, ids)
    order = np.argsort(ids.astype(str))
    blocks = BlockOutlines(blocks.polygon[order], path[order], np.zeros(len(order), dtype=np.int64))
    return _with_parcels(request, blocks, ids[order], lines)


def _parts(request: LayoutRequest) -> list[shapely.Polygon]:
    """The parts of the outline, simplified, by place."""
    street = request.outline_street
    outline = shapely.simplify(request.outline, min(max(_SIMPLER * street, _LEAST_SIMPLER), _MOST_SIMPLER))
    parts = [part for part in shapely.get_parts(outline) if part.area >= _LEAST_PART]
    return sorted(parts, key=lambda part: part.bounds)


def _divided(request: LayoutRequest, part: shapely.Polygon, number: int, num: int) -> tuple[StreetLines, BlockOutlines]:
    """Streets and blocks of a part of the outline. Paths of several parts begin as those of a tree of the parts."""
    rules = SplitRules(
        widths=request.widths,
        block_area=request.block_area,
        block_depth=2.0 * request.sizes.depth,
        variation=request.variation,
        seed=request.seed,
        root=(1 << (num - 1).bit_length()) + number,
    )
    directions = directions_on(request.field, part)
    network = street_network(ring_of(shapely.Polygon(part.exterior), request.outline_street), directions, rules)
    streets = np.array([shapely.LineString(street.points) for street in network.streets], dtype=object)
    width = np.array([street.width for street in network.streets], dtype=np.float64)
    holes = shapely.union_all([shapely.Polygon(ring) for ring in part.interiors])
    if len(streets) and part.interiors:
        streets = shapely.difference(streets, holes)
    if request.outline_street > 0:
        rings = np.array([shapely.LineString(ring.coords) for ring in (part.exterior, *part.interiors)], dtype=object)
        streets = np.concatenate([streets, rings])
        width = np.concatenate([width, np.full(len(rings), request.outline_street)])
    links = _links(part, streets)
    obstacles = shapely.union_all(
        [
            shapely.buffer(holes, request.outline_street / 2, join_style="mitre"),
            *shapely.buffer(links, request.widths[-1] / 2, cap_style="square"),
            _place(request, part, directions),
        ]
    )
    pieces, row = shapely.get_parts(np.concatenate([streets, links]), return_index=True)
    width = np.concatenate([width, np.full(len(links), request.widths[-1])])[row]
    is_street = shapely.length(pieces) > _LEAST_STREET
    return StreetLines(pieces[is_street], width[is_street]), block_outlines(network.regions, obstacles)


def _links(part: shapely.Polygon, streets: NDArray[np.object_]) -> NDArray[np.object_]:
    """Streets from the holes of a part to the nearest street, for holes that no street reaches."""
    links = []
    for interior in part.interiors:
        ring = shapely.LineString(interior.coords)
        others = streets[~shapely.equals_exact(streets, ring, 0.0)] if len(streets) else streets
        others = np.concatenate([others, np.array([shapely.LineString(part.exterior.coords)], dtype=object)])
        distance = shapely.distance(others, ring)
        nearest = int(distance.argmin())
        if distance[nearest] > 0:
            link = shapely.shortest_line(ring, others[nearest])
            links.append(shapely.transform(link, lambda points: np.round(points, DECIMALS)))
    return np.array(links, dtype=object)


def _place(request: LayoutRequest, part: shapely.Polygon, directions: Directions) -> BaseGeometry:
    """The open place where streets meet; empty if there is none, or no room for it."""
    radius = _PLACE_RADIUS * request.widths[0]
    centre = shapely.Point(directions.centre)
    has_room = part.area > (16.0 * radius) ** 2 and part.contains(centre.buffer(4.0 * radius))
    return centre.buffer(radius, quad_segs=8) if directions.has_centre and has_room else shapely.Point()


def _paths(blocks: BlockOutlines) -> Ints:
    """[B] path of each block: that of its region, or below it if the region has several blocks."""
    starts = np.flatnonzero(blocks.part == 0)
    num = np.diff(np.append(starts, len(blocks)))[np.cumsum(blocks.part == 0) - 1]
    levels = np.array([(int(n) - 1).bit_length() for n in num], dtype=np.int64)
    return (blocks.path << levels) + blocks.part


def _check_edits(request: LayoutRequest, ids: NDArray[np.object_]) -> None:
    known = set(ids.tolist())
    for name in request.edits:
        if name not in known:
            close = difflib.get_close_matches(name, sorted(known), 3)
            advice = f"; near are {', '.join(close)}" if close else ""
            raise UsageError(f"unknown block {name[:40]!r}: the layout has {len(known)} blocks{advice}")


def _with_parcels(
    request: LayoutRequest, blocks: BlockOutlines, ids: NDArray[np.object_], streets: StreetLines
) -> Layout:
    outer = None
    if request.outline_street == 0:
        outer = shapely.union_all([part.exterior for part in _parts(request)])
    whole = _plots(blocks, street_edges(blocks, outer))
    use = _uses(request, blocks, ids)
    keys = _keys(request, blocks, ids)
    tree = _parcel_tree(request, whole, ids, use, keys)
    both = with_shared_corners(Plots.concatenate([tree.plots, whole]))
    plots = both.take(np.arange(len(tree.path)))
    outline = both.outline
    block_id, block_use = ids[tree.block], use[tree.block]
    names = [f"{block}-p{path:02x}" for block, path in zip(block_id.tolist(), tree.path.tolist(), strict=True)]
    order = np.argsort(np.array(names, dtype=str), kind="stable")
    attributes = {
        "block": pa.array(block_id[order].tolist(), pa.string()),
        "use": pa.array(block_use[order].tolist(), pa.string()),
        "frontage": pa.array(np.round(plots.frontage[order], 3)),
    }
    parcels = Parcels(
        frame=request.frame,
        id=np.array(names, dtype=object)[order],
        outlines=PackedOutlines.of(outline[: len(names)][order]),
        elevation=np.full(len(names), np.nan),
        attributes=pa.table(attributes),
        first_edge=np.ones(len(names), np.int32),
        reason=np.full(len(names), "", dtype=object),
    )
    return Layout(parcels, streets, Blocks(ids, outline[len(names) :], use))


def _plots(blocks: BlockOutlines, on_street: Flags) -> Plots:
    corners, row = shapely.get_coordinates(blocks.polygon, return_index=True)
    is_first = np.r_[True, row[1:] != row[:-1]][: len(row)]
    is_last = np.r_[is_first[1:], True][: len(row)]
    counts = np.bincount(row, minlength=len(blocks)) - 1
    return Plots(corners[~is_last], on_street, offsets_from_counts(counts))


def _uses(request: LayoutRequest, blocks: BlockOutlines, ids: NDArray[np.object_]) -> NDArray[np.object_]:
    """[B] use of each block."""
    draws = uniforms(fold(root_keys(request.seed, blocks.path), _USE_LANE), 0)
    is_park = (draws < request.park_share) | (smallest_boxes(blocks.polygon).breadth < _LEAST_BREADTH)
    use = np.where(is_park, "park", "lots").astype(object)
    for row, name in enumerate(ids.tolist()):
        edit = request.edits.get(name)
        if edit is not None and edit.use is not None:
            use[row] = edit.use
    return use


def _keys(request: LayoutRequest, blocks: BlockOutlines, ids: NDArray[np.object_]) -> Keys:
    """[B] keys of the draws of the parcels of each block."""
    seeds = np.full(len(blocks), request.seed, dtype=np.uint64)
    for row, name in enumerate(ids.tolist()):
        edit = request.edits.get(name)
        if edit is not None and edit.seed is not None:
            seeds[row] = edit.seed
    zero = np.zeros(len(blocks), dtype=np.uint64)
    return fold(fold(fold(zero, seeds), blocks.path), _BLOCK_LANE)


def _parcel_tree(
    request: LayoutRequest, whole: Plots, ids: NDArray[np.object_], use: NDArray[np.object_], keys: Keys
) -> PlotTree:
    """Parcels of all blocks: of lots, and one of each park."""
    lots, parks = np.flatnonzero(use == "lots"), np.flatnonzero(use == "park")
    sizes = [request.sizes] * len(ids)
    for row, name in enumerate(ids.tolist()):
        edit = request.edits.get(name)
        if edit is not None and edit.sizes is not None:
            sizes[row] = edit.sizes
    tree = subdivided(whole.take(lots), keys[lots], _size_columns([sizes[row] for row in lots]))
    block = np.concatenate([lots[tree.block], parks])
    path = np.concatenate([tree.path, np.ones(len(parks), dtype=np.int64)])
    return PlotTree(Plots.concatenate([tree.plots, whole.take(parks)]), block, path)


def _size_columns(sizes: list[ParcelSizes]) -> SizeColumns:
    return SizeColumns(
        *(
            np.array([getattr(size, name) for size in sizes], dtype=np.float64)
            for name in ("area", "spread", "frontage", "aspect", "aspect_spread")
        )
    )
