"""Page of a contact sheet: a heading, and pictures in rows with captions."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

Picture: TypeAlias = NDArray[np.uint8]
Font: TypeAlias = ImageFont.FreeTypeFont | ImageFont.ImageFont

PAPER, INK, FAINT = (247, 247, 245), (52, 56, 62), (128, 132, 138)
"""Colours of the page, of primary text, and of secondary text."""
BORDER, GAP = 16, 10
"""Pixels around the page, and between pictures."""
HEADING, CAPTION = 34, 24
"""Pixels of height for a line of text."""
LARGE, SMALL = 18, 13
"""Sizes of type in pixels."""


@dataclass(frozen=True, slots=True)
class SheetPage:
    """Layout of a page."""

    width: int
    """Pixels of one picture."""
    height: int
    columns: int
    rows: int

    def place(self, index: int) -> tuple[int, int]:
        """Left and top of a picture."""
        row, column = divmod(index, self.columns)
        return (
            BORDER + column * (self.width + GAP),
            BORDER + HEADING + row * (self.height + CAPTION + GAP),
        )

    def size(self) -> tuple[int, int]:
        """Width and height of the page."""
        left, top = self.place(self.rows * self.columns - 1)
        return left + self.width + BORDER, top + self.height + CAPTION + BORDER


def lay_out(num: int, columns: int, width: int, height: int) -> SheetPage:
    """A page for pictures of one size.

    Args:
        num: pictures, at least 1.
        columns: pictures side by side; 0 for a page that is about square.
        width: pixels of a picture.
        height: pixels of a picture.
    """
    best = min(columns, num) or min(range(1, num + 1), key=lambda count: _awkwardness(num, count, width, height))
    return SheetPage(width, height, best, math.ceil(num / best))


def _awkwardness(num: int, columns: int, width: int, height: int) -> float:
    """Deviation of a page from a square without gaps."""
    rows = math.ceil(num / columns)
    shape = math.log(columns * (width + GAP) / (rows * (height + CAPTION + GAP)))
    return abs(shape) + 4 * (rows * columns - num) / num


def draw_page(
    page: SheetPage, pictures: Sequence[Picture], captions: Sequence[tuple[str, str]], heading: tuple[str, str]
) -> Picture:
    """The whole page.

    Args:
        page: the layout.
        pictures: [height, width, 3] each.
        captions: below each picture, at its left and its right.
        heading: texts at the left and the right of the page; the right one is left out if it does not fit.
    """
    canvas = Image.new("RGB", page.size(), PAPER)
    draw, large, small = ImageDraw.Draw(canvas), ImageFont.load_default(LARGE), ImageFont.load_default(SMALL)
    _line(draw, (BORDER, canvas.width - BORDER), BORDER + HEADING // 2 - 6, heading, (large, small))
    for index, (picture, caption) in enumerate(zip(pictures, captions, strict=True)):
        left, top = page.place(index)
        canvas.paste(Image.fromarray(picture), (left, top))
        _line(draw, (left + 2, left + page.width - 2), top + page.height + CAPTION // 2, caption, (small, small))
    return np.asarray(canvas)


def _line(
    draw: ImageDraw.ImageDraw, between: tuple[int, int], middle: int, texts: tuple[str, str], fonts: tuple[Font, Font]
) -> None:
    """One text from the left in ink, one from the right, fainter and clipped to the remaining width."""
    left, right = between
    draw.text((left, middle), texts[0], INK, fonts[0], anchor="lm")
    room = right - left - draw.textlength(texts[0], fonts[0]) - GAP
    if draw.textlength(texts[1], fonts[1]) <= room:
        draw.text((right, middle), texts[1], FAINT, fonts[1], anchor="rm")
