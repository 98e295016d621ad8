"""Trees as cards: two crossed upright rectangles with pictures of the tree from two sides.

A card is split along the trunk, where the two meet, so that programs which sort triangles by distance draw them right.
"""

from __future__ import annotations

from hashlib import blake2b
from io import BytesIO

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import Floats, offsets_from_counts
from grammarlab.geometry.meshes.mesh import Meshes
from grammarlab.rendering.camera import Camera
from grammarlab.rendering.light.look import Look as Light
from grammarlab.rendering.raycast import RaycastRenderer
from grammarlab.rendering.renderer import RenderOptions
from grammarlab.scene import Scene, TriangleBatch, triangles
from grammarlab.scene.instances import PointSurface, scene_of_model
from grammarlab.trees.tree_materials import card_materials

PIXELS = 256
"""Pixels along the longest side of a card."""
_GAP = 2
"""Transparent pixels between the two pictures and around them, so that they do not mix in smaller sizes."""
_LIGHT = Light(
    sun=(0.9, 0.86, 0.78),
    sky=(1.05, 1.05, 1.05),
    horizon=(1.0, 1.0, 1.0),
    ground=(0.9, 0.9, 0.88),
    bounce=0.35,
    exposure=0.62,
    shoulder=0.8,
)
"""Soft light from all sides, since programs light cards once more."""
_MIDDLE = np.array([0.0, 0.6, 0.8])
_ROUND = np.array([-0.6, 0.6, np.sqrt(0.28)])
"""Normals at the trunk and at the left of a card (right, up and backward): rounded, so that both are lit alike."""
_VIEWS = (
    np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]),
    np.array([[0.0, 0.0, -1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]]),
)
"""Directions right, up and backward of the pictures: from the front and from the right."""


def card_scene(scene: Scene) -> Scene:
    """Cards with pictures of the models of a scene, which all have triangles; the pictures travel with the cards."""
    num = scene.num_models
    names: list[str] = []
    pictures: dict[str, bytes] = {}
    parts: list[tuple[Floats, Floats, Floats]] = []
    for model in range(num):
        batch = triangles(scene_of_model(scene, model))
        content, points, normals, coordinates = _card(batch)
        name = f"card_{blake2b(content, digest_size=8).hexdigest()}.png"
        pictures[name] = content
        names.append(name)
        parts.append((points, normals, coordinates))
    rows = {name: row for row, name in enumerate(pictures)}
    num_points = len(_VIEWS) * 6
    corners = np.concatenate([_CARD + 6 * view for view in range(len(_VIEWS))])
    counts = np.full(num, len(corners))
    empty = np.zeros((0, 3)), np.zeros((0, 3)), np.zeros((0, 2))
    points, normals, coordinates = (np.concatenate(column) for column in zip(empty, *parts, strict=True))
    meshes = Meshes(
        points=points,
        corners=np.tile(corners.ravel(), num),
        face_offsets=3 * np.arange(num * len(corners) + 1),
        mesh_faces=offsets_from_counts(counts),
        mesh_points=offsets_from_counts(np.full(num, num_points)),
        tags=np.zeros(num * len(corners), np.int8),
    )
    index = np.arange(num, dtype=np.int32)
    return Scene(
        num_models=num,
        meshes=meshes,
        materials=card_materials(pictures),
        model=index,
        mesh=index,
        material=np.array([rows[name] for name in names], dtype=np.int32),
        position=np.zeros((num, 3)),
        size=np.ones((num, 3)),
        frame=np.zeros(num, np.int32),
        frames=np.eye(3)[None],
        texture_map=np.full(num, -1, np.int32),
        texture_maps=np.zeros((0, 2, 4)),
        origins=scene.origins,
        surface=PointSurface(normals, coordinates),
    )


_CARD = np.array([[0, 1, 4], [0, 4, 3], [1, 2, 5], [1, 5, 4]])
"""Triangles of a card whose points are at the left, on the trunk and at the right: first below, then above."""


def _card(batch: TriangleBatch) -> tuple[bytes, Floats, Floats, Floats]:
    """The picture of a model from both sides, and points, normals [12, 3] and texture coordinates [12, 2]."""
    low, high = batch.vertices.min(axis=0).astype(np.float64), batch.vertices.max(axis=0).astype(np.float64)
    scale = PIXELS / max(float((high - low).max()), 1e-6)
    images, points, normals, spans = [], [], [], []
    for axes in _VIEWS:
        ends = np.stack([low, high]) @ axes.T
        left, right = ends[:, 0].min(), ends[:, 0].max()
        middle = np.clip(0.0, left, right)
        images.append(_picture(batch, axes, (left, right), (low[1], high[1]), scale))
        across = np.tile([left, middle, right], 2)
        up = np.repeat([low[1], high[1]], 3)
        points.append(across[:, None] * axes[0] + up[:, None] * axes[1])
        normals.append(np.stack([_ROUND @ axes, _MIDDLE @ axes, _ROUND * (-1.0, 1.0, 1.0) @ axes] * 2))
        spans.append(np.stack([(across - left) / max(right - left, 1e-9), np.repeat([0.0, 1.0], 3)], axis=1))
    height = images[0].shape[0] + 2 * _GAP
    width = sum(image.shape[1] for image in images) + 3 * _GAP
    atlas = np.zeros((height, width, 4), np.uint8)
    start, coordinates = _GAP, []
    for image, span in zip(images, spans, strict=True):
        atlas[_GAP:-_GAP, start : start + image.shape[1]] = image
        u = (start + span[:, 0] * image.shape[1]) / width
        v = (_GAP + span[:, 1] * image.shape[0]) / height
        coordinates.append(np.stack([u, v], axis=1))
        start += image.shape[1] + _GAP
    return _png(atlas), np.concatenate(points), np.concatenate(normals), np.concatenate(coordinates)


def _picture(
    batch: TriangleBatch, axes: Floats, across: tuple[float, float], up: tuple[float, float], scale: float
) -> NDArray[np.uint8]:
    """[H, W, 4] the model seen by a parallel camera whose picture has the given sides, in metres."""
    width, height = (max(1, round(scale * float(end - start))) for start, end in (across, up))
    options = RenderOptions(width=width, height=height, samples=3, openness_rays=2, look=_LIGHT)
    depth = batch.vertices.astype(np.float64) @ axes[2]
    position = np.array([sum(across) / 2, sum(up) / 2, depth.max() + np.ptp(depth) + 1.0]) @ axes
    half_height = max(up[1] - up[0], (across[1] - across[0]) * height / width, 1e-6) / 2
    picture = RaycastRenderer().cut_out(batch, Camera(position, axes, half_height, parallel=True), options)
    picture[:, :, 3] = _cut(picture[:, :, 3])
    return picture


def _cut(coverage: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Opacity [H, W] whose pixels above one half are as many as the tree covers, so that thin twigs do not vanish."""
    share = coverage.mean() / 255.0
    threshold = max(float(np.quantile(coverage, 1.0 - share)), 1.0) if share > 0.0 else 128.0
    return np.rint(np.minimum(coverage * (128.0 / threshold), 255.0)).astype(np.uint8)


def _png(picture: NDArray[np.uint8]) -> bytes:
    """A PNG file of a picture [H, W, 4]."""
    from PIL import Image  # noqa: PLC0415 - few scenes have cards

    content = BytesIO()
    Image.fromarray(picture).save(content, "PNG", optimize=True)
    return content.getvalue()
