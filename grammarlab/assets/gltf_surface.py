"""Materials, normals and texture coordinates of glTF primitives (glTF 2.0, sections 3.7.2 and 3.9)."""

from __future__ import annotations

import math
from typing import Any
from urllib.parse import unquote

import numpy as np

from grammarlab.arrays import Floats
from grammarlab.assets.gltf_data import Accessors, GltfDocument, parse_document
from grammarlab.assets.image_paths import INSIDE
from grammarlab.assets.mesh_parts import PartMaterial, color_of
from grammarlab.errors import AssetError

_WHITE = (1.0, 1.0, 1.0, 1.0)
_MOST_SETS = 10
"""Largest number of sets of texture coordinates that is read: those of CGA."""
_TRANSFORM = "KHR_texture_transform"
_GLOSS = "KHR_materials_pbrSpecularGlossiness"


def material_of(primitive: dict[str, Any], document: GltfDocument) -> PartMaterial | None:
    """Material of a primitive; None if it has none.

    Raises:
        ValueError: If it refers to a material that does not exist.
    """
    if "material" not in primitive:
        return None
    material = document.entry("materials", primitive["material"])
    metal = material.get("pbrMetallicRoughness", {})
    gloss = material.get("extensions", {}).get(_GLOSS, {})
    factor = metal.get("baseColorFactor") or gloss.get("diffuseFactor")
    color = color_of(_WHITE if factor is None else factor)
    glow = color_of(material.get("emissiveFactor", (0.0, 0.0, 0.0))) or (0.0, 0.0, 0.0, 1.0)
    texture = _texture_of(material)
    return PartMaterial(
        _WHITE if color is None else color,
        "" if texture is None else _image_name(texture, document),
        metallic=0.0 if gloss else _share(metal.get("metallicFactor", 1.0)),
        roughness=1.0 - _share(gloss.get("glossinessFactor", 1.0))
        if gloss
        else _share(metal.get("roughnessFactor", 1.0)),
        emissive=glow[:3],
        is_cut_out=material.get("alphaMode", "OPAQUE") != "OPAQUE",
    )


def corner_values(
    primitive: dict[str, Any], num_points: int, document: GltfDocument, accessors: Accessors
) -> tuple[Floats | None, tuple[Floats, ...]]:
    """Normals [P, 3] and texture coordinates [P, 2] of the points of a primitive, those of its image first.

    Coordinates are as the image needs them, with v upwards.

    Raises:
        ValueError: If their number is not that of the points.
    """
    attributes = primitive["attributes"]
    normals = accessors.floats(attributes["NORMAL"], 3) if "NORMAL" in attributes else None
    sets: list[Floats] = []
    while f"TEXCOORD_{len(sets)}" in attributes and len(sets) < _MOST_SETS:
        sets.append(accessors.floats(attributes[f"TEXCOORD_{len(sets)}"], 2))
    for values in (*sets, *([] if normals is None else [normals])):
        if len(values) != num_points:
            raise ValueError(f"a primitive has {num_points} points and {len(values)} normals or texture coordinates")
    texture = _texture_of(document.entry("materials", primitive["material"])) if "material" in primitive else None
    if texture is not None and sets:
        transform = texture.get("extensions", {}).get(_TRANSFORM, {})
        number = transform.get("texCoord", texture.get("texCoord", 0))
        first = sets.pop(number) if isinstance(number, int) and 0 <= number < len(sets) else sets.pop(0)
        sets.insert(0, _transformed(first, transform))
    return normals, tuple(values * (1.0, -1.0) + (0.0, 1.0) for values in sets)


def image_inside(content: bytes, number: int) -> bytes:
    """Content of an image inside a glTF or GLB file.

    Args:
        content: the whole file.
        number: index of the image.

    Raises:
        AssetError: If the file has no such image, or refers to other files for it.
    """
    try:
        document = parse_document(content, _no_neighbours)
        return document.image(number)
    except (ValueError, TypeError, LookupError, AttributeError) as error:
        raise AssetError(f"it has no image {number}: {error or type(error).__name__}") from error


def _no_neighbours(name: str) -> bytes:
    raise AssetError(f"the image lies in the file {name[:100]!r}")


def _texture_of(material: dict[str, Any]) -> dict[str, Any] | None:
    """Reference to the image of the main color; None for none."""
    gloss = material.get("extensions", {}).get(_GLOSS, {})
    return material.get("pbrMetallicRoughness", {}).get("baseColorTexture") or gloss.get("diffuseTexture")


def _image_name(texture: dict[str, Any], document: GltfDocument) -> str:
    """Image in the words of `PartMaterial.texture`; empty for one in a form that is not read."""
    source = document.entry("textures", texture.get("index")).get("source")
    if source is None:
        return ""
    uri = document.entry("images", source).get("uri")
    return f"{INSIDE}{source}" if uri is None or uri.startswith("data:") else unquote(uri)


def _transformed(coordinates: Floats, transform: dict[str, Any]) -> Floats:
    """Coordinates [P, 2] with v downwards, moved by ``KHR_texture_transform``."""
    if not transform:
        return coordinates
    scale, offset = (
        np.array(transform.get(key, other), float) for key, other in (("scale", [1, 1]), ("offset", [0, 0]))
    )
    angle = float(transform.get("rotation", 0.0))
    if scale.shape != (2,) or offset.shape != (2,) or not np.isfinite([*scale, *offset, angle]).all():
        raise ValueError(f"{_TRANSFORM} expects a scale and an offset of two numbers and a rotation")
    turn = np.array([[math.cos(angle), math.sin(angle)], [-math.sin(angle), math.cos(angle)]])
    return coordinates * scale @ turn.T + offset


def _share(value: object) -> float:
    """A number clipped to 0..1; 1 for other values."""
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        return 1.0
    return min(max(float(value), 0.0), 1.0)
