"""Colours of materials seen from afar, where a texture is one colour."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from hashlib import sha256
from io import BytesIO

import numpy as np

from grammarlab.arrays import Floats
from grammarlab.asset_roots import AssetRoot
from grammarlab.assets.srgb import linear_from_srgb
from grammarlab.assets.texture_files import find_texture
from grammarlab.derivation.materials import Materials
from grammarlab.scene.instances import Scene

_SIDE = 64
"""Largest side in pixels of the picture whose mean is taken."""


class TextureColors:
    """Mean colours of textures, each computed when it is first used.

    Args:
        assets: folder of the textures; None leaves them out.
    """

    def __init__(self, assets: AssetRoot | None) -> None:
        self._assets = assets
        self._means: dict[tuple[str, bool], Floats] = {}

    def light(self, materials: Materials) -> Floats:
        """[K, 3] linear colours of materials with their textures.

        Raises:
            AssetError: If a texture is unusable.
        """
        light = linear_from_srgb(materials.color).astype(np.float64)
        for row, name in enumerate(materials.textures):
            if name:
                light[row] *= self._mean(name, materials.pictures, is_cut_out=name in materials.cut_out)
        return light

    def _mean(self, name: str, pictures: Mapping[str, bytes], *, is_cut_out: bool) -> Floats:
        if (name, is_cut_out) not in self._means:
            texture = find_texture(name, self._assets, pictures)
            mean = np.ones(3) if texture is None else mean_light(texture.content, is_cut_out=is_cut_out)
            self._means[name, is_cut_out] = mean
        return self._means[name, is_cut_out]


def mean_light(content: bytes, *, is_cut_out: bool) -> Floats:
    """[3] mean linear colour of a picture, without its holes if it has any.

    Args:
        content: a PNG or JPEG file.
        is_cut_out: whether transparent parts are holes.
    """
    # Imported here, since most models have no textures.
    from PIL import Image  # noqa: PLC0415

    with Image.open(BytesIO(content)) as image:
        image.thumbnail((_SIDE, _SIDE))
        pixels = np.asarray(image.convert("RGBA"), dtype=np.float64).reshape(-1, 4) / 255.0
    weights = pixels[:, 3] if is_cut_out and pixels[:, 3].any() else np.ones(len(pixels))
    return weights @ linear_from_srgb(pixels[:, :3]) / weights.sum()


def with_pictures(scene: Scene, assets: AssetRoot | None) -> Scene:
    """A scene whose materials contain their textures, so that scenes with different asset folders can be joined.

    Args:
        scene: the scene.
        assets: folder of its textures; None leaves them out.

    Raises:
        AssetError: If a texture is unusable.
    """
    pictures: dict[str, bytes] = {}
    names = {"": ""}
    for name in scene.materials.textures:
        if name not in names:
            texture = find_texture(name, assets, scene.materials.pictures)
            # By content: two folders may have different pictures of one name.
            names[name] = "" if texture is None else f"{sha256(texture.content).hexdigest()[:16]}{texture.suffix}"
            if texture is not None:
                pictures[names[name]] = texture.content
    materials = replace(
        scene.materials,
        textures=tuple(names[name] for name in scene.materials.textures),
        pictures=pictures,
        cut_out=frozenset(names[name] for name in scene.materials.cut_out if names.get(name)),
    )
    return replace(scene, materials=materials)
