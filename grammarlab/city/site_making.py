"""Sites from parcels and a plan: zones, addresses, footprints and their ground, or why a parcel stays empty."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import Ints
from grammarlab.city.building_footprints import FootprintRequest
from grammarlab.city.fields import parcel_fields, points_inside
from grammarlab.city.foundations import foundations
from grammarlab.city.ground_heights import HeightField
from grammarlab.city.lot_fronts import LOT
from grammarlab.city.lot_survey import LotSurvey, surveyed_lots
from grammarlab.city.parcel_addresses import Pins, addresses
from grammarlab.city.parcels import Parcels
from grammarlab.city.plan import Plan
from grammarlab.city.plan_fields import PlanFields
from grammarlab.city.site_attributes import site_attributes
from grammarlab.city.sites import Sites
from grammarlab.city.street_lines import StreetLines
from grammarlab.city.zones import NO_ZONE, ZoneFields, ZoneSources, named_zones, zones_of
from grammarlab.errors import UsageError

if TYPE_CHECKING:
    from shapely.geometry.base import BaseGeometry

EXCLUDED, ZONELESS = "excluded", "zone"
"""Reasons: the parcel is excluded by a pin; no zone of the plan has it."""
NO_PINS = Pins()
_OWN_FIELDS = ("area", "aspect", "frontage", "street_width", "elevation")
"""Fields that win over columns of the map."""


@dataclass(frozen=True, eq=False, kw_only=True)
class SiteSources:
    """What a plan reads apart from parcels, streets, terrain and pins."""

    zones: ZoneSources = field(default_factory=ZoneSources)
    near: Mapping[str, BaseGeometry] = field(default_factory=dict)
    """Shapes in metres of the frame, by the names of fields that are distances."""
    rasters: Mapping[str, HeightField] = field(default_factory=dict)
    """Rasters, by the names of fields."""
    parks: Collection[str] = ()
    """Names of zones whose grammar is a species."""
    start_rules: Mapping[str, Collection[str]] = field(default_factory=dict)
    """Names of all rules of the grammar of a zone, by the name of the zone."""


NO_SOURCES = SiteSources()


def sites_of(
    plan: Plan,
    parcels: Parcels,
    streets: StreetLines | None = None,
    terrain: HeightField | None = None,
    pins: Pins = NO_PINS,
    sources: SiteSources = NO_SOURCES,
) -> tuple[Sites, NDArray[np.object_]]:
    """What is built on parcels.

    A site depends on the seed, the id, outline, ground, attributes and pin of its parcel and on its streets; other
    parcels matter only where they touch it or lie between it and a street.

    Args:
        plan: the plan.
        parcels: N parcels.
        streets: lines of streets; None if they are unknown.
        terrain: heights of the ground; None for those of the parcels.
        pins: what is fixed about parcels.
        sources: what else the plan reads.

    Returns:
        The sites, and [N] the reason why a parcel has none; empty for those with a site.

    Raises:
        UsageError: If a condition or formula of the plan cannot be evaluated, or a pin has an unknown zone.
    """
    lots = surveyed_lots(plan, parcels, streets)
    reason = lots.reason.copy()
    fields = lot_fields(plan, parcels, lots, terrain, sources)
    address = addresses(parcels.id[lots.parcel], plan.seed, pins)
    pinned = named_zones(plan, np.where(address.is_excluded, "", address.zone))
    zone = np.where(pinned == NO_ZONE, zones_of(plan, fields, sources.zones), pinned)
    is_empty = np.select([address.is_excluded, zone == NO_ZONE], [EXCLUDED, ZONELESS], "").astype(object)
    reason[lots.parcel] = is_empty
    used = np.flatnonzero(is_empty == "")
    built = foundations(parcels, lots, used, _request(plan, zone[used], sources.parks), terrain)
    reason[lots.parcel[used]] = built.reason
    row = used[built.lot]
    sites = Sites(
        parcel=lots.parcel[row],
        zone=zone[row],
        seed=address.seed[row],
        model=address.model[row],
        reroll=address.reroll[row],
        corner=built.corner,
        plinth=built.ground.plinth,
        footprints=built.footprints,
        attributes=site_attributes(plan, zone[row], fields.plan, row, built.ground),
        start_rule=_start_rules(plan, zone[row], built.kind, sources),
    )
    return sites, reason


def lot_fields(
    plan: Plan, parcels: Parcels, lots: LotSurvey, terrain: HeightField | None, sources: SiteSources = NO_SOURCES
) -> ZoneFields:
    """Fields of lots [S], for conditions, formulas and learned zones.

    Raises:
        UsageError: If the plan names a field whose file was not read.
    """
    chosen = parcels.take(lots.parcel)
    rasters = {source.name: sources.rasters.get(source.name) for source in plan.fields if source.raster is not None}
    near = {source.name: sources.near.get(source.name) for source in plan.fields if source.distance is not None}
    missing = [name for name, value in (rasters | near).items() if value is None]
    if missing:
        raise UsageError(f"{plan.path}: expected the file of the field {missing[0]}, found none")
    inside = points_inside(chosen.outlines)
    if terrain is not None:
        chosen = replace(chosen, elevation=np.asarray(terrain.heights(inside), np.float64))
    needed = {feature.name for density in sources.zones.densities.values() for feature in density.features}
    learned = parcel_fields(
        chosen,
        frontage=lots.frontage,
        street_width=lots.widest_street,
        near={name: shape for name, shape in near.items() if shape is not None},
        rasters={name: np.asarray(raster.heights(inside), np.float64) for name, raster in rasters.items() if raster},
        attributes=[
            name for name in chosen.attributes.column_names if name in needed - {*_OWN_FIELDS, *near, *rasters}
        ],
    )
    numbers = {"elevation": chosen.elevation} | dict(zip(learned.name, learned.values.T, strict=True))
    return ZoneFields(plan=PlanFields(chosen.attributes, numbers), learned=learned)


def _request(plan: Plan, zone: Ints, parks: Collection[str]) -> FootprintRequest:
    """What is built in the zones [S] of lots."""
    is_park = np.array([entry.name in parks for entry in plan.zones], np.bool_)
    rules = [
        entry.footprint or ("parcel" if park else "setback") for entry, park in zip(plan.zones, is_park, strict=True)
    ]
    setbacks = np.zeros((len(plan.zones), 3))
    for number, (entry, rule) in enumerate(zip(plan.zones, rules, strict=True)):
        chosen = entry.setbacks or plan.lots.setbacks
        if rule != "parcel":
            setbacks[number] = chosen.front, chosen.side, chosen.back
    is_ring = np.array([rule == "ring" for rule in rules], np.bool_)
    return FootprintRequest(setbacks=setbacks[zone], is_ring=is_ring[zone], is_park=is_park[zone], rules=plan.lots)


def _start_rules(plan: Plan, zone: Ints, kind: NDArray[np.object_], sources: SiteSources) -> NDArray[np.object_]:
    """[S] start rules: that of the zone, else the one for the kind of lot, else ``Lot``; empty if there are none."""
    start = np.full(len(zone), "", object)
    for number, entry in enumerate(plan.zones):
        is_here = zone == number
        rules = sources.start_rules.get(entry.name, ())
        if entry.start:
            start[is_here] = entry.start
        else:
            start[is_here & np.isin(kind, list(rules))] = kind[is_here & np.isin(kind, list(rules))]
            start[is_here & (start == "")] = LOT if LOT in rules else ""
    return start
