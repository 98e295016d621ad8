"""A picture of a match: fitted templates in the colours of their kinds, under the points of all elements."""

from __future__ import annotations

import colorsys

import numpy as np
from PIL import Image, ImageDraw

from grammarlab.matching.match import SURE, Match, drawn_parameters
from grammarlab.matching.template import points_along

_MAX_SIDE_PIXELS = 2400
"""Largest side, pixels."""
_MAX_PIXELS_PER_M = 120.0
"""Largest resolution, pixels per metre."""
_MAX_POINTS = 400
"""Largest number of points shown per element."""
_PAPER, _POINT, _UNKNOWN = (255, 255, 255), (60, 60, 60), (200, 30, 30)


def picture(match: Match) -> Image.Image:
    """Elements from the front; uncertain ones have thin lines, unknown ones a red box."""
    low, high = match.elements.low.min(axis=0), match.elements.high.max(axis=0)
    extent = np.maximum(high - low, 1e-6)
    scale = min(_MAX_PIXELS_PER_M, _MAX_SIDE_PIXELS / float(extent.max()))
    size = np.maximum(np.ceil(extent * scale), 1.0).astype(int)
    drawing = Image.new("RGB", (int(size[0]), int(size[1])), _PAPER)
    pen = ImageDraw.Draw(drawing)

    def pixels(points: np.ndarray) -> list[tuple[float, float]]:
        moved = (points - low) * scale
        return [(x, size[1] - y) for x, y in moved.tolist()]

    for element in range(len(match.kind)):
        drawn = drawn_parameters(match, element)
        if drawn is None:
            corners = pixels(np.stack([match.elements.low[element], match.elements.high[element]]))
            (x_low, y_low), (x_high, y_high) = corners
            pen.rectangle((x_low, y_high, x_high, y_low), outline=_UNKNOWN)
        else:
            color = color_of(int(match.kind[element]))
            width = 4 if match.probability[element] >= SURE else 1
            for segment in points_along(*drawn):
                pen.line(pixels(segment + match.corner[element]), fill=color, width=width)
        cloud = match.elements.points_of(element)[:, :2]
        sample = (
            cloud[np.linspace(0, len(cloud) - 1, min(len(cloud), _MAX_POINTS)).astype(int)] if len(cloud) else cloud
        )
        for x, y in pixels(sample):
            pen.ellipse((x - 2, y - 2, x + 2, y + 2), fill=_POINT)
    return drawing


def color_of(kind: int) -> tuple[int, int, int]:
    """A colour for each kind; hues are a golden angle apart, for the best contrast."""
    red, green, blue = colorsys.hsv_to_rgb((0.58 + 0.381966 * kind) % 1.0, 0.85, 0.8)
    return round(255 * red), round(255 * green), round(255 * blue)
