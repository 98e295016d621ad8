"""Sizes of images. A file may come from a stranger, so only its header is read."""

from __future__ import annotations

import warnings
from pathlib import Path

from grammarlab.assets.mesh_files import find_asset
from grammarlab.errors import AssetError

FORMATS = ("BMP", "GIF", "JPEG", "PNG", "TGA", "TIFF", "WEBP")


def image_size(path: str, root: Path) -> tuple[int, int]:
    """Width and height of an image in pixels, at least 1.

    Args:
        path: path of the file, relative to the folder.
        root: the asset folder; nothing outside it is read, links included.

    Raises:
        MissingAssetError: If the folder has no such file.
        AssetError: If it lies outside, is too large, or is not an image.
    """
    from PIL import Image  # noqa: PLC0415  # few grammars need it

    file = find_asset(path, root)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # Pillow's warnings do not matter: no pixel is decoded
            with Image.open(file, formats=FORMATS) as image:
                width, height = image.size
    except Exception as error:  # readers raise any exception for broken files
        raise AssetError(f'the image "{path}" cannot be read: {error}') from error
    return max(width, 1), max(height, 1)
