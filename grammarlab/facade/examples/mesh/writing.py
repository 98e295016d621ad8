"""Surfaces as GLB files: one primitive per material over shared points, so that closed surfaces are read as closed."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from grammarlab.facade.examples.mesh.surface import Surface
from grammarlab.files import write_bytes

Color = tuple[float, float, float, float]


def write_glb(surface: Surface, colors: Sequence[Color], path: Path) -> Path:
    """Write a surface, y up; without normals, so that points are not duplicated at edges.

    Args:
        surface: the surface.
        colors: colors of its materials.
        path: the file.
    """
    import trimesh  # noqa: PLC0415  # takes longer to import than most commands take
    from trimesh.visual import TextureVisuals  # noqa: PLC0415
    from trimesh.visual.material import PBRMaterial  # noqa: PLC0415

    scene: Any = trimesh.Scene()
    for number in np.unique(surface.material).tolist():
        part = surface.part(surface.material == number)
        material = PBRMaterial(
            name=f"material-{number}",
            baseColorFactor=[round(255 * each) for each in colors[number]],
            metallicFactor=0.0,
            roughnessFactor=0.8,
            doubleSided=True,
        )
        visual = TextureVisuals(material=material)
        mesh = trimesh.Trimesh(part.points, part.triangles, visual=visual, process=False)
        scene.add_geometry(mesh, geom_name=f"part-{number}", node_name=f"part-{number}")
    content = scene.export(file_type="glb")
    write_bytes(path, content)
    return path
