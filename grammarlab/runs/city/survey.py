"""Surveys: the parcels of a plan with what is built on them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import shapely
from numpy.typing import NDArray

from grammarlab.arrays import Floats
from grammarlab.city.city_layout import Layout, laid_out
from grammarlab.city.fields import points_inside
from grammarlab.city.layout_plan import LayoutPlan
from grammarlab.city.map_shapes import read_shapes, read_streets
from grammarlab.city.packed_outlines import Outlines
from grammarlab.city.parcel_addresses import read_pins
from grammarlab.city.parcel_map import read_parcels
from grammarlab.city.parcels import Parcels
from grammarlab.city.plan import Plan
from grammarlab.city.polygon_text import is_polygon_text
from grammarlab.city.site_making import SiteSources, sites_of
from grammarlab.city.sites import Sites
from grammarlab.city.street_lines import StreetLines
from grammarlab.city.terrain import Terrain, read_terrain
from grammarlab.city.unknown_pins import unknown_pins
from grammarlab.city.zone_file import read_zones
from grammarlab.city.zones import ZoneSources
from grammarlab.errors import UsageError
from grammarlab.geometry.footprints.coordinates import UNPLACED
from grammarlab.geometry.footprints.footprint import Remark
from grammarlab.geometry.footprints.frame import Frame
from grammarlab.runs.city.zone_rules import ZoneRules


@dataclass(frozen=True, slots=True)
class PlacedTerrain:
    """A terrain under the metres of a frame."""

    terrain: Terrain
    frame: Frame

    @classmethod
    def read(cls, path: Path, frame: Frame) -> PlacedTerrain:
        """The terrain of a file; one that names no coordinate system has that of a frame at an unknown place.

        Raises:
            AssetError: If it cannot be read.
            UsageError: If the extra ``city`` is missing.
        """
        return cls(read_terrain(path, default_crs=None if frame.has_place else UNPLACED), frame)

    def heights(self, east_north: Floats, /) -> Floats:
        """[n] height in metres at points [n, 2] in metres from the frame's origin; NaN outside."""
        return self.terrain.heights(self.frame, east_north)


@dataclass(frozen=True, eq=False, kw_only=True)
class Ground:
    """What a plan is about: its parcels, streets and terrain."""

    parcels: Parcels
    streets: StreetLines | None
    """None if nothing is known of streets."""
    terrain: PlacedTerrain | None
    """None for flat ground."""
    remarks: tuple[Remark, ...]
    """What was repaired, left out or doubtful in the map."""


@dataclass(frozen=True, eq=False, kw_only=True)
class Survey:
    """All parcels of a plan with what is built on them."""

    plan: Plan
    ground: Ground
    sites: Sites
    reason: NDArray[np.object_]
    """[N] why a parcel stays empty; empty for those with a site."""
    remarks: tuple[Remark, ...]
    """What was doubtful in the map, the pins and the rules of zones."""

    @property
    def parcels(self) -> Parcels:
        """[N] parcels, ordered by id."""
        return self.ground.parcels

    def without_buildings(self, is_park: Sequence[bool]) -> Survey:
        """The same with only the sites of parks, and without attributes of parcels: what trees and tables need.

        Args:
            is_park: whether each zone of the plan is a park.
        """
        sites = self.sites.take(np.flatnonzero(np.array(is_park, np.bool_)[self.sites.zone]))
        parcels = replace(self.parcels, attributes=self.parcels.attributes.select([]))
        return replace(self, ground=replace(self.ground, parcels=parcels), sites=sites)

    def heights(self, points: Floats) -> Floats:
        """[n] height of the ground in metres at points [n, 2], east and north in metres.

        Without a terrain it is that of the nearest parcel of a 3D map; where neither is known, it is 0.
        """
        if self.ground.terrain is not None:
            return np.nan_to_num(self.ground.terrain.heights(points))
        known = np.flatnonzero(~np.isnan(self.parcels.elevation))
        if not len(known):
            return np.zeros(len(points))
        nearest = shapely.STRtree(self.parcels.outline[known]).nearest(shapely.points(points))
        return self.parcels.elevation[known[nearest]]


def ground_of(plan: Plan) -> Ground:
    """The ground of a plan: its map is read, or made.

    Raises:
        GrammarlabError: If a file of the plan cannot be used.
    """
    if plan.layout is not None:
        layout = layout_of(plan.layout, plan.crs)
        terrain = _terrain(plan, layout.parcels)
        remarks = tuple(_outside(layout.parcels, terrain))
        return Ground(parcels=layout.parcels, streets=layout.streets, terrain=terrain, remarks=remarks)
    if plan.parcels is None:
        raise UsageError(f"{plan.path}: expected parcels or [layout]")
    read = read_parcels(plan.parcels, crs=plan.crs, id_field=plan.id_field)
    frame, terrain = read.parcels.frame, _terrain(plan, read.parcels)
    return Ground(
        parcels=read.parcels,
        streets=None if plan.streets is None else read_streets(plan.streets, frame),
        terrain=terrain,
        remarks=(*read.remarks, *_outside(read.parcels, terrain)),
    )


