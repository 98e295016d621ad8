"""Materials as glTF metallic-roughness materials."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from grammarlab.derivation.materials import Materials
from grammarlab.export.gltf_document import GltfDocument
from grammarlab.export.textures import find_texture
from grammarlab.scene.color import linear_from_srgb

REPEAT = 10497


class GltfMaterials:
    """The materials of one document, each written when it is first asked for."""

    def __init__(self, document: GltfDocument, materials: Materials, assets: Path | None) -> None:
        self._document = document
        self._materials = materials
        self._assets = assets
        self._written: dict[int, tuple[int, bool]] = {}
        self._images: dict[str, int | None] = {}

    def index(self, material: int) -> tuple[int, bool]:
        """The index of a material in the document, and whether it needs texture coordinates.

        Args:
            material: row of the material table.

        Raises:
            AssetError: its texture is unusable.
        """
        if material not in self._written:
            self._written[material] = self._write(material)
        return self._written[material]

    def _write(self, material: int) -> tuple[int, bool]:
        table = self._materials
        base = linear_from_srgb(table.color[material]).tolist()
        opacity = float(np.clip(table.opacity[material], 0.0, 1.0))
        surface: dict[str, Any] = {
            "baseColorFactor": [*base, opacity],
            "metallicFactor": float(np.clip(table.metallic[material], 0.0, 1.0)),
            "roughnessFactor": float(np.clip(table.roughness[material], 0.0, 1.0)),
        }
        texture = self._texture(table.textures[material])
        if texture is not None:
            surface["baseColorTexture"] = {"index": texture}
        entry: dict[str, Any] = {
            "name": material_name(table, material),
            "pbrMetallicRoughness": surface,
            "doubleSided": True,
        }
        if opacity < 1.0:
            entry["alphaMode"] = "BLEND"
        emissive = linear_from_srgb(table.emissive[material])
        if emissive.any():
            entry["emissiveFactor"] = emissive.tolist()
        return self._document.add("materials", entry), texture is not None

    def _texture(self, name: str) -> int | None:
        if name not in self._images:
            found = find_texture(name, self._assets)
            if found is None:
                self._images[name] = None
            else:
                view = self._document.add_bytes(found.content)
                entry = {"name": found.name, "mimeType": found.mime, "bufferView": view}
                image = self._document.add("images", entry)
                self._images[name] = self._document.add("textures", {"source": image, "sampler": self._sampler()})
        return self._images[name]

    def _sampler(self) -> int:
        if not any(index is not None for index in self._images.values()):
            self._document.add("samplers", {"wrapS": REPEAT, "wrapT": REPEAT})
        return 0


def material_name(materials: Materials, material: int) -> str:
    """A name that is stable for equal tables: row and sRGB colour, as in ``material_3_b8a890``."""
    red, green, blue = np.rint(np.clip(materials.color[material], 0.0, 1.0) * 255).astype(int)
    return f"material_{material}_{red:02x}{green:02x}{blue:02x}"
