"""A file of annotations, with what its reader has to know besides its content."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from grammarlab.facade.pictures import is_plain, load_picture, picture_size


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
