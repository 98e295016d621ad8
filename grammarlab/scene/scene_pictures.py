"""Scenes that carry the images on their surfaces."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import replace

import numpy as np

from grammarlab.asset_roots import AssetRoot
from grammarlab.assets.texture_files import find_texture
from grammarlab.errors import AssetError
from grammarlab.scene.instances import Scene


def with_pictures(scene: Scene, assets: AssetRoot | None) -> Scene:
    """The same scene with the contents of the images that its instances use (`Materials.pictures`).

    Images that the folder lacks, or that are unusable, are left out: the colour of the material is seen.

    Args:
        scene: the scene.
        assets: folder of the images; None leaves them out.
    """
    table = scene.materials
    used = {table.textures[material] for material in np.unique(scene.material).tolist()} - {""} - table.pictures.keys()
    pictures: dict[str, bytes] = {}
    for name in sorted(used):
        with suppress(AssetError):
            texture = find_texture(name, assets)
            if texture is not None:
                pictures[name] = texture.content
    if not pictures:
        return scene
    return replace(scene, materials=replace(table, pictures={**table.pictures, **pictures}))
