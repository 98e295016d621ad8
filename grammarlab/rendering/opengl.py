"""Depths, normals and materials seen by a camera, by OpenGL. The only file that imports pyrender."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import AnyFloats
from grammarlab.errors import UsageError
from grammarlab.rendering.camera import Camera
from grammarlab.rendering.light.surfaces import ShadedModel
from grammarlab.scene import TriangleBatch

_VARIABLE = "PYOPENGL_PLATFORM"
"""Environment variable of PyOpenGL and pyrender for the kind of context."""


@dataclass(frozen=True, slots=True)
class Buffers:
    """Surfaces seen by the samples [H, W] of a picture."""

    material: NDArray[np.int32]
    """[H, W] row of the material columns, -1 for none."""
    depth: AnyFloats
    """[H, W] distance from the plane of the camera."""
    normal: AnyFloats
    """[H, W, 3] shading normals, not of unit length."""


class Painter:
    """Groups of one model in OpenGL's memory.

    Args:
        pyrender: the library.
        platform: ``egl`` or ``osmesa``.
        batch: one model with at least one triangle.
        model: the model in the unit sphere.
    """

    def __init__(self, pyrender: ModuleType, platform: str, batch: TriangleBatch, model: ShadedModel) -> None:
        self._gl, self._platform = pyrender, platform
        self._scene = pyrender.Scene(bg_color=(0.5, 0.5, 0.5, 1.0))
        self._group_material = batch.group_material
        self._nodes = [self._add_group(batch, model, group) for group in range(len(batch.group_material))]
        self._renderer: Any = None

    def buffers(self, camera: Camera, width: int, height: int, groups: NDArray[np.bool_]) -> Buffers:
        """Samples of groups [G] seen by a camera in model units."""
        flags, node = self._gl.RenderFlags, self._look_through(camera, width / height)
        numbers = {
            self._nodes[group]: _bytes_of(int(self._group_material[group]) + 1) for group in np.flatnonzero(groups)
        }
        self._show(groups)
        number, depth = self._render(width, height, flags.SEG, numbers)
        normal, _ = self._render(width, height, flags.FLAT)
        self._scene.remove_node(node)
        material = number.astype(np.int32) @ np.array([65536, 256, 1], np.int32) - 1
        return Buffers(material, _linear(depth, camera), normal.astype(np.float32) / np.float32(127.5) - 1)

    def depths(self, camera: Camera, side: int, groups: NDArray[np.bool_]) -> AnyFloats:
        """[side, side] distance of groups [G] from the plane of a camera, 0 for nothing."""
        flags, node = self._gl.RenderFlags, self._look_through(camera, 1.0)
        self._show(groups)
        depth = self._render(side, side, flags.DEPTH_ONLY)
        self._scene.remove_node(node)
        return _linear(depth, camera)

    def close(self) -> None:
        """Free the memory of OpenGL."""
        if self._renderer is not None:
            self._renderer.delete()
            self._renderer = None

    def _add_group(self, batch: TriangleBatch, model: ShadedModel, group: int) -> Any:
        vertices = slice(*batch.group_vertices[group : group + 2])
        triangles = slice(*batch.group_triangles[group : group + 2])
        indices = batch.triangles[triangles] - np.uint32(vertices.start)
        primitive = self._gl.Primitive(
            positions=model.vertices[vertices],
            color_0=batch.normals[vertices] * np.float32(0.5) + np.float32(0.5),
            # Both orientations: pyrender culls back faces for all flags and materials.
            indices=np.concatenate([indices, indices[:, ::-1]]),
            material=self._gl.MetallicRoughnessMaterial(baseColorFactor=(1.0, 1.0, 1.0, 1.0)),
        )
        return self._scene.add(self._gl.Mesh([primitive]))

    def _look_through(self, camera: Camera, aspect: float) -> Any:
        near, far = _range(camera)
        if camera.parallel:
            lens = self._gl.OrthographicCamera(camera.half_height * aspect, camera.half_height, near, far)
        else:
            lens = self._gl.PerspectiveCamera(2 * np.arctan(camera.half_height), near, far, aspectRatio=aspect)
        pose = np.eye(4)
        pose[:3, :3], pose[:3, 3] = camera.axes.T, camera.position
        node = self._scene.add(lens, pose=pose)
        self._scene.main_camera_node = node
        return node

    def _show(self, groups: NDArray[np.bool_]) -> None:
        for node, is_visible in zip(self._nodes, groups.tolist(), strict=True):
            node.mesh.is_visible = is_visible

    def _render(self, width: int, height: int, flags: int, numbers: dict[Any, Any] | None = None) -> Any:
        with _platform(self._platform):
            if self._renderer is None:
                self._renderer = self._gl.OffscreenRenderer(width, height)
            self._renderer.viewport_width, self._renderer.viewport_height = width, height
            return self._renderer.render(self._scene, flags, numbers)


@contextmanager
def painter(platform: str, batch: TriangleBatch, model: ShadedModel) -> Iterator[Painter]:
    """A painter for one model; its memory is freed at the end.

    Raises:
        UsageError: If pyrender is not installed.
    """
    new_painter = Painter(_pyrender(platform), platform, batch, model)
    try:
        yield new_painter
    finally:
        new_painter.close()


def driver(platform: str) -> str:
    """Name and version of the OpenGL driver, such as ``llvmpipe (LLVM 15.0.6, 256 bits), 4.5 ...``."""
    pyrender = _pyrender(platform)
    with _platform(platform):
        renderer = pyrender.OffscreenRenderer(1, 1)
        try:
            from OpenGL import GL  # noqa: PLC0415

            return ", ".join((GL.glGetString(name) or b"?").decode() for name in (GL.GL_RENDERER, GL.GL_VERSION))
        finally:
            renderer.delete()


def _pyrender(platform: str) -> ModuleType:
    try:
        with _platform(platform):
            import pyrender  # noqa: PLC0415
    except ImportError as error:
        raise UsageError(
            "OpenGL pictures need pyrender: pip install 'grammarlab[gl]', or choose the renderer 'cast', "
            f"which needs nothing else ({error})."
        ) from error
    return pyrender


@contextmanager
def _platform(name: str) -> Iterator[None]:
    """Let PyOpenGL and pyrender make contexts of one kind, and restore the environment."""
    before = os.environ.get(_VARIABLE)
    os.environ[_VARIABLE] = name
    try:
        yield
    finally:
        if before is None:
            del os.environ[_VARIABLE]
        else:
            os.environ[_VARIABLE] = before


def _bytes_of(number: int) -> tuple[int, int, int]:
    return number >> 16 & 255, number >> 8 & 255, number & 255


def _range(camera: Camera) -> tuple[float, float]:
    """Nearest and farthest depth of anything in the unit sphere."""
    middle = float(camera.position @ camera.axes[2])
    return max(middle - 1.01, 1e-3), middle + 1.01


def _linear(depth: AnyFloats, camera: Camera) -> AnyFloats:
    """Depths in model units; pyrender assumes a perspective camera."""
    if not camera.parallel:
        return depth
    near, far = _range(camera)
    is_hit = depth > 0
    share = ((far + near) - 2 * near * far / np.where(is_hit, depth, 1)) / (far - near)
    return np.where(is_hit, near + (share + 1) / 2 * (far - near), 0).astype(np.float32)
