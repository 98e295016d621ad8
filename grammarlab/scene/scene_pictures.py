"""Scenes that carry the images on their surfaces."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from grammarlab.assets.texture_files import find_texture
from grammarlab.scene.instances import Scene


def with_pictures(scene: Scene, assets: Path | None) -> Scene:
    """The same scene with the contents of the images that its instances use (`Materials.pictures`).

    Images that the folder lacks are left out, so that the colour of the material is seen.

    Args:
        scene: the scene.
        assets: folder of the images; None leaves them out.

    Raises:
        AssetError: If an image is unusable.
    """
    table = scene.materials
    used = {table.textures[material] for material in np.unique(scene.material).tolist()} - {""}
    found = {name: find_texture(name, assets, table.pictures) for name in sorted(used)}
    pictures = {name: texture.content for name, texture in found.items() if texture is not None}
    if not pictures:
        return scene
    return replace(scene, materials=replace(table, pictures={**table.pictures, **pictures}))
