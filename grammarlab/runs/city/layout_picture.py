"""Plans of layouts: parcels and parks between streets, seen from above, north up."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import shapely
from numpy.typing import NDArray
from PIL import Image, ImageDraw

from grammarlab.arrays import Floats
from grammarlab.city.city_layout import Layout
from grammarlab.city.layout_file import write_parcels, write_streets
from grammarlab.city.plan import read_plan
from grammarlab.errors import UsageError
from grammarlab.files import atomic_file
from grammarlab.runs.city.survey import layout_of
from grammarlab.runs.sample.contact_sheet import PAPER

_LONG_SIDE = 1600
"""Pixels of the longer side of the picture."""
_MARGIN = 16
"""Pixels around the plan."""
_SCALE = 2
"""Pixels that are drawn for each pixel of the picture, along a side: edges are smooth."""
_STREET, _PARK, _LOT, _EDGE = (208, 206, 200), (178, 206, 158), (247, 243, 230), (120, 110, 96)


def write_layout(plan: Path, parcels: Path, *, streets: Path | None = None, picture: Path | None = None) -> Layout:
    """Write the layout of a plan as files.

    Args:
        plan: file of the plan, with a table ``[layout]``.
        parcels: GeoJSON of the parcels.
        streets: GeoJSON of the streets; None for none.
        picture: PNG of the plan; None for none.

    Returns:
        The layout.

    Raises:
        GrammarlabError: If the plan has no layout, or it cannot be made.
    """
    read = read_plan(plan)
    if read.layout is None:
        raise UsageError(f"{plan}: expected a table [layout]; this plan reads its parcels from {read.parcels}.")
    layout = layout_of(read.layout, read.crs)
    write_parcels(layout, parcels)
    if streets is not None:
        write_streets(layout, streets)
    if picture is not None:
        with atomic_file(picture) as part:
            Image.fromarray(draw_layout(layout)).save(part, "PNG")
    return layout


def draw_layout(layout: Layout) -> NDArray[np.uint8]:
    """Picture [height, width, 3] of a layout."""
    margins = layout.streets.width[:, None] / 2 * (-1, -1, 1, 1)
    bounds = np.concatenate([shapely.bounds(layout.blocks.outline), shapely.bounds(layout.streets.line) + margins])
    (low_x, low_y), (high_x, high_y) = bounds[:, :2].min(axis=0).tolist(), bounds[:, 2:].max(axis=0).tolist()
    scale = _SCALE * _LONG_SIDE / max(high_x - low_x, high_y - low_y)
    margin = _SCALE * _MARGIN
    size = (int((high_x - low_x) * scale) + 2 * margin, int((high_y - low_y) * scale) + 2 * margin)
    page = Image.new("RGB", size, PAPER)
    draw = ImageDraw.Draw(page)

    def pixels(line: shapely.LineString) -> list[tuple[float, float]]:
        east_north: Floats = shapely.get_coordinates(line)
        x, y = (east_north - (low_x, high_y)).T * scale * np.array([[1.0], [-1.0]]) + margin
        return list(zip(x.tolist(), y.tolist(), strict=True))

    def fill(polygons: NDArray[np.object_], colour: tuple[int, int, int]) -> None:
        for polygon in polygons:
            corners = pixels(polygon.exterior)
            draw.polygon(corners, fill=colour)
            draw.line(corners, _EDGE, _SCALE)

    for line, width in zip(layout.streets.line, layout.streets.width.tolist(), strict=True):
        points = pixels(line)
        if points[0] == points[-1]:
            points.append(points[1])
        draw.line(points, _STREET, max(round(width * scale), 1), joint="curve")
    is_park = np.array(layout.parcels.attributes["use"].to_pylist(), dtype=object) == "park"
    fill(layout.parcels.outline[is_park], _PARK)
    fill(layout.parcels.outline[~is_park], _LOT)
    return np.asarray(page.resize((size[0] // _SCALE, size[1] // _SCALE), Image.Resampling.BOX))
