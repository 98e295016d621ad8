"""Foundations: footprints of buildings with their ground, made from a few lots at a time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np
import shapely
from numpy.typing import NDArray

from grammarlab.arrays import Floats, Ints, offsets_from_counts
from grammarlab.city.building_footprints import FootprintRequest, building_footprints, joined_rings
from grammarlab.city.ground_heights import GroundHeights, HeightField, ground_heights
from grammarlab.city.lot_edges import LotEdges
from grammarlab.city.lot_fronts import lot_kinds
from grammarlab.city.lot_survey import LotSurvey
from grammarlab.city.packed_outlines import row_blocks
from grammarlab.city.parcels import Parcels
from grammarlab.derivation.lots import Footprints


@dataclass(frozen=True, eq=False, kw_only=True)
class Foundations:
    """Foundations on S lots, or why there are none."""

    reason: NDArray[np.object_]
    """[S] empty for lots with a foundation."""
    lot: Ints
    """[K] the lots with a foundation, ascending."""
    ground: GroundHeights
    """[K] heights of the ground."""
    corner: Floats
    """[K, 3] origins of the footprints in the world: x and z in whole metres from the frame's origin, y the height of
    the ground at the front."""
    footprints: Footprints
    """K footprints in metres from their corners, with the widths of the streets along their edges."""
    kind: NDArray[np.object_]
    """[K] start rules of CGA that fit the lots (`grammarlab.city.lot_fronts.lot_kinds`)."""


def foundations(
    parcels: Parcels, lots: LotSurvey, rows: Ints, request: FootprintRequest, terrain: HeightField | None
) -> Foundations:
    """Foundations on some lots.

    Args:
        parcels: all parcels.
        lots: lots among them.
        rows: [S] rows of the lots to build on.
        request: what is built on these.
        terrain: heights of the ground; None for those of the parcels.
    """
    blocks = list(row_blocks(len(rows)))
    parts = [_of_block(parcels, lots, rows[block], request.take(block), terrain) for block in blocks]
    return Foundations(
        reason=np.concatenate([np.zeros(0, object), *(part.reason for part in parts)]),
        lot=np.concatenate(
            [np.zeros(0, np.int64), *(block[part.lot] for block, part in zip(blocks, parts, strict=True))]
        ),
        ground=_joined_heights([part.ground for part in parts]),
        corner=np.concatenate([np.zeros((0, 3)), *(part.corner for part in parts)]),
        footprints=_joined_footprints([part.footprints for part in parts]),
        kind=np.concatenate([np.zeros(0, object), *(part.kind for part in parts)]),
    )


def _of_block(
    parcels: Parcels, lots: LotSurvey, rows: Ints, request: FootprintRequest, terrain: HeightField | None
) -> Foundations:
    """Foundations on a few lots; see `foundations`."""
    edges, corners = lots.edges.take(rows)
    built = building_footprints(edges, lots.street_width[corners], request)
    parcel = lots.parcel[rows[built.lot]]
    ground = ground_heights(built.edges, parcels.elevation[parcel], terrain)
    corner = _corners(parcels, parcel, ground.base)
    return Foundations(
        reason=built.reason,
        lot=built.lot,
        ground=ground,
        corner=corner,
        footprints=_footprints(built.edges, built.street_width, corner),
        kind=lot_kinds(built.edges, built.street_width),
    )


def _corners(parcels: Parcels, parcel: Ints, base: Floats) -> Floats:
    """[K, 3] origins of footprints: the south-west corner of the box around the parcel, in whole metres."""
    west_south = np.round(shapely.bounds(parcels.outlines[parcel]).reshape(-1, 4)[:, :2])
    return np.column_stack([west_south[:, 0], base, -west_south[:, 1]]) + 0.0


def _footprints(edges: LotEdges, widths: Floats, corner: Floats) -> Footprints:
    cycle, cycle_widths, offsets = joined_rings(edges, widths)
    east, north = edges.points[cycle].T
    origin = corner[edges.outline[cycle]]
    points = np.column_stack([east - origin[:, 0], np.zeros(len(cycle)), -north - origin[:, 2]])
    return Footprints(points, offsets, cycle_widths)


def _joined_heights(parts: Sequence[GroundHeights]) -> GroundHeights:
    columns = {
        field.name: np.concatenate([np.zeros(0), *(getattr(part, field.name) for part in parts)])
        for field in fields(GroundHeights)
    }
    return GroundHeights(**columns)


def _joined_footprints(parts: Sequence[Footprints]) -> Footprints:
    widths = [part.street_width for part in parts if part.street_width is not None]
    return Footprints(
        np.concatenate([np.zeros((0, 3)), *(part.points for part in parts)]),
        offsets_from_counts(np.concatenate([np.zeros(0, np.int64), *(np.diff(part.offsets) for part in parts)])),
        np.concatenate([np.zeros(0), *widths]),
    )
