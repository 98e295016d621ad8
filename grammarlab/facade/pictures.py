"""Pictures of facades, as files in the same folder."""

from __future__ import annotations

import io
import re
import warnings
from collections.abc import Iterable
from pathlib import Path

from grammarlab.errors import FacadeError
from grammarlab.facade.tree import Picture
from grammarlab.facade.values import read_bounded, shown
from grammarlab.files import write_bytes

MOST_BYTES = 64 * 2**20
MOST_PIXELS = 100_000_000
_PLAIN = re.compile(r"[\w-][\w .()+-]{0,150}\.(png|jpg|jpeg)", re.IGNORECASE)
_FORMATS = ("PNG", "JPEG")


def is_plain(name: str) -> bool:
    """Whether a name is that of a picture file in the same folder."""
    return _PLAIN.fullmatch(name) is not None


def picture_size(picture: Picture) -> tuple[int, int]:
    """Width and height in pixels; only the head of the file is read.

    Raises:
        FacadeError: If it is not a PNG or JPEG file, or has more than `MOST_PIXELS`.
    """
    from PIL import Image  # noqa: PLC0415  # facades without pictures do without

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # large pictures are refused below
            with Image.open(io.BytesIO(picture.content), formats=_FORMATS) as image:
                width, height = image.size
    except Exception as error:  # readers raise any exception for a broken file
        raise FacadeError(f"The picture {shown(picture.name)} is not a PNG or JPEG file: {error}.") from error
    if width * height > MOST_PIXELS:
        raise FacadeError(
            f"The picture {shown(picture.name)} has {width} x {height} pixels; expected at most {MOST_PIXELS:,}."
        )
    return width, height


def load_picture(name: str, folder: Path) -> Picture:
    """The picture with a name in a folder.

    Raises:
        FacadeError: If the name is not plain, or the file is missing, a link out of the folder, too large, or not a
            picture.
    """
    if not is_plain(name):
        raise FacadeError(
            f"The picture {shown(name)}: expected the plain name of a .png or .jpg file in the folder of the facade."
        )
    path = folder / name
    if not path.is_file() or path.resolve().parent != folder.resolve():
        raise FacadeError(f"The picture {shown(name)} is not in the folder of the facade.")
    picture = Picture(name, read_bounded(path, MOST_BYTES))
    picture_size(picture)
    return picture


def store_pictures(pictures: Iterable[Picture], folder: Path) -> None:
    """Write pictures into a folder, each under its name.

    Raises:
        FacadeError: If a name is not plain, or belongs to another existing file. Nothing is written then.
    """
    new = []
    for picture in pictures:
        if not is_plain(picture.name):
            raise FacadeError(f"The picture {shown(picture.name)}: expected a plain name that ends in .png or .jpg.")
        path = folder / picture.name
        if not path.exists():
            new.append(picture)
        elif path.stat().st_size != len(picture.content) or path.read_bytes() != picture.content:
            raise FacadeError(f"{path} exists and differs from the picture of this facade: write into another folder.")
    for picture in new:
        write_bytes(folder / picture.name, picture.content)
