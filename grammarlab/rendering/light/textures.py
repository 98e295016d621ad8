"""Pictures on triangles: their colours, and their transparent parts, which are holes."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from io import BytesIO
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import AnyFloats
from grammarlab.assets.srgb import linear_from_srgb
from grammarlab.errors import UsageError
from grammarlab.rendering.light.box_tree import AbstractScene, Hits
from grammarlab.scene import TriangleBatch
from grammarlab.scene.triangles import texture_coordinates

if TYPE_CHECKING:
    from PIL import Image

_HOLE = 0.5
"""Opacity of a picture below which there is a hole, as in glTF's MASK."""
_MOST_PIXELS = 1 << 24
"""Largest number of pixels of all pictures of a model together; each is in memory as four 32-bit numbers."""
_MOST_HOLES = 48
"""Largest number of holes along a ray; behind them is nothing."""
_NEXT = np.float32(1e-4)
"""Distance behind a hole, in model units, from which a ray goes on."""


@dataclass(frozen=True, slots=True)
class Skin:
    """Pictures on T triangles."""

    pictures: tuple[tuple[NDArray[np.float32], ...], ...]
    """Linear colour and opacity [H, W, 4] of each picture, at full size, half size, a quarter, and so on."""
    coordinates: NDArray[np.float32]
    """[T, 3, 2] u and v at the corners, v upwards."""
    picture: NDArray[np.int32]
    """[T] index into `pictures`, -1 for none."""
    size: NDArray[np.int8]
    """[T] which size of the picture."""
    perforated: NDArray[np.bool_]
    """[T] whether transparent parts of the picture are holes."""

    def take(self, triangles: NDArray[np.bool_]) -> Skin:
        """The pictures of selected triangles."""
        return Skin(
            pictures=self.pictures,
            coordinates=self.coordinates[triangles],
            picture=self.picture[triangles],
            size=self.size[triangles],
            perforated=self.perforated[triangles],
        )

    def colors(self, hits: Hits) -> NDArray[np.float32]:
        """[N, 4] linear colour and opacity of the pictures at hits; white where there is none, or no hit."""
        colors = np.ones((len(hits.triangle), 4), np.float32)
        rows = np.flatnonzero(hits.triangle >= 0)
        rows = rows[self.picture[hits.triangle[rows]] >= 0]
        triangle = hits.triangle[rows]
        u, v = hits.u[rows, None], hits.v[rows, None]
        corners = self.coordinates[triangle]
        points = (1 - u - v) * corners[:, 0] + u * corners[:, 1] + v * corners[:, 2]
        kinds = self.picture[triangle] * np.int32(64) + self.size[triangle]
        for kind in np.unique(kinds).tolist():
            chosen = np.flatnonzero(kinds == kind)
            picture = self.pictures[kind // 64][kind % 64]
            height, width = picture.shape[:2]
            column = np.floor(points[chosen, 0] * width).astype(np.int64) % width
            row = np.floor(-points[chosen, 1] * height).astype(np.int64) % height
            colors[rows[chosen]] = picture[row, column]
        return colors

    def holes(self, hits: Hits) -> NDArray[np.bool_]:
        """[N] whether rays pass through a hole where they hit."""
        flags = np.zeros(len(hits.triangle), dtype=bool)
        rows = np.flatnonzero(hits.triangle >= 0)
        rows = rows[self.perforated[hits.triangle[rows]]]
        part = Hits(hits.triangle[rows], hits.distance[rows], hits.u[rows], hits.v[rows])
        flags[rows] = self.colors(part)[:, 3] < _HOLE
        return flags


class PerforatedTriangles(AbstractScene):
    """Triangles with holes.

    Args:
        scene: the triangles.
        skin: their pictures.
    """

    def __init__(self, scene: AbstractScene, skin: Skin) -> None:
        self._scene = scene
        self._skin = skin

    def first_hit(self, origins: AnyFloats, directions: AnyFloats) -> Hits:
        """See `AbstractScene.first_hit`."""
        hits = self._scene.first_hit(origins, directions)
        columns = hits.triangle.copy(), hits.distance.copy(), hits.u.copy(), hits.v.copy()
        active = np.flatnonzero(self._skin.holes(hits))
        for _ in range(_MOST_HOLES):
            if len(active) == 0:
                break
            passed = columns[1][active] + _NEXT
            onwards = directions[active]
            part = self._scene.first_hit(origins[active] + passed[:, None] * onwards, onwards)
            hit = part.triangle, passed + part.distance, part.u, part.v
            for column, values in zip(columns, hit, strict=True):
                column[active] = values
            active = active[self._skin.holes(part)]
        columns[0][active], columns[1][active] = -1, np.inf
        return Hits(*columns)

    def is_blocked(self, origins: AnyFloats, directions: AnyFloats, reach: float | None) -> NDArray[np.bool_]:
        """See `AbstractScene.is_blocked`."""
        hits = self.first_hit(origins, directions)
        blocked = hits.triangle >= 0
        return blocked if reach is None else blocked & (hits.distance <= reach)


def skin_of(batch: TriangleBatch, spacing: AnyFloats | float = 0.0) -> Skin | None:
    """The pictures of a model that travel with it; None if there are none.

    Args:
        batch: one model.
        spacing: [T] metres between neighbouring samples on each triangle: what is seen as one colour.

    Raises:
        UsageError: If a picture cannot be read.
    """
    table = batch.materials
    names = [name for name in dict.fromkeys(table.textures) if name in table.pictures]
    if not names:
        return None
    material = batch.material_of_triangle()
    index_of_name = {name: index for index, name in enumerate(names)}
    picture_of_material = np.array([index_of_name.get(name, -1) for name in table.textures], np.int32)
    pictures = _pyramids(names, table.pictures)
    picture = picture_of_material[material]
    is_cut_out = np.array([name in table.cut_out for name in names])
    has_holes = is_cut_out & np.array([bool((levels[0][:, :, 3] < _HOLE).any()) for levels in pictures])
    coordinates = texture_coordinates(batch, slice(0, len(batch.triangles))) * np.array([1.0, -1.0], np.float32)
    shape = np.array([levels[0].shape[:2] for levels in pictures], np.float64)
    most = np.array([len(levels) - 1 for levels in pictures])
    texels = np.sqrt(_areas(coordinates) * shape.prod(axis=1)[picture])
    extent = np.sqrt(_areas(batch.vertices[batch.triangles]))
    size = np.log2(np.maximum(texels * spacing / np.maximum(extent, 1e-12), 1.0))
    return Skin(
        pictures=pictures,
        coordinates=coordinates,
        picture=picture,
        size=np.clip(np.rint(size), 0, most[picture]).astype(np.int8),
        perforated=(picture >= 0) & has_holes[picture],
    )


def has_holes(batch: TriangleBatch) -> bool:
    """Whether pictures that travel with a model have transparent parts."""
    names = batch.materials.cut_out & batch.materials.pictures.keys()
    skin = skin_of(batch) if names else None
    return skin is not None and bool(skin.perforated.any())


def _areas(corners: AnyFloats) -> NDArray[np.float64]:
    """[T] twice the areas of triangles [T, 3, 2 or 3]."""
    first, second = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    if corners.shape[2] == 2:
        return np.abs(first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]).astype(np.float64)
    return np.linalg.norm(np.cross(first, second), axis=1).astype(np.float64)


