"""Made-up maps with crooked streets: blocks between streets of several widths, cut into lots at random."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import pyarrow as pa
import shapely
from shapely.geometry.base import BaseGeometry

from grammarlab.city.packed_outlines import Outlines, PackedOutlines
from grammarlab.city.parcels import Parcels
from grammarlab.city.street_lines import StreetLines
from grammarlab.geometry.footprints.frame import Frame


@dataclass(frozen=True)
class LotMap:
    """Parcels and the streets between them."""

    parcels: Parcels
    streets: StreetLines


def parcels_of(outlines: Any, ids: Any = None, **attributes: Any) -> Parcels:
    """Parcels with these outlines, in metres."""
    outlines = np.array(outlines, dtype=object)
    names = [f"p{row:05}" for row in range(len(outlines))] if ids is None else ids
    order = np.argsort(np.array(names, dtype=object))
    return Parcels(
        frame=Frame("", (0.0, 0.0)),
        id=np.array(names, dtype=object)[order],
        outlines=PackedOutlines.of(outlines[order]),
        elevation=np.full(len(outlines), np.nan),
        attributes=pa.table(attributes or {"number": np.arange(len(outlines))}).take(order),
        first_edge=np.ones(len(outlines), np.int32),
        reason=np.full(len(outlines), "", dtype=object),
    )


def lot_map(seed: int, num_blocks: int = 6, side: float = 220.0) -> LotMap:
    """Blocks of a Voronoi diagram with streets of 8 to 20 m between them, each cut into about eight lots."""
    rng = np.random.default_rng(seed)
    sites = rng.uniform(0.0, side, (num_blocks, 2))
    box = shapely.box(0.0, 0.0, side, side)
    cells = shapely.get_parts(shapely.voronoi_polygons(shapely.multipoints(sites), extend_to=box))
    cells = np.array([cell for cell in shapely.intersection(cells, box) if cell.area > 400.0], dtype=object)
    lines: list[shapely.LineString] = []
    widths: list[float] = []
    blocks = list(cells)
    for one in range(len(cells)):
        for other in range(one):
            shared = shapely.intersection(cells[one], cells[other])
            if shared.length > 1.0:
                width = float(rng.choice([8.0, 12.0, 20.0]))
                lines.append(shared)
                widths.append(width)
                street = shapely.buffer(shared, width / 2.0, cap_style="square")
                blocks[one], blocks[other] = (shapely.difference(blocks[row], street) for row in (one, other))
    pieces = [piece for block in blocks for piece in _cut(block, rng, 3)]
    outlines = [piece for piece in pieces if isinstance(piece, shapely.Polygon) and piece.area > 5.0]
    return LotMap(
        parcels_of(outlines, use=rng.choice(["shop", "home"], len(outlines)).astype(object)),
        StreetLines(np.array(lines, dtype=object), np.array(widths)),
    )


def _cut(block: BaseGeometry, rng: np.random.Generator, depth: int) -> Outlines:
    """Parts of a block by random lines across its longer side."""
    if depth == 0 or block.area < 200.0:
        return shapely.get_parts(block)
    box = shapely.get_coordinates(shapely.oriented_envelope(block))
    if np.hypot(*(box[1] - box[0])) < np.hypot(*(box[2] - box[1])):
        box = np.roll(box[:4], -1, axis=0)
    share = rng.uniform(0.35, 0.65, 2)
    ends = np.stack([box[0] + share[0] * (box[1] - box[0]), box[3] + share[1] * (box[2] - box[3])])
    along = ends[1] - ends[0]
    across = np.array([along[1], -along[0]]) * 10.0
    half = shapely.Polygon([ends[0] - along, ends[1] + along, ends[1] + along + across, ends[0] - along + across])
    return np.concatenate(
        [
            _cut(part, rng, depth - 1)
            for whole in (shapely.intersection(block, half), shapely.difference(block, half))
            for part in shapely.get_parts(whole)
            if isinstance(part, shapely.Polygon)
        ]
    )
