"""Plans of layouts: parcels and parks between streets, seen from above, north up."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import shapely
from numpy.typing import NDArray
from PIL import Image, ImageDraw

from grammarlab.arrays import Floats
from grammarlab.city.city_layout import Layout
from grammarlab.files import atomic_file
from grammarlab.runs.sample.contact_sheet import PAPER

_LONG_SIDE = 1600
"""Pixels of the longer side of the picture."""
_MARGIN = 16
"""Pixels around the plan."""
_SCALE = 2
"""Pixels that are drawn for each pixel of the picture, along a side: edges are smooth."""
_STREET, _PARK, _LOT, _EDGE = (208, 206, 200), (178, 206, 158), (247, 243, 230), (120, 110, 96)


def write_layout_picture(layout: Layout, path: Path) -> None:
    """Write the picture of a layout as a PNG file.

    Raises:
        OSError: If the file cannot be written.
    """
    with atomic_file(path) as part:
        Image.fromarray(draw_layout(layout)).save(part, "PNG")


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
