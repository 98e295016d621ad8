"""Images on surfaces: files below the asset folder, and images inside glTF files there.

A file may come from a stranger: its size, its number of pixels and its place are checked before it is used.
"""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from types import MappingProxyType

from grammarlab.asset_roots import AssetRoot, Place, places
from grammarlab.assets.image_paths import INSIDE
from grammarlab.assets.mesh_files import find_asset
from grammarlab.errors import AssetError

MOST_BYTES = 64 * 2**20
"""Largest size of an embedded image in bytes."""
MOST_PIXELS = 8192 * 8192
"""Largest number of pixels of one texture on common graphics cards."""
_SIGNATURES = {b"\x89PNG\r\n\x1a\n": ("image/png", ".png"), b"\xff\xd8\xff": ("image/jpeg", ".jpg")}
_FORMATS = ("BMP", "GIF", "JPEG", "PNG", "TGA", "TIFF", "WEBP")
"""Formats whose sizes are read."""
_CONVERTED = {b"II*\0": "TIFF", b"MM\0*": "TIFF", b"BM": "BMP"}
NO_PICTURES: Mapping[str, bytes] = MappingProxyType({})
"""No pictures in memory."""


@dataclass(frozen=True, slots=True)
class Texture:
    """An image file, unchanged if glTF supports its format."""

    name: str
    """Path relative to the asset folder."""
    content: bytes
    mime: str
    suffix: str


def find_texture(name: str, assets: AssetRoot | None, pictures: Mapping[str, bytes] = NO_PICTURES) -> Texture | None:
    """Image of this name below the asset folder; None if there is none.

    Args:
        name: path relative to `assets`; empty for no texture.
        assets: the asset folder; None when no assets are to be used.
        pictures: contents of PNG and JPEG files by name; they are looked up first (`Materials.pictures`).

    TIFF and BMP images are converted to PNG.

    Raises:
        AssetError: If the path leads out of the folder, or the file is not such an image, too large, or unreadable.
    """
    if name in pictures:
        return _texture(name, pictures[name])
    if not name or assets is None:
        return None
    path = image_file(name, assets)
    if path is None:
        return None
    try:
        size = path.stat().st_size
        if size > MOST_BYTES:
            raise AssetError(f"texture {name!r} has {size / 2**20:.0f} MiB; at most {MOST_BYTES // 2**20} are embedded")
        content = path.read_bytes()
    except OSError as error:
        raise AssetError(f"texture {name!r} cannot be read: {error.strerror or error}") from error
    return _texture(name, _unpacked(name, content))


def _unpacked(name: str, content: bytes) -> bytes:
    """The image inside a glTF file of this content, if the name has the number of one; else the content itself.

    Raises:
        AssetError: If there is no such image.
    """
    _, inside, number = name.rpartition(INSIDE)
    if not inside or not number.isdecimal():
        return content
    from grammarlab.assets.gltf_surface import image_inside  # noqa: PLC0415  # few images lie in such files

    try:
        return image_inside(content, int(number))
    except AssetError as error:
        raise AssetError(f"texture {name!r} cannot be read: {error}") from error


def _texture(name: str, content: bytes) -> Texture:
    """The image in a file of this content.

    Raises:
        AssetError: If it is not an image of a known format, or broken.
    """
    for signature, (mime, suffix) in _SIGNATURES.items():
        if content.startswith(signature):
            _require_image(name, content)
            return Texture(name, content, mime, suffix)
    for signature, kind in _CONVERTED.items():
        if content.startswith(signature):
            _require_image(name, content, kind)
            return Texture(name, _as_png(name, content, kind), "image/png", ".png")
    raise AssetError(f"texture {name!r} is neither a PNG nor a JPEG image; convert it to one of them")


def image_file(name: str, assets: AssetRoot) -> Path | None:
    """Path of an image below the asset folder; None if there is none.

    Raises:
        AssetError: If the path leads out of the folder, or is not valid.
    """
    file, inside, number = name.rpartition(INSIDE)
    path = file if inside and number.isdecimal() else name
    paths = [_path_below(place) for place in places(path, assets)]
    try:
        return next((path for path in paths if path.is_file()), None)
    except OSError as error:
        raise AssetError(f"texture {name!r} cannot be read: {error.strerror or error}") from error


def image_size(path: str, root: AssetRoot) -> tuple[int, int]:
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
            with Image.open(file, formats=_FORMATS) as image:
                width, height = image.size
    except Exception as error:  # readers raise any exception for broken files
        raise AssetError(f'the image "{path}" cannot be read: {error}') from error
    return max(width, 1), max(height, 1)


def _path_below(place: Place) -> Path:
    """The file of a place, refused when it lies elsewhere (by ``..``, an absolute path or a link).

    Raises:
        AssetError: it does.
    """
    folder, name = place
    try:
        root = folder.resolve()
        path = (root / name).resolve()
    except (OSError, ValueError, RuntimeError) as error:
        raise AssetError(f"{name!r} is not a usable path below the asset folder: {error}") from error
    if not path.is_relative_to(root):
        raise AssetError(f"{name!r} lies outside the asset folder {folder}; use a path below it")
    return path


def _require_image(name: str, content: bytes, *kinds: str) -> None:
    """Refuse a file with the header of an image but broken content.

    Raises:
        AssetError: If it is broken, or has more than `MOST_PIXELS`.
    """
    # Imported here, since most files have no textures.
    from PIL import Image, UnidentifiedImageError  # noqa: PLC0415

    try:
        with warnings.catch_warnings():
            # Pillow's warnings are refused below, or do not matter.
            warnings.simplefilter("ignore")
            with Image.open(BytesIO(content), formats=kinds or ("PNG", "JPEG")) as image:
                width, height = image.size
                image.verify()
    except (UnidentifiedImageError, Image.DecompressionBombError, OSError, SyntaxError, ValueError) as error:
        raise AssetError(f"texture {name!r} is a broken image: {error}; save it again") from error
    if width * height > MOST_PIXELS:
        raise AssetError(
            f"texture {name!r} has {width} x {height} pixels; at most {MOST_PIXELS} in all can be shown everywhere"
        )


def _as_png(name: str, content: bytes, kind: str) -> bytes:
    """An image of a format that glTF does not support, as PNG."""
    from PIL import Image  # noqa: PLC0415

    result = BytesIO()
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            with Image.open(BytesIO(content), formats=[kind]) as image:
                see_through = image.mode in ("LA", "PA", "RGBA") or "transparency" in image.info
                image.convert("RGBA" if see_through else "RGB").save(result, "PNG")
    except Exception as error:  # readers raise any exception for broken files
        raise AssetError(f"texture {name!r} is a broken image: {error}; save it again") from error
    return result.getvalue()
