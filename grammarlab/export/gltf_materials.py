"""Materials as glTF metallic-roughness materials, with colour maps from an asset folder."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np

from grammarlab.assets.mesh_files import meanings
from grammarlab.derivation.materials import Materials
from grammarlab.errors import AssetError
from grammarlab.export.gltf_document import GltfDocument
from grammarlab.scene.shading import linear_from_srgb

MOST_BYTES = 64 * 2**20
"""Largest size of an embedded image in bytes."""
MOST_PIXELS = 8192 * 8192
"""Largest number of pixels of one texture on common graphics cards."""
_SIGNATURES = {b"\x89PNG\r\n\x1a\n": ("image/png", ".png"), b"\xff\xd8\xff": ("image/jpeg", ".jpg")}
_CONVERTED = {b"II*\0": "TIFF", b"MM\0*": "TIFF", b"BM": "BMP"}
_REPEAT = 10497
NO_PICTURES: Mapping[str, bytes] = MappingProxyType({})
"""No pictures in memory."""


class GltfMaterials:
    """Materials of one document, each written when it is first used.

    Args:
        document: the document.
        assets: folder of the textures; None leaves them out.
        share: function that stores a texture beside the file and returns its URI; by default textures are embedded.
    """

    def __init__(
        self, document: GltfDocument, assets: Path | None, share: Callable[[Texture], str] | None = None
    ) -> None:
        self._document = document
        self._assets = assets
        self._share = share
        self._numbers = MaterialNumbers()
        self._textured: list[bool] = []
        self._images: dict[str, int | None] = {}

    def index(self, table: Materials, material: int) -> tuple[int, bool]:
        """The index of a material in the document, and whether it needs texture coordinates.

        Args:
            table: the materials of a scene.
            material: row of the table.

        Raises:
            AssetError: If its texture is unusable.
        """
        number = self._numbers.number(table, material)
        if number == len(self._textured):
            self._textured.append(self._write(table, material, number))
        return number, self._textured[number]

    def _write(self, table: Materials, material: int, number: int) -> bool:
        base, emissive = linear_from_srgb(np.stack((table.color[material], table.emissive[material]))).tolist()
        opacity = _share(table.opacity[material])
        surface: dict[str, Any] = {
            "baseColorFactor": [*base, opacity],
            "metallicFactor": _share(table.metallic[material]),
            "roughnessFactor": _share(table.roughness[material]),
        }
        texture = self._texture(table, table.textures[material])
        if texture is not None:
            surface["baseColorTexture"] = {"index": texture}
        entry: dict[str, Any] = {
            "name": material_name(table, material, number),
            "pbrMetallicRoughness": surface,
            "doubleSided": True,
        }
        if opacity < 1.0:
            entry["alphaMode"] = "BLEND"
        elif texture is not None and table.textures[material] in table.cut_out:
            entry["alphaMode"] = "MASK"
        if any(emissive):
            entry["emissiveFactor"] = emissive
        self._document.add("materials", entry)
        return texture is not None

    def _texture(self, table: Materials, name: str) -> int | None:
        if name not in self._images:
            texture = find_texture(name, self._assets, table.pictures)
            if texture is None:
                self._images[name] = None
            else:
                image = self._document.add("images", self._image(texture))
                self._images[name] = self._document.add("textures", {"source": image, "sampler": self._sampler()})
        return self._images[name]

    def _image(self, texture: Texture) -> dict[str, Any]:
        entry = {"name": texture.name, "mimeType": texture.mime}
        if self._share is not None:
            return {**entry, "uri": self._share(texture)}
        return {**entry, "bufferView": self._document.add_bytes(texture.content)}

    def _sampler(self) -> int:
        if not any(index is not None for index in self._images.values()):
            self._document.add("samplers", {"wrapS": _REPEAT, "wrapT": _REPEAT})
        return 0


class MaterialNumbers:
    """The different materials of one file, numbered in the order of their first use."""

    def __init__(self) -> None:
        self._numbers: dict[tuple[bytes, str], int] = {}

    def number(self, table: Materials, material: int) -> int:
        """The number of a row of a table; rows of equal appearance have the same number in all tables."""
        key = table.channels[material].tobytes(), table.textures[material]
        return self._numbers.setdefault(key, len(self._numbers))


@dataclass(frozen=True, slots=True)
class Texture:
    """An image file, unchanged if glTF supports its format."""

    name: str
    """Path relative to the asset folder."""
    content: bytes
    mime: str
    suffix: str


def find_texture(name: str, assets: Path | None, pictures: Mapping[str, bytes] = NO_PICTURES) -> Texture | None:
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
    return _texture(name, content)


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


def image_file(name: str, assets: Path) -> Path | None:
    """Path of an image below the asset folder; None if there is none.

    Raises:
        AssetError: If the path leads out of the folder, or is not valid.
    """
    paths = [_path_below(assets, meaning) for meaning in meanings(name)]
    try:
        return next((path for path in paths if path.is_file()), None)
    except OSError as error:
        raise AssetError(f"texture {name!r} cannot be read: {error.strerror or error}") from error


def material_name(table: Materials, material: int, number: int) -> str:
    """The number of a material in its file and its sRGB colour, as in ``material_3_b8a890``."""
    red, green, blue = (round(255 * min(max(value, 0.0), 1.0)) for value in table.color[material].tolist())
    return f"material_{number}_{red:02x}{green:02x}{blue:02x}"


def _share(value: float) -> float:
    return min(max(float(value), 0.0), 1.0)


def _path_below(folder: Path, name: str) -> Path:
    """The file `name` of a folder, refused when it lies elsewhere (by ``..``, an absolute path or a link).

    Raises:
        AssetError: it does.
    """
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
