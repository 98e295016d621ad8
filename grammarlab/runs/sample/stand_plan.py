"""Plans of stands: crowns as circles on the outlines of their area, seen from above, north up."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

from grammarlab.arrays import Floats
from grammarlab.runs.sample.contact_sheet import BORDER, FAINT, INK, PAPER
from grammarlab.runs.sample.stand import HECTARE, Stand

_LONG_SIDE = 1200
"""Pixels of the longer side of the map."""
_SHORT_SIDE = 320
"""Smallest number of pixels of the other side."""
_SPACE = 1.02
"""Room around the trees, as a factor."""
_SCALE = 2
"""Pixels that are drawn for each pixel of the picture, along a side: edges are smooth."""
_HEADING, _FOOT = 40, 40
"""Pixels of height for the heading, and for the scale."""
_LARGE, _SMALL = 18, 13
"""Sizes of type in pixels."""
_GROUND, _EDGE = (232, 231, 220), (150, 145, 128)
_CROWN, _RIM, _TRUNK = (118, 158, 92, 150), (62, 96, 44, 255), (70, 50, 34, 255)


def draw_plan(stand: Stand, name: str) -> NDArray[np.uint8]:
    """Picture [height, width, 3] of a stand.

    Args:
        stand: trees and their area.
        name: name of the species, for the heading.
    """
    low, high = _bounds(stand)
    extent = np.maximum(high - low, 1e-3) * _SPACE
    pixels_per_metre = _SCALE * _LONG_SIDE / extent.max()
    size = np.maximum(np.round(extent * pixels_per_metre), _SCALE * _SHORT_SIDE).astype(int)
    start = (low + high) / 2 - size / pixels_per_metre / 2
    picture = _map(stand, start, pixels_per_metre, (int(size[0]), int(size[1])))
    picture = picture.resize((picture.width // _SCALE, picture.height // _SCALE), Image.Resampling.BOX)
    page = Image.new("RGB", (picture.width + 2 * BORDER, picture.height + _HEADING + _FOOT), PAPER)
    page.paste(picture, (BORDER, _HEADING))
    _write(page, stand, name, pixels_per_metre / _SCALE)
    return np.asarray(page)


def _bounds(stand: Stand) -> tuple[Floats, Floats]:
    """Lowest and highest x and z [2] of outlines and crowns."""
    trunks = stand.position[:, [0, 2]]
    radius = stand.radius[:, None]
    points = np.concatenate([trunks - radius, trunks + radius, *(ring for rings in stand.outlines for ring in rings)])
    return points.min(axis=0), points.max(axis=0)


def _map(stand: Stand, start: Floats, scale: float, size: tuple[int, int]) -> Image.Image:
    """The outlines and crowns.

    Args:
        stand: the stand.
        start: [2] x and z of the upper left corner in metres.
        scale: pixels per metre.
        size: width and height in pixels.
    """
    picture = Image.new("RGB", size, PAPER)
    draw = ImageDraw.Draw(picture)
    for outer, *holes in stand.outlines:
        ground = Image.new("L", size, 0)
        mask = ImageDraw.Draw(ground)
        for ring, value in ((outer, 255), *((hole, 0) for hole in holes)):
            mask.polygon(_pixels(ring, start, scale), fill=value)
        picture.paste(_GROUND, mask=ground)
        for ring in (outer, *holes):
            corners = _pixels(ring, start, scale)
            draw.line([*corners, corners[0]], _EDGE, _SCALE)
    crowns = Image.new("RGBA", size, (0, 0, 0, 0))
    draw = ImageDraw.Draw(crowns)
    trunks = (stand.position[:, [0, 2]] - start) * scale
    for (x, y), radius in zip(trunks.tolist(), (stand.radius * scale).tolist(), strict=True):
        draw.ellipse((x - radius, y - radius, x + radius, y + radius), _CROWN, _RIM, _SCALE)
        dot = max(min(0.12 * radius, 2.5 * _SCALE), 1.0)
        draw.ellipse((x - dot, y - dot, x + dot, y + dot), _TRUNK)
    picture.paste(crowns, mask=crowns)
    return picture


def _pixels(ring: Floats, start: Floats, scale: float) -> list[tuple[float, float]]:
    return [(x, y) for x, y in ((ring - start) * scale).tolist()]


def _write(page: Image.Image, stand: Stand, name: str, scale: float) -> None:
    """Write the heading, and a scale in metres below the map."""
    draw, large, small = ImageDraw.Draw(page), ImageFont.load_default(_LARGE), ImageFont.load_default(_SMALL)
    draw.text((BORDER, _HEADING // 2), name, INK, large, anchor="lm")
    hectares = stand.size / HECTARE
    text = f"{len(stand):,} trees on {hectares:.3g} ha, {len(stand) / hectares:.3g} per hectare; north is up"
    right = page.width - BORDER
    if right - BORDER - draw.textlength(name, large) - BORDER > draw.textlength(text, small):
        draw.text((right, _HEADING // 2), text, FAINT, small, anchor="rm")
    metres = _round_below(0.3 * page.width / scale)
    y, end = page.height - _FOOT // 2, BORDER + metres * scale
    draw.line([(BORDER, y - 4), (BORDER, y), (end, y), (end, y - 4)], INK, 2)
    draw.text((end + 8, y), f"{metres:g} m", INK, small, anchor="lm")


def _round_below(length: float) -> float:
    """The largest number of the form 1, 2 or 5 times a power of ten that is not above a length.

    >>> [_round_below(length) for length in (0.7, 30.0, 99.0)]
    [0.5, 20.0, 50.0]
    """
    power = 10.0 ** math.floor(math.log10(length))
    return next(digit * power for digit in (5.0, 2.0, 1.0) if digit * power <= length)