def layout_of(plan: LayoutPlan, crs: str | None) -> Layout:
    """Streets, blocks and parcels of a layout.

    Args:
        plan: the layout of a plan.
        crs: coordinate system of the file of its outline, instead of the file's.

    Raises:
        GrammarlabError: If the outline cannot be used.
    """
    if plan.outline is None:
        return laid_out(plan.request())
    area = read_parcels(plan.outline, crs=crs).parcels
    outline = shapely.union_all(area.outline[area.usable])
    if not isinstance(outline, shapely.Polygon | shapely.MultiPolygon):
        raise UsageError(f"{plan.outline}: expected the outline of an area, found {outline.geom_type}.")
    return laid_out(plan.request(outline, area.frame))


def _terrain(plan: Plan, parcels: Parcels) -> PlacedTerrain | None:
    return None if plan.terrain is None else PlacedTerrain.read(plan.terrain, parcels.frame)


def _outside(parcels: Parcels, terrain: PlacedTerrain | None) -> Iterator[Remark]:
    """A remark about parcels whose terrain is unknown, if there are any."""
    if terrain is not None:
        inside = points_inside(parcels.outlines.take(np.flatnonzero(parcels.usable)))
        num_unknown = int(np.isnan(terrain.heights(inside)).sum())
        if num_unknown:
            reason = f"it has no height for {num_unknown:,} of {len(inside):,} parcels: their ground is at 0 m"
            yield Remark(str(terrain.terrain.path), "coordinates", reason)


def surveyed(plan: Plan, zones: Sequence[ZoneRules]) -> Survey:
    """The survey of a plan: every parcel has a site or a reason.

    Args:
        plan: the plan.
        zones: rules of its zones.

    Raises:
        GrammarlabError: If a file of the plan cannot be used.
    """
    ground = ground_of(plan)
    pins = read_pins(plan.pins)
    sources = site_sources(plan, zones, ground.parcels.frame)
    sites, reason = sites_of(plan, ground.parcels, ground.streets, ground.terrain, pins, sources)
    of_rules = (remark for rules in zones for remark in rules.remarks())
    remarks = (*ground.remarks, *unknown_pins(pins, ground.parcels.id, plan.pins), *of_rules)
    return Survey(plan=plan, ground=ground, sites=sites, reason=reason, remarks=remarks)


def site_sources(plan: Plan, zones: Sequence[ZoneRules], frame: Frame) -> SiteSources:
    """The files that conditions and fields of a plan read.

    Args:
        plan: the plan.
        zones: rules of its zones; none where they are not known yet, as for the answers to learn from.
        frame: frame of the parcels.

    Raises:
        GrammarlabError: If one cannot be used.
    """
    areas = {
        zone.name: shapely.union_all(read_shapes(Path(zone.polygon), frame).geometry)
        for zone in plan.zones
        if zone.polygon and not is_polygon_text(zone.polygon)
    }
    densities = {zone.density: read_zones(zone.density) for zone in plan.zones if zone.density is not None}
    return SiteSources(
        zones=ZoneSources(areas=areas, densities=densities),
        near={
            source.name: shapely.union_all(read_shapes(source.distance, frame).geometry)
            for source in plan.fields
            if source.distance is not None
        },
        rasters={
            source.name: PlacedTerrain.read(source.raster, frame) for source in plan.fields if source.raster is not None
        },
        parks=[rules.zone for rules in zones if rules.is_park],
        start_rules={rules.zone: rules.rule_names() for rules in zones},
    )


def lot_outlines(sites: Sites) -> Outlines:
    """[S] footprints as polygons with holes, x to the east and y to the north of the frame's origin, in metres."""
    footprints = sites.footprints
    corner = np.repeat(sites.corner, np.diff(footprints.offsets), axis=0)
    places = (footprints.points + corner)[:, [0, 2]] * (1.0, -1.0)
    rings = np.repeat(np.arange(len(sites)), np.diff(footprints.offsets) + 1)
    closing = np.insert(np.arange(len(places)), footprints.offsets[1:], footprints.offsets[:-1])
    outlines = np.array(shapely.polygons(shapely.linearrings(places[closing], indices=rings)), dtype=object)
    # Doubled edges join holes to their outline; without them, holes are rings of their own.
    joined = ~shapely.is_valid(outlines)
    outlines[joined] = shapely.buffer(outlines[joined], 0.0)
    return outlines
