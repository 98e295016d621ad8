"""A small city on a hillside, at an unknown place."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import rasterio
from rasterio.transform import Affine

from grammarlab.arrays import Floats
from tests.runs.city.plans import boxes, write_plan

GARDEN_RULES = """
@StartRule
Lot --> split(x) { ~2 : extrude(7) House. | ~1 : Garden. }
"""


def slope(east: Floats, north: Floats) -> Floats:
    """Heights that are exact in a raster, which is linear between its pixels."""
    return 40.0 + 0.15 * east - 0.1 * north


def write_terrain(path: Path, height: Callable[[Floats, Floats], Floats] = slope) -> Path:
    """Heights as GeoTIFF around the small city, in metres at an unknown place."""
    east, north = np.meshgrid(np.arange(-197.5, 400, 5), np.arange(397.5, -200, -5))
    values = height(east, north) + 0.0 * east
    with rasterio.open(
        path,
        "w",
        driver="GTiff",
        width=east.shape[1],
        height=east.shape[0],
        count=1,
        dtype="float64",
        transform=Affine(5.0, 0.0, -200.0, 0.0, -5.0, 400.0),
    ) as file:
        file.write(values, 1)
    return path


def write_hill_plan(folder: Path, height: Callable[[Floats, Floats], Floats] = slope, rules: str = "") -> Path:
    """The small plan with a terrain, and with other rules if there are any."""
    plan = write_plan(folder, boxes())
    write_terrain(folder / "ground.tif", height)
    plan.write_text('terrain = "ground.tif"\n' + plan.read_text())
    if rules:
        (folder / "chance.cga").write_text(rules)
    return plan
