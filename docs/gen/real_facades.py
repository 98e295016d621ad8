"""Drawings of real facades and their edits, from a folder of annotations that is not part of this project."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw

from grammarlab.facade.editing.edit import edit
from grammarlab.facade.looks import look_of
from grammarlab.facade.tree import Facade
from grammarlab.runs.facade.read import read_facade

FACTORS = ((1.0, 1.0), (0.7, 1.0), (1.3, 1.0), (2.0, 1.0), (1.0, 1.5))
"""Width and height of each drawing, in those of the facade."""
NUMBER, PER_SHEET, STEP = 20, 5, 9
"""Numbers of facades, in all and on a sheet; and the step between those drawn of the sorted files at odd positions."""
_WIDTH, _HEIGHT, _GAP = 1240, 250, 10
"""Largest size of a row of drawings, and the gap between drawings, pixels."""


def drawing(facade: Facade, pixels_per_metre: float) -> Image.Image:
    """The leaves of a facade as rectangles in the colours of their labels."""
    size = np.maximum(np.rint(facade.size[0] * pixels_per_metre), 1.0).astype(int)
    image = Image.new("RGB", tuple(size.tolist()), "white")
    pen = ImageDraw.Draw(image)
    low = (facade.position - facade.position[0]) * pixels_per_metre
    high = low + facade.size * pixels_per_metre
    for leaf in facade.leaves.tolist():
        (left, bottom), (right, top) = np.rint(low[leaf]).astype(int), np.rint(high[leaf]).astype(int)
        if left < right and bottom < top:
            look = look_of(facade.name_of(leaf))
            pen.rectangle(
                (left, size[1] - top, right - 1, size[1] - bottom - 1),
                fill=look.color,
                outline=None if look.is_flexible else "#404040",
            )
    return image


def versions(annotation: Path) -> list[Facade]:
    """The facade of an annotation, without its picture, and the best result for each of the other sizes."""
    facade = read_facade(annotation).facade
    facade = replace(facade, picture=np.full(len(facade), -1, dtype=np.int64), pictures=())
    results = [facade]
    for wide, high in FACTORS[1:]:
        width = wide * facade.width if wide != 1.0 else None
        height = high * facade.height if high != 1.0 else None
        results.append(edit(facade, width=width, height=height, most=1)[0].facade)
    return results


def row(facades: list[Facade]) -> Image.Image:
    """Drawings of one scale side by side, on one ground."""
    widths = sum(facade.width for facade in facades)
    scale = min((_WIDTH - _GAP * len(facades)) / widths, _HEIGHT / max(facade.height for facade in facades))
    drawings = [drawing(facade, scale) for facade in facades]
    image = Image.new("RGB", (_WIDTH, max(each.height for each in drawings)), "white")
    left = 0
    for each in drawings:
        image.paste(each, (left, image.height - each.height))
        left += each.width + _GAP
    return image


def main(folder: Path, images: Path) -> None:
    """Write the sheets `real_facades_1.png` and so on."""
    chosen = sorted(folder.glob("*.xml"))[1::2][::STEP][:NUMBER]
    rows = [row(versions(annotation)) for annotation in chosen]
    for sheet, first in enumerate(range(0, len(rows), PER_SHEET), start=1):
        part = rows[first : first + PER_SHEET]
        image = Image.new("RGB", (_WIDTH, sum(each.height + 2 * _GAP for each in part)), "white")
        top = 0
        for each in part:
            image.paste(each, (0, top))
            top += each.height + 2 * _GAP
        image.quantize(32).save(images / f"real_facades_{sheet}.png", optimize=True)


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]))
