"""Test of OpenGL that draws one small picture: a separate program, since drivers may crash or hang."""

from __future__ import annotations

import sys

import numpy as np

from grammarlab.derivation.materials import CHANNELS, Materials
from grammarlab.rendering.camera import View, frame
from grammarlab.rendering.opengl import driver
from grammarlab.rendering.rasterize import OpenGLRenderer
from grammarlab.rendering.renderer import RenderOptions
from grammarlab.scene import TriangleBatch

SIDE = 16


def main(platform: str) -> None:
    """Print the name of the driver, or fail.

    Raises:
        RuntimeError: If the picture is wrong.
    """
    batch = _triangle()
    options = RenderOptions(width=SIDE, height=SIDE)
    image = OpenGLRenderer(platform).render(batch, frame(batch.vertices, 1.0, View(azimuth=0.0)), options).astype(int)
    red, green, _ = image[SIDE // 2, SIDE // 2]
    if red < 2 * green or abs(image[0, 0, 0] - image[0, 0, 1]) > 40:
        raise RuntimeError("a red triangle came out in other colours")
    sys.stdout.write(driver(platform) + "\n")


def _triangle() -> TriangleBatch:
    """An upright red triangle that faces +z."""
    material = Materials(np.array([[*(CHANNELS | {"color.g": 0.0, "color.b": 0.0}).values()]]), ("",))
    zero, all_of_it = np.zeros(1, np.int32), np.array([0, 1])
    return TriangleBatch(
        num_models=1,
        materials=material,
        vertices=np.array([[-1, 0, 0], [1, 0, 0], [0, 2, 0]], np.float32),
        normals=np.array([[0, 0, 1]] * 3, np.float32),
        triangles=np.array([[0, 1, 2]], np.uint32),
        group_model=zero,
        group_material=zero,
        group_vertices=all_of_it * 3,
        group_triangles=all_of_it,
        model_groups=all_of_it,
        texture_map=np.full(1, -1, np.int32),
        texture_maps=np.zeros((0, 2, 4)),
        origins=np.zeros((1, 3)),
    )


if __name__ == "__main__":
    main(sys.argv[1])
