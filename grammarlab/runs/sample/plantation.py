"""Planting the trees of a run on the area of a text."""

from __future__ import annotations

from dataclasses import dataclass

import shapely

from grammarlab.arrays import Floats
from grammarlab.errors import UsageError
from grammarlab.geometry.footprints.area import Area, read_area
from grammarlab.geometry.footprints.footprint import Georeference, Remark
from grammarlab.runs.sample.stand import Stand
from grammarlab.trees.planting import Crowns, Spacing, planted


@dataclass(frozen=True, slots=True)
class Plantation:
    """A stand with what the map of its area says."""

    stand: Stand
    georeference: Georeference | None
    remarks: tuple[Remark, ...]


def planted_on(
    text: str, crowns: Crowns, seed: int, *, density: float | None = None, limit: int | None = None, gap: float = 0.0
) -> Plantation:
    """Trees on the area of a text.

    Args:
        text: the area, in the syntax of `read_footprints`.
        crowns: radii of the crowns of models under the seed.
        seed: seed of the run.
        density: trees per hectare; None for as many as the limit.
        limit: most trees.
        gap: metres between crowns; negative if they may reach into each other.

    Raises:
        UsageError: If a number is out of range, or no tree has its trunk inside the area.
        AssetError: If the area cannot be used.
    """
    area = read_area(text)
    planting = planted(area, Spacing(crowns, seed, gap), density=density, limit=limit)
    if len(planting) == 0:
        raise UsageError(
            f"no tree stands on the {area.size:,.3g} square metres of {text[:60]!r}: choose a larger area, a larger "
            "density, or another seed."
        )
    stand = Stand(
        model=planting.model,
        position=planting.position,
        radius=planting.radius,
        outlines=_outlines(area),
        size=area.size,
        density=planting.density,
        gap=gap,
        is_full=planting.is_full,
    )
    return Plantation(stand, area.georeference, area.remarks)


def _outlines(area: Area) -> tuple[tuple[Floats, ...], ...]:
    def ring(line: shapely.LinearRing) -> Floats:
        return shapely.get_coordinates(line)[:-1] * [1.0, -1.0] + 0.0

    return tuple((ring(polygon.exterior), *map(ring, polygon.interiors)) for polygon in area.outlines)
