"""Surveys: the parcels of a plan with what is built on them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray

from grammarlab.arrays import Floats
from grammarlab.city.parcel_addresses import Pins, read_pins
from grammarlab.city.layout import laid_out
from grammarlab.city.parcel_map import read_parcels
from grammarlab.city.parcels import Outlines, Parcels
from grammarlab.city.plan import Plan
from grammarlab.city.site_making import sites_of
from grammarlab.city.sites import Sites
from grammarlab.city.street_lines import StreetLines, read_streets
from grammarlab.city.terrain import Terrain
from grammarlab.geometry.footprints.footprint import Remark


@dataclass(frozen=True, eq=False, kw_only=True)
class Survey:
    """All parcels of a plan."""

    plan: Plan
    parcels: Parcels
    streets: StreetLines | None
    """None if nothing is known of streets."""
    sites: Sites
    reason: NDArray[np.object_]
    """[N] why a parcel stays empty; empty for those with a site."""
    terrain: Terrain | None
    """None for flat ground."""
    remarks: tuple[Remark, ...]
    """What was repaired, left out or doubtful in the map."""

    def heights(self, points: Floats) -> Floats:
        """[n] height of the ground in metres at points [n, 2], east and north in metres; 0 outside the terrain."""
        return np.zeros(len(points)) if self.terrain is None else np.nan_to_num(self.terrain.heights(points))


def surveyed(plan: Plan) -> Survey:
    """The survey of a plan: its map is read or made, and every parcel has a site or a reason.

    Raises:
        GrammarlabError: If a file of the plan cannot be used.
    """
    remarks: tuple[Remark, ...] = ()
    if plan.layout is not None:
        layout = laid_out(plan.layout.request())
        parcels, streets = layout.parcels, layout.streets
    else:
        parcel_map = read_parcels(plan.parcels, crs=plan.crs, id_field=plan.id_field)
        parcels, remarks = parcel_map.parcels, parcel_map.remarks
        streets = None if plan.streets is None else read_streets(plan.streets, parcels.frame)
    terrain = None if plan.terrain is None else Terrain.open(plan.terrain, parcels.frame)
    pins = read_pins(plan.pins) if plan.pins.is_file() else Pins()
    sites, reason = sites_of(plan, parcels, streets, terrain, pins)
    return Survey(
        plan=plan, parcels=parcels, streets=streets, sites=sites, reason=reason, terrain=terrain, remarks=remarks
    )


def lot_outlines(sites: Sites) -> Outlines:
    """[S] footprints as polygons with holes, x to the east and y to the north of the frame's origin, in metres."""
    footprints = sites.footprints
    corner = np.repeat(sites.corner, np.diff(footprints.offsets), axis=0)
    places = (footprints.points + corner)[:, [0, 2]] * (1.0, -1.0)
    rings = np.repeat(np.arange(len(sites)), np.diff(footprints.offsets) + 1)
    closing = np.insert(np.arange(len(places)), footprints.offsets[1:], footprints.offsets[:-1])
    outlines = shapely.polygons(shapely.linearrings(places[closing], indices=rings))
    # Doubled edges join holes to their outline; without them, holes are rings of their own.
    joined = ~shapely.is_valid(outlines)
    outlines[joined] = shapely.buffer(outlines[joined], 0.0)
    return outlines
