"""Zones of parcels: each parcel is in the first zone of the plan whose conditions it meets."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import shapely

from grammarlab.arrays import Flags, Floats, Ints
from grammarlab.city.fields import ParcelFields
from grammarlab.city.plan import Plan, ZonePlan
from grammarlab.city.plan_fields import PlanFields
from grammarlab.city.polygon_text import is_polygon_text, polygon_of_text
from grammarlab.city.zone_density import ZoneDensity
from grammarlab.city.zone_draws import drawn_zones
from grammarlab.errors import UsageError, shown
from grammarlab.geometry.footprints.frame import Frame

if TYPE_CHECKING:
    from shapely.geometry.base import BaseGeometry

NO_ZONE = -1


@dataclass(frozen=True, eq=False, kw_only=True)
class ZoneSources:
    """What the conditions of zones read from files."""

    areas: Mapping[str, BaseGeometry] = field(default_factory=dict)
    """Polygons in metres of the frame, by the names of zones whose polygon is in a file."""
    densities: Mapping[Path, ZoneDensity] = field(default_factory=dict)
    """Densities of zones by their files."""


@dataclass(frozen=True, eq=False, kw_only=True)
class ZoneFields:
    """What the conditions of zones read of N parcels."""

    plan: PlanFields
    """[N] fields in natural units, for conditions and formulas."""
    learned: ParcelFields
    """[N] standard fields, for densities; with a point inside each parcel."""


def zones_of(plan: Plan, fields: ZoneFields, sources: ZoneSources) -> Ints:
    """[N] number of the zone of each parcel in the plan, or `NO_ZONE`.

    Raises:
        UsageError: If a condition cannot be evaluated; it names the zone.
    """
    zones = np.full(len(fields.learned), NO_ZONE, np.int64)
    drawn = _Draws(plan, fields.learned, sources)
    for number, zone in enumerate(plan.zones):
        try:
            meets = _meets(zone, fields, sources, drawn)
        except UsageError as error:
            raise UsageError(f"{plan.path}: zone {zone.name!r}: {error}") from error
        zones[(zones == NO_ZONE) & meets] = number
    return zones


def named_zones(plan: Plan, names: np.ndarray) -> Ints:
    """[N] numbers of zones by their names, `NO_ZONE` for empty names.

    Raises:
        UsageError: If a zone is unknown.
    """
    numbers = {zone.name: number for number, zone in enumerate(plan.zones)} | {"": NO_ZONE}
    unknown = sorted(set(names.tolist()) - set(numbers))
    if unknown:
        known = ", ".join(zone.name for zone in plan.zones)
        raise UsageError(f"{plan.pins}: unknown zone {shown(unknown[0])}; the plan has {known}")
    return np.array([numbers[name] for name in names.tolist()], np.int64)


class _Draws:
    """Zones drawn from densities, each once."""

    def __init__(self, plan: Plan, fields: ParcelFields, sources: ZoneSources) -> None:
        self._plan = plan
        self._fields = fields
        self._sources = sources
        self._drawn: dict[Path, np.ndarray] = {}

    def of(self, path: Path, zone: str) -> Flags:
        """[N] whether a zone is drawn."""
        density = self._sources.densities.get(path)
        if density is None:
            raise UsageError(f"expected the learned zones of {path}, found none")
        if zone not in density.zones:
            raise UsageError(f"{path} has no such zone; it has {', '.join(density.zones)}")
        if path not in self._drawn:
            self._drawn[path] = drawn_zones(density, self._fields, self._plan.seed)
        return self._drawn[path] == density.zones.index(zone)


def _meets(zone: ZonePlan, fields: ZoneFields, sources: ZoneSources, drawn: _Draws) -> Flags:
    """[N] whether parcels meet all conditions of a zone."""
    meets = np.ones(len(fields.learned), np.bool_)
    for name, values in zone.match.items():
        meets &= np.logical_or.reduce([fields.plan.equal(name, value) for value in values])
    if zone.where:
        meets &= fields.plan.holds(zone.where)
    if zone.polygon:
        meets &= _inside(_area(zone, fields.learned.frame, sources), fields.learned.east_north)
    if zone.density is not None:
        meets &= drawn.of(zone.density, zone.name)
    return meets


def _inside(area: BaseGeometry, east_north: Floats) -> Flags:
    shapely.prepare(area)
    return np.asarray(shapely.intersects_xy(area, east_north), dtype=np.bool_)


def _area(zone: ZonePlan, frame: Frame, sources: ZoneSources) -> BaseGeometry:
    """The polygon of a zone in metres of the frame."""
    if zone.name in sources.areas:
        return sources.areas[zone.name]
    if not is_polygon_text(zone.polygon):
        raise UsageError(f"expected the polygon of {zone.polygon}, found none")
    return polygon_of_text(zone.polygon, frame)
