"""Materials of trees: bark, leaves and blossoms of every look."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from grammarlab.asset_roots import AssetRoot
from grammarlab.assets.texture_files import find_texture
from grammarlab.derivation.materials import CHANNELS, Materials
from grammarlab.trees.species import Look

BARK, LEAF, BLOSSOM = range(3)
"""Materials of a look, in the order of their rows."""
_ROUGHNESS = (0.95, 0.7, 0.75)
_OPAQUE = (".jpg", ".jpeg")
"""Ends of names of pictures that cannot be transparent."""


def tree_materials(looks: Sequence[Look], assets: AssetRoot | None = None) -> Materials:
    """Three rows for each look: bark, leaf and blossom.

    Args:
        looks: the looks.
        assets: folder of pictures that are read into the materials; None for none.

    Raises:
        AssetError: If a picture is outside the folder, or broken.
    """
    rows, textures = [], []
    for look in looks:
        parts = (look.bark_color, look.bark), (look.leaf_color, look.leaf), (look.blossom_color, look.blossom)
        for (color, picture), roughness in zip(parts, _ROUGHNESS, strict=True):
            rows.append(_channels(color, roughness))
            textures.append(picture)
    cut_out = [name for index, name in enumerate(textures) if index % 3 != BARK and not name.lower().endswith(_OPAQUE)]
    images = {name: find_texture(name, assets) for name in dict.fromkeys(textures)}
    pictures = {name: image.content for name, image in images.items() if image is not None}
    table = np.array(rows).reshape(-1, len(CHANNELS))
    thin = frozenset(row for row in range(len(table)) if row % 3 != BARK)
    return Materials(table, tuple(textures), pictures, frozenset(cut_out) - {""}, thin)


def card_materials(pictures: Mapping[str, bytes]) -> Materials:
    """One row for each picture of a tree with transparent ground."""
    rows = np.tile(_channels((1.0, 1.0, 1.0), 1.0), (len(pictures), 1))
    return Materials(rows, tuple(pictures), pictures, frozenset(pictures), frozenset(range(len(rows))))


def _channels(color: tuple[float, float, float], roughness: float) -> list[float]:
    values = CHANNELS | dict(zip(("color.r", "color.g", "color.b"), color, strict=True)) | {"roughness": roughness}
    return list(values.values())
