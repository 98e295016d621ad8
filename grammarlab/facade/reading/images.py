"""The choice of one image in a file of several."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

from grammarlab.errors import UsageError
from grammarlab.facade.values import shown

_MOST_NAMED = 20
"""Largest number of images in a message."""


@dataclass(frozen=True, slots=True)
class ImageName:
    """The names of an image."""

    file: str
    """Its file name, perhaps with a path or an address; empty if the file has none."""
    identity: str = ""
    """Its number or id; empty if the file has none."""

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
            for image in images[:_MOST_NAMED]
        )
        more = f" and {len(images) - _MOST_NAMED} more" if len(images) > _MOST_NAMED else ""
        raise UsageError(f"choose one of the {len(images)} images of this file with --wall: {names}{more}.")
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
        raise UsageError("this file has only one facade: leave out --wall.")
