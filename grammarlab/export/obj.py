"""OBJ files with an MTL library: readable text, y up, metres."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from grammarlab.export.gltf_materials import material_name
from grammarlab.export.textures import find_texture
from grammarlab.scene import TriangleBatch
from grammarlab.scene.texture_coordinates import texture_coordinates


def obj_files(
    batch: TriangleBatch, names: list[str], offsets: NDArray[np.float64], stem: str, assets: Path | None = None
) -> dict[str, bytes]:
    """The files of an OBJ by name, in the order in which to write them: images, library, geometry.

    Args:
        batch: the models; each becomes an object, each of its materials a group of faces.
        names: [num_models] names of the objects.
        offsets: [num_models, 3] where each model stands, in metres.
        stem: name of the files without ending.
        assets: folder of the textures; None leaves them out.

    Raises:
        AssetError: a texture is unusable.
    """
    images, library = _library(batch, stem, assets)
    files = dict(images.values())
    files[f"{stem}.mtl"] = library
    lines = ["# grammarlab: metres, y up", f"mtllib {stem}.mtl"]
    moved = np.repeat(offsets, np.diff(batch.group_vertices[batch.model_groups]), axis=0)
    lines.append(_rows("v", batch.vertices + moved))
    lines.append(_rows("vn", batch.normals))
    num_coordinates = 0
    for model, name in enumerate(names):
        lines.append(f"o {name}")
        for group in range(*batch.model_groups[model : model + 2].tolist()):
            material = int(batch.group_material[group])
            triangles = slice(*batch.group_triangles[group : group + 2])
            rows = batch.triangles[triangles]
            lines.append(f"usemtl {material_name(batch.materials, material)}")
            corners = rows.astype(np.int64).ravel() + 1
            if material in images:
                coordinates = texture_coordinates(batch, triangles).reshape(-1, 2) * (1.0, -1.0)
                lines.append(_rows("vt", coordinates))
                texture = num_coordinates + 1 + np.arange(len(corners))
                num_coordinates += len(corners)
                lines.append(_faces("%d/%d/%d", np.stack([corners, texture, corners], axis=1)))
            else:
                lines.append(_faces("%d//%d", np.stack([corners, corners], axis=1)))
    files[f"{stem}.obj"] = ("\n".join(line for line in lines if line) + "\n").encode()
    return files


def _rows(keyword: str, values: NDArray[np.floating]) -> str:
    """One line a row; nine digits give back every 32-bit number exactly."""
    template = "\n".join([keyword + " %.9g" * values.shape[1]] * len(values))
    return template % tuple(values.ravel().tolist())


def _faces(corner: str, references: NDArray[np.int64]) -> str:
    """One line a triangle from the references of its corners [3 T, 2 or 3]."""
    template = "\n".join([f"f {corner} {corner} {corner}"] * (len(references) // 3))
    return template % tuple(references.ravel().tolist())


def _library(batch: TriangleBatch, stem: str, assets: Path | None) -> tuple[dict[int, tuple[str, bytes]], bytes]:
    """The image of each textured material (name and content), and the MTL text.

    Colours are written as sRGB, which is what programs that show OBJ files without colour management expect.
    """
    images: dict[int, tuple[str, bytes]] = {}
    lines = ["# grammarlab: colours are sRGB; Pr and Pm are roughness and metalness"]
    table = batch.materials
    for material in np.unique(batch.group_material).tolist():
        lines += [f"newmtl {material_name(table, material)}", "illum 2"]
        for keyword, color in (("Kd", table.color[material]), ("Ke", table.emissive[material])):
            lines.append(keyword + "".join(f" {value:.6g}" for value in np.clip(color, 0.0, 1.0)))
        lines.append(f"d {np.clip(table.opacity[material], 0.0, 1.0):.6g}")
        lines.append(f"Pr {np.clip(table.roughness[material], 0.0, 1.0):.6g}")
        lines.append(f"Pm {np.clip(table.metallic[material], 0.0, 1.0):.6g}")
        texture = find_texture(table.textures[material], assets)
        if texture is not None:
            name = f"{stem}_texture_{material}{texture.suffix}"
            images[material] = (name, texture.content)
            lines.append(f"map_Kd {name}")
    return images, ("\n".join(lines) + "\n").encode()
