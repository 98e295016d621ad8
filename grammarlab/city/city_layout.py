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
from grammarlab.city.parcels import Outlines, Parcels
from grammarlab.city.plot_cuts import Plots, smallest_boxes
from grammarlab.city.shared_corners import with_shared_corners
from grammarlab.city.street_lines import StreetLines
from grammarlab.city.streets import Region, SplitRules, Street, street_network
from grammarlab.city.subdivision import PlotTree, SizeColumns, subdivided
from grammarlab.errors import UsageError
from grammarlab.randomness import Keys, fold, root_keys, uniforms

_BLOCK_LANE, _USE_LANE = 0, 1
"""Words below the key of a block: of its parcels, and of its use."""
_SIMPLER, _LEAST_SIMPLER, _MOST_SIMPLER = 0.25, 0.05, 4.0
"""Tolerance: distance by which the outline is simplified, as a share of the width of the street along it, half of which
is inside; and its limits in metres."""
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
    streets: list[Street] = []
    regions: list[Region] = []
    for number, part in enumerate(parts):
        network_streets, network_regions = _network(request, part, number, len(parts))
        streets += network_streets
        regions += network_regions
    lines = _street_lines(request, parts, streets)
    blocks = block_outlines(regions, _obstacles(request, parts, lines))
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


def _network(request: LayoutRequest, part: shapely.Polygon, number: int, num: int) -> tuple[list[Street], list[Region]]:
    """Streets and regions of a part of the outline. Paths of several parts begin as those of a tree of the parts."""
    rules = SplitRules(
        widths=request.widths,
        block_area=request.block_area,
        block_depth=2.0 * request.sizes.depth,
        variation=request.variation,
        seed=request.seed,
        root=(1 << (num - 1).bit_length()) + number,
    )
    filled = shapely.Polygon(part.exterior)
    network = street_network(ring_of(filled, request.outline_street), _directions(request, part), rules)
    return list(network.streets), list(network.regions)


def _directions(request: LayoutRequest, part: shapely.Polygon) -> Directions:
    return directions_on(request.field, part)


def _street_lines(request: LayoutRequest, parts: list[shapely.Polygon], streets: list[Street]) -> StreetLines:
    """Centre lines of all streets, without what is in holes."""
    lines = np.array([shapely.linestrings(street.points) for street in streets], dtype=object)
    width = np.array([street.width for street in streets], dtype=np.float64)
    holes = shapely.union_all([shapely.Polygon(ring) for part in parts for ring in part.interiors])
    if len(lines) and not holes.is_empty:
        lines = shapely.difference(lines, holes)
    around = [shapely.LineString(ring.coords) for part in parts for ring in (part.exterior, *part.interiors)]
    if request.outline_street > 0:
        lines = np.concatenate([lines, np.array(around, dtype=object)])
        width = np.concatenate([width, np.full(len(around), request.outline_street)])
    links = _links(parts, lines)
    lines = np.concatenate([lines, links])
    width = np.concatenate([width, np.full(len(links), request.widths[-1])])
    pieces, row = shapely.get_parts(lines, return_index=True)
    is_line = shapely.get_type_id(pieces) == shapely.GeometryType.LINESTRING
    return StreetLines(pieces[is_line], width[row[is_line]])


def _links(parts: list[shapely.Polygon], lines: NDArray[np.object_]) -> NDArray[np.object_]:
    """Streets from holes to the nearest street, for holes that none reaches."""
    links = []
    for part in parts:
        rings = [shapely.LineString(ring.coords) for ring in part.interiors]
        for ring in rings:
            others = lines[~shapely.equals_exact(lines, ring, 0.0)] if len(lines) else lines
            others = np.concatenate([others, np.array([shapely.LineString(part.exterior.coords)], dtype=object)])
            distance = shapely.distance(others, ring)
            nearest = int(distance.argmin())
            if distance[nearest] > 0:
                link = shapely.shortest_line(ring, others[nearest])
                links.append(shapely.transform(link, lambda points: np.round(points, 3)))
    return np.array(links, dtype=object)


def _obstacles(request: LayoutRequest, parts: list[shapely.Polygon], lines: StreetLines) -> BaseGeometry:
    """Ground that belongs to no block, but for the streets around regions."""
    areas: list[BaseGeometry] = []
    holes = [shapely.Polygon(ring) for part in parts for ring in part.interiors]
    if holes:
        areas += [shapely.buffer(hole, request.outline_street / 2, join_style="mitre") for hole in holes]
        links = lines.line[-len(holes) :]
        areas += [
            shapely.buffer(link, request.widths[-1] / 2, cap_style="square")
            for link in links
            if shapely.get_num_points(link) == 2
        ]
    if request.field.kind != "grid":
        radius = _PLACE_RADIUS * request.widths[0]
        for part in parts:
            centre = shapely.Point(_directions(request, part).centre)
            if part.area > (16.0 * radius) ** 2 and part.contains(centre.buffer(4.0 * radius)):
                areas.append(shapely.buffer(centre, radius, quad_segs=8))
    return shapely.union_all(areas)


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
        outline=outline[: len(names)][order],
        elevation=np.full(len(names), np.nan),
        attributes=pa.table(attributes),
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
