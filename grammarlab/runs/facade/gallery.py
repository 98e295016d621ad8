"""Several facades as files in one folder, with a picture of all of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from io import BytesIO
from itertools import count, takewhile
from pathlib import Path

import numpy as np
from PIL import Image

from grammarlab.errors import UsageError
from grammarlab.facade.file import save_facade
from grammarlab.facade.showing.drawing import draw
from grammarlab.facade.showing.svg import svg
from grammarlab.facade.sizes.wishes import Wish
from grammarlab.facade.tree import Facade
from grammarlab.files import write_bytes, write_text

CONTACT = "contact.png"
_PIXELS_PER_METRE, _LONGEST = 50.0, 640
"""Largest resolution of pictures, pixels per metre, and largest side of a picture, pixels."""
_SAMPLES = 1
"""Samples per pixel: most edges are along pixels, and pictures are needed at once."""
_SHEET, _MARGIN = 2400, 24
"""Width of the contact sheet, and distance between facades, pixels."""


def save_gallery(
    facades: Sequence[Facade], folder: Path, source: Path | None = None, locks: Sequence[Sequence[Wish]] = ()
) -> list[Path]:
    """Write each facade as ``001.facade.json``, ``001.svg`` and ``001.png``, and all as ``contact.png``.

    Everything is drawn before the first file is written. All pictures have one scale. Facades of higher numbers from an
    earlier run are removed: a folder shows one run.

    Args:
        facades: the facades, at least one.
        folder: where to write; created if missing.
        source: a file that is neither overwritten nor removed.
        locks: locks of each facade; none when left out.

    Returns:
        The files of the facades.

    Raises:
        UsageError: If the source would be overwritten.
        FacadeError: If a facade cannot be drawn, or a file with the name of one of its pictures has other content.
    """
    names = [f"{number:03}" for number in range(1, len(facades) + 1)]
    files = [folder / f"{name}.facade.json" for name in names]
    earlier = _earlier(folder, len(names))
    gone = [folder / f"{name}.facade.json" for name in earlier]
    if source and any(file.exists() and file.samefile(source) for file in (*files, *gone)):
        raise UsageError(f"{source} would be overwritten: write to another folder.")
    longest = max(max(facade.width, facade.height) for facade in facades)
    scale = min(_PIXELS_PER_METRE, _LONGEST / longest)
    facades = [_renamed(facade, {CONTACT, *(f"{name}.png" for name in names)}) for facade in facades]
    drawings = [svg(facade) for facade in facades]
    pictures = [Image.fromarray(draw(facade, scale, _SAMPLES)) for facade in facades]
    contact = sheet(pictures)
    folder.mkdir(parents=True, exist_ok=True)
    locks = locks or [()] * len(files)
    for name, file, facade, held, drawing, picture in zip(
        names, files, facades, locks, drawings, pictures, strict=True
    ):
        save_facade(facade, file, held)
        write_text(folder / f"{name}.svg", drawing)
        write_bytes(folder / f"{name}.png", _png(picture))
    write_bytes(folder / CONTACT, _png(contact))
    for name in earlier:
        for suffix in ("facade.json", "svg", "png"):
            (folder / f"{name}.{suffix}").unlink(missing_ok=True)
    return files


def _earlier(folder: Path, num: int) -> list[str]:
    """Numbers of facades after the given one, as long as files of them exist."""
    following = (f"{number:03}" for number in count(num + 1))
    return list(takewhile(lambda name: (folder / f"{name}.facade.json").is_file(), following))


def sheet(pictures: Sequence[Image.Image]) -> Image.Image:
    """Pictures side by side on white, in as many rows as needed, aligned at the bottom of each row."""
    rows: list[list[Image.Image]] = [[]]
    for picture in pictures:
        if rows[-1] and _MARGIN + sum(each.width + _MARGIN for each in (*rows[-1], picture)) > _SHEET:
            rows.append([])
        rows[-1].append(picture)
    width = max(_MARGIN + sum(each.width + _MARGIN for each in row) for row in rows)
    bottom = np.cumsum([max(each.height for each in row) + _MARGIN for row in rows]).tolist()
    page = Image.new("RGB", (width, bottom[-1] + _MARGIN), "white")
    for row, floor in zip(rows, bottom, strict=True):
        left = _MARGIN
        for picture in row:
            page.paste(picture, (left, floor - picture.height))
            left += picture.width + _MARGIN
    return page


def _renamed(facade: Facade, taken: set[str]) -> Facade:
    """The facade, with other names for pictures whose names the drawings need."""
    pictures = [
        replace(each, name=f"shown-{each.name}") if each.name.lower() in taken else each for each in facade.pictures
    ]
    return replace(facade, pictures=tuple(pictures))


def _png(picture: Image.Image) -> bytes:
    content = BytesIO()
    picture.save(content, "PNG")
    return content.getvalue()
