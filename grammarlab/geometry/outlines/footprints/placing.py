"""Outlines of a source as footprints: checked, repaired, in metres, and placed relative to each other."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import shapely

from grammarlab.errors import AssetError
from grammarlab.geometry.outlines.footprints.corners import corners_of
from grammarlab.geometry.outlines.footprints.footprint import Footprint, FootprintMap, Georeference, Remark
from grammarlab.geometry.outlines.footprints.ground import Ground, centres_of
from grammarlab.geometry.outlines.footprints.source import Outline, Source
from grammarlab.geometry.outlines.footprints.validity import (
    BadOutlineError,
    checked,
    measured,
    position,
    repaired,
)

_CROSSING = "Draw the ring without crossing itself."
MOST_REASONS = 8
"""Largest number of reasons in a message."""
_WIDEST_DEGREES = 0.05
"""Width of an outline below which metres are taken for degrees: 5 cm, or about 5 km."""


def placed(source: Source) -> FootprintMap:
    """Footprints of the outlines of a source.

    Raises:
        AssetError: If there are none, if a strict source has a bad one, or if all coordinates contradict the CRS.
    """
    valid, remarks = _valid(source)
    _check_unit(source, valid)
    georeference = Georeference(source.crs.name) if source.crs.name else None
    plans = [outline.polygon for outline in valid]
    if source.crs.unit == "degrees" and valid:
        ground = Ground.around(centres_of(plans))
        plans = ground.metres(plans)
        georeference = Georeference(source.crs.name, ground.longitude, ground.latitude)
    footprints = []
    for outline, plan in zip(valid, plans, strict=True):
        try:
            corners = corners_of(measured(plan))
        except BadOutlineError as error:
            remarks.append(_bad(source, outline, error))
            continue
        footprints.append(Footprint(corners, outline.properties, outline.name, outline.unread))
    remarks = [*source.remarks, *remarks]
    if not footprints:
        raise _nothing(source, remarks)
    return FootprintMap(tuple(footprints), georeference, tuple(remarks))


def _valid(source: Source) -> tuple[list[Outline], list[Remark]]:
    """Valid outlines in the coordinates of a source, and remarks about all others."""
    outlines: list[Outline] = []
    remarks: list[Remark] = []
    for outline in source.outlines:
        try:
            polygon = checked(outline.polygon, source.crs.unit)
            parts, fault = repaired(polygon, source.crs.unit)
        except BadOutlineError as error:
            remarks.append(_bad(source, outline, error))
            continue
        if fault and source.strict:
            raise AssetError(f"{outline.name}: {fault}. {_CROSSING}")
        if fault:
            pieces = "" if len(parts) == 1 else f", in {len(parts)} pieces"
            remarks.append(Remark(outline.name, "repair", f"{fault}{pieces}"))
        outlines += [replace(outline, polygon=part) for part in parts]
    return outlines, remarks


def _bad(source: Source, outline: Outline, error: BadOutlineError) -> Remark:
    """The remark about a bad outline; an error if its source is strict."""
    if source.strict:
        raise AssetError(f"{outline.name}: {error}. {_advice(source, str(error))}".rstrip())
    reason = str(error)
    if not (error.has_position or outline.polygon.is_empty):
        x, y = shapely.get_coordinates(outline.polygon)[0].tolist()
        reason = f"{reason} (at {position(x, y, source.crs.unit)})"
    return Remark(outline.name, "outline", reason)


def _check_unit(source: Source, outlines: Sequence[Outline]) -> None:
    """Refuse metres that are degrees.

    Raises:
        AssetError: If all coordinates can be degrees, and all outlines are only centimetres wide.
    """
    if source.crs.unit != "metres" or not outlines:
        return
    bounds = shapely.bounds(np.array([outline.polygon for outline in outlines], dtype=object))
    low, high = bounds[:, :2], bounds[:, 2:]
    if (
        (high - low).max() >= _WIDEST_DEGREES
        or np.abs(bounds).max(axis=0).max() > 180.0
        or np.abs(bounds[:, 1::2]).max() > 90
    ):
        return
    (west, south), (east, north) = low.min(axis=0).tolist(), high.max(axis=0).tolist()
    system = f"its CRS {source.crs.name} counts in metres" if source.crs.name else "it counts in metres"
    fix = (
        "write SRID=4326; before it"
        if source.strict
        else 'leave out the member "crs", or name a CRS in degrees there, such as "EPSG:4326"'
    )
    raise AssetError(
        f"{source.name}: too small to build on: {system}, and x is from {west:.10g} to {east:.10g} and y from "
        f"{south:.10g} to {north:.10g}. If these are degrees of longitude and latitude, {fix}."
    )


def _nothing(source: Source, remarks: Sequence[Remark]) -> AssetError:
    reasons = "".join(f"\n  {remark}" for remark in remarks[:MOST_REASONS])
    if len(remarks) > MOST_REASONS:
        reasons += f"\n  … and {len(remarks) - MOST_REASONS:,} more"
    if not source.outlines and not any(remark.kind == "outline" for remark in remarks):
        message = f"{source.name}: no Polygon or MultiPolygon in this file." if not source.strict else remarks[0]
        return AssetError(f"{message}{reasons if not source.strict else ''}")
    advice = _advice(source, reasons)
    return AssetError(f"{source.name}: no outline can be used.{reasons}" + (f"\n{advice}" if advice else ""))


def _advice(source: Source, reasons: str) -> str:
    """What to try for some reasons."""
    if (
        source.crs.unit == "degrees"
        and ("in degrees" in reasons or "metres; a footprint" in reasons)
        and not source.strict
    ):
        return (
            "GeoJSON counts in degrees. If yours counts in metres, name its CRS at the top of the file, "
            '"crs": {"type": "name", "properties": {"name": "EPSG:25832"}}, or write "crs": null there.'
        )
    if "intersection" in reasons:
        return _CROSSING
    return ""