def _pyramids(names: list[str], pictures: Mapping[str, bytes]) -> tuple[tuple[NDArray[np.float32], ...], ...]:
    """Pictures at full size, half size, and so on down to one pixel across."""
    # Imported here, since most models have no pictures.
    from PIL import Image  # noqa: PLC0415

    pyramids = []
    most_pixels = _MOST_PIXELS // len(names)
    for name in names:
        try:
            with Image.open(BytesIO(pictures[name]), formats=("PNG", "JPEG")) as image:
                pixels = np.asarray(_reduced(image.convert("RGBA"), most_pixels), np.float32) / np.float32(255.0)
        except (OSError, ValueError, SyntaxError) as error:
            raise UsageError(f"the picture {name!r} cannot be drawn: {error}") from error
        pixels = np.concatenate([linear_from_srgb(pixels[:, :, :3]), pixels[:, :, 3:]], axis=2).astype(np.float32)
        levels = [pixels]
        while min(levels[-1].shape[:2]) > 1:
            height, width = (2 * (side // 2) for side in levels[-1].shape[:2])
            halves = levels[-1][:height, :width].reshape(height // 2, 2, width // 2, 2, 4)
            levels.append(halves.mean(axis=(1, 3), dtype=np.float32))
        pyramids.append(tuple(levels))
    return tuple(pyramids)


def _reduced(image: Image.Image, most_pixels: int) -> Image.Image:
    """An image, in a smaller size if it has more pixels."""
    factor = math.ceil(math.sqrt(image.width * image.height / most_pixels))
    return image if factor <= 1 else image.reduce(factor)
