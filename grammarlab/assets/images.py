"""How large images are; a file may come from a stranger, so nothing of it but its head is read."""

from __future__ import annotations

import warnings
from pathlib import Path

from grammarlab.assets.meshes import find_asset
from grammarlab.errors import AssetError

FORMATS = ("BMP", "GIF", "JPEG", "PNG", "TGA", "TIFF", "WEBP")


def image_size(path: str, root: Path) -> tuple[int, int]:
    """Width and height of an image in pixels, at least 1.

    Args:
        path: of the file, relative to the folder.
        root: the asset folder; nothing outside it is read, links included.

    Raises:
        MissingAssetError: when there is no such file in the folder.
        AssetError: when it lies outside, is too large, or is no image.
    """
    from PIL import Image  # noqa: PLC0415  # few grammars ask

    file = find_asset(path, root)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # what Pillow warns of does not matter: no pixel is unfolded
            with Image.open(file, formats=FORMATS) as image:
                width, height = image.size
    except Exception as error:  # readers raise whatever a broken file leads them to
        raise AssetError(f'the image "{path}" cannot be read: {error}') from error
    return max(width, 1), max(height, 1)
