"""Materials as glTF metallic-roughness materials, with colour maps from an asset folder."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from grammarlab.asset_roots import AssetRoot
from grammarlab.assets.srgb import linear_from_srgb
from grammarlab.assets.texture_files import Texture, find_texture
from grammarlab.derivation.materials import Materials
from grammarlab.export.gltf_document import GltfDocument
from grammarlab.export.names import MaterialNumbers

_REPEAT = 10497


class GltfMaterials:
    """Materials of one document, each written when it is first used.

    Args:
        document: the document.
        assets: folder of the textures; None leaves them out.
        share: function that stores a texture beside the file and returns its URI; by default textures are embedded.
    """

    def __init__(
        self, document: GltfDocument, assets: AssetRoot | None, share: Callable[[Texture], str] | None = None
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
            self._textured.append(self._write(table, material))
        return number, self._textured[number]

    def _write(self, table: Materials, material: int) -> bool:
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
            "name": self._numbers.name(table, material),
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


def _share(value: float) -> float:
    return min(max(float(value), 0.0), 1.0)
