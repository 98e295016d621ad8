"""A file of annotations: its chosen image, its numbers, and notes on shapes that are left out.

Numbers are finite and bounded, so that sums and rotations of them are finite too.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from grammarlab.errors import FacadeError, UsageError, shown
from grammarlab.facade.file import is_plain, load_picture, picture_size
from grammarlab.facade.reading.annotation import FARTHEST

_MAX_LISTED = 20
"""Largest number of images in a message."""
_MAX_DIGITS = 400
"""Longest text that is read as a number."""


@dataclass(frozen=True, slots=True)
class Source:
    """A file, and which of its facades is asked for."""

    path: Path
    wall: str = ""
    """Name of a wall or an image; empty if the file has only one."""

    def picture_size(self, picture: str) -> tuple[float, float] | None:
        """Width and height, pixels, of a picture in the folder of the file; None if there is no such picture.

        Raises:
            FacadeError: If the picture is broken.
        """
        folder = self.path.parent
        if not is_plain(picture) or not (folder / picture).is_file():
            return None
        width, height = picture_size(load_picture(picture, folder))
        return float(width), float(height)


@dataclass(frozen=True, slots=True)
class ImageName:
    """The names of an image."""

    file: str
    """File name of the image, perhaps with a path or an address; empty if the file has none."""
    identity: str = ""
    """Number or id of the image; empty if the file has none."""

    @property
    def text(self) -> str:
        """The name in messages."""
        return shown(self.file or self.identity)

    def matches(self, wall: str) -> bool:
        """Whether a name is that of the image: its id, its file name, or the last part of its path."""
        return bool(wall) and wall in {self.file, self.identity, last_part(self.file)}


def last_part(path: str) -> str:
    """The file name at the end of a path or an address."""
    return path.replace("\\", "/").rpartition("/")[2]


def chosen_image(images: Sequence[ImageName], wall: str) -> int:
    """Index of the image with a name; of the only one if the name is empty.

    Raises:
        UsageError: If no image has that name, or several.
    """
    matches = [index for index, image in enumerate(images) if not wall or image.matches(wall)]
    if len(matches) != 1:
        files = Counter(image.file for image in images)
        names = ", ".join(
            shown(image.identity) if image.identity and files[image.file] > 1 else image.text
            for image in images[:_MAX_LISTED]
        )
        more = f" and {len(images) - _MAX_LISTED} more" if len(images) > _MAX_LISTED else ""
        raise UsageError(f"choose one of the {len(images)} images of this file with `wall=`: {names}{more}.")
    return matches[0]


def check_only(wall: str, image: str = "") -> None:
    """Refuse to choose in a file of one facade.

    Args:
        wall: the chosen facade; empty for none.
        image: file name of the image, which may be chosen.

    Raises:
        UsageError: If another one is chosen.
    """
    if wall and not (image and ImageName(image).matches(wall)):
        raise UsageError("this file has only one facade: leave out `wall=`.")


def left_out_notes(kinds: Counter[str]) -> list[str]:
    """One note on shapes that are left out, by their kind in the words of the file.

    >>> left_out_notes(Counter({"polyline": 2, "tag": 1}))
    ['3 annotations are left out, since they are not areas with a label: 2 polyline, 1 tag']
    """
    if not kinds:
        return []
    parts = ", ".join(f"{number} {kind}" for kind, number in sorted(kinds.items()))
    return [f"{kinds.total()} annotations are left out, since they are not areas with a label: {parts}"]


def box_only_notes(number: int) -> list[str]:
    """A note on masks and shapes of several polygons, of which only the box is read.

    >>> box_only_notes(2)
    ['2 masks or shapes of several polygons are read as their boxes']
    """
    return [f"{number} masks or shapes of several polygons are read as their boxes"] if number else []


def coordinate(value: Any, where: str) -> float:
    """A number, or the text of a number, as a coordinate.

    Args:
        value: the value in the file.
        where: position of the value, for messages.

    Raises:
        FacadeError: If it is not a finite number, or is beyond `FARTHEST`.
    """
    number = _number(value)
    if not math.isfinite(number):
        raise FacadeError(f"{where}: expected a finite number, found {shown(value)}.")
    if abs(number) > FARTHEST:
        raise FacadeError(f"{where}: expected at most {FARTHEST:g}, found {shown(value)}.")
    return number


def known_size(width: Any, height: Any) -> tuple[float, float] | None:
    """Width and height of a picture in pixels; None if they are missing, zero or negative, as some programs write."""
    size = _number(width), _number(height)
    return size if all(0.0 < side <= FARTHEST for side in size) else None


def _number(value: Any) -> float:
    """The value as a number; not a number for anything else."""
    if isinstance(value, str) and len(value) <= _MAX_DIGITS and "_" not in value:
        try:
            return float(value)
        except ValueError:
            return math.nan
    if isinstance(value, int | float) and not isinstance(value, bool):
        try:
            return float(value)
        except OverflowError:
            return math.inf
    return math.nan
