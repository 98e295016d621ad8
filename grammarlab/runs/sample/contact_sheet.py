"""Contact sheets: pictures of models in one format, in rows with captions below a heading."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

from grammarlab.asset_roots import AssetRoot
from grammarlab.errors import UsageError, check_type
from grammarlab.rendering.camera import Camera, View, frame, frame_alike, seen_aspect
from grammarlab.rendering.choice import RendererChoice
from grammarlab.rendering.renderer import RenderOptions
from grammarlab.runs.work.executors import SERIAL, AbstractExecutor
from grammarlab.scene import Scene, TriangleBatch, triangles
from grammarlab.scene.scene_pictures import with_pictures

Picture: TypeAlias = NDArray[np.uint8]
_Font: TypeAlias = ImageFont.FreeTypeFont | ImageFont.ImageFont
PAPER, INK, FAINT = (247, 247, 245), (52, 56, 62), (128, 132, 138)
"""Colours of the page, of primary text, and of secondary text."""
BORDER, GAP = 16, 10
"""Pixels around the page, and between pictures."""
_HEADING, _CAPTION = 34, 24
"""Pixels of height for a line of text."""
_LARGE, _SMALL = 18, 13
"""Sizes of type in pixels."""
_MIN_ASPECT, _MAX_ASPECT = 0.65, 1.6
"""Aspect ratio of the pictures, chosen for the models."""
_CAST = RendererChoice("cast")
_MAX_POINTS = 20_000
"""Number of points of a model that are kept until all models are framed, a budget."""
_MIN_PIXELS = 16
"""Smallest side of a picture in pixels."""


@dataclass(frozen=True, slots=True)
class SheetPage:
    """Layout of a page."""

    width: int
    """Pixels of one picture."""
    height: int
    columns: int
    rows: int

    def corner(self, index: int) -> tuple[int, int]:
        """Left and top of a picture."""
        row, column = divmod(index, self.columns)
        return (
            BORDER + column * (self.width + GAP),
            BORDER + _HEADING + row * (self.height + _CAPTION + GAP),
        )

    def size(self) -> tuple[int, int]:
        """Width and height of the page."""
        x, y = self.corner(self.rows * self.columns - 1)
        return x + self.width + BORDER, y + self.height + _CAPTION + BORDER


@dataclass(frozen=True, slots=True)
class Tiles:
    """Pictures of models."""

    width: int
    """Width of each picture in pixels."""
    height: int
    """Height of each picture in pixels."""
    pictures: tuple[Picture, ...]
    """Picture [height, width, 3] of each model."""
    extents: tuple[NDArray[np.float64], ...]
    """Width, height and depth [3] of each model in metres."""


def render(
    scene: Scene,
    *,
    columns: int = 0,
    pixels: int = 320,
    same_scale: bool = False,
    title: str = "",
    assets: AssetRoot | str | None = None,
    executor: AbstractExecutor = SERIAL,
) -> Image.Image:
    """All models of a scene side by side, each with its number.

    Args:
        scene: at least one model.
        columns: number of columns; 0 for about a square.
        pixels: approximate width and height of each model in pixels.
        same_scale: whether all models have the same scale; otherwise each model fills its cell.
        title: heading of the picture.
        assets: folder of the images on surfaces; without it, surfaces have their colours only.
        executor: draws the picture, which does not depend on it.

    Raises:
        UsageError: If the scene has no models, or pixels are fewer than 16.

    >>> import grammarlab as gl
    >>> forest = gl.derive(gl.Grammar.parse("Lot --> s(2, 0, 2) extrude(rand(1, 9)) Tower"), 2, seed=1)
    >>> gl.render(gl.realize(forest), pixels=40).mode
    'RGB'
    """
    check_type("scene", scene, Scene, "gl.realize(forest)")
    if not scene.num_models:
        raise UsageError("nothing to draw: the scene has no models.")
    if pixels < _MIN_PIXELS:
        raise UsageError(f"pixels: expected at least {_MIN_PIXELS}, found {pixels}.")
    batch = triangles(with_pictures(scene, Path(assets) if isinstance(assets, str) else assets))
    models = [batch.model(index) for index in range(scene.num_models)]
    tiles = draw_tiles(models, pixels * pixels, executor, same_scale=same_scale)
    page = lay_out(len(models), columns, tiles.width, tiles.height)
    captions = [(str(index), "") for index in range(len(models))]
    return Image.fromarray(draw_page(page, tiles.pictures, captions, (title, "")))


def draw_tiles(
    models: Iterable[TriangleBatch],
    area: int,
    executor: AbstractExecutor,
    *,
    same_scale: bool = False,
    choice: RendererChoice = _CAST,
) -> Tiles:
    """Draw each model separately.

    Args:
        models: one model in each; iterated twice, so that they need not be in memory together.
        area: approximate number of pixels of a picture; its aspect ratio suits most models.
        executor: draws the pictures, which do not depend on it.
        same_scale: whether all pictures have the same scale; otherwise each model fills its own.
        choice: the renderer.
    """
    points = [_outer_points(seen_points(model)) for model in models]
    view = View()
    width, height = _size(points, area, view)
    aspect = width / height
    cameras = (
        frame_alike(points, aspect, view)
        if same_scale
        else [frame(model_points, aspect, view) for model_points in points]
    )
    draw = partial(_draw, choice, RenderOptions(width=width, height=height))
    # OpenGL drivers use all cores by themselves.
    executor = SERIAL if choice.name == "gl" else executor
    pictures = executor.results(draw, map(_Task, models, cameras))
    extents = tuple(np.ptp(model_points.astype(np.float64), axis=0) for model_points in points)
    return Tiles(width, height, tuple(pictures), extents)


def seen_points(model: TriangleBatch) -> NDArray[np.float32]:
    """[n, 3] the vertices of a model; the origin for a model without any."""
    return model.vertices if len(model.vertices) else np.zeros((1, 3), np.float32)


def _outer_points(points: NDArray[np.float32]) -> NDArray[np.float32]:
    """The corners [n, 3] of the convex hull of many points [p, 3], which are framed alike; few points as they are."""
    if len(points) <= _MAX_POINTS:
        return points
    from scipy.spatial import ConvexHull, QhullError  # noqa: PLC0415  # few models are so large

    try:
        return points[np.sort(ConvexHull(points).vertices)]
    except QhullError:  # a flat model
        return points


def lay_out(num: int, columns: int, width: int, height: int) -> SheetPage:
    """A page for pictures of one size.

    Args:
        num: pictures, at least 1.
        columns: pictures side by side; 0 for a page that is about square.
        width: pixels of a picture.
        height: pixels of a picture.
    """
    best = min(columns, num) or min(range(1, num + 1), key=lambda count: _awkwardness(num, count, width, height))
    return SheetPage(width, height, best, math.ceil(num / best))


def draw_page(
    page: SheetPage, pictures: Sequence[Picture], captions: Sequence[tuple[str, str]], heading: tuple[str, str]
) -> Picture:
    """The whole page.

    Args:
        page: the layout.
        pictures: [height, width, 3] each.
        captions: below each picture, at its left and its right.
        heading: texts at the left and the right of the page; the right one is left out if it does not fit.
    """
    canvas = Image.new("RGB", page.size(), PAPER)
    draw, large, small = ImageDraw.Draw(canvas), ImageFont.load_default(_LARGE), ImageFont.load_default(_SMALL)
    _line(draw, (BORDER, canvas.width - BORDER), BORDER + _HEADING // 2 - 6, heading, (large, small))
    for index, (picture, caption) in enumerate(zip(pictures, captions, strict=True)):
        x, y = page.corner(index)
        canvas.paste(Image.fromarray(picture), (x, y))
        _line(draw, (x + 2, x + page.width - 2), y + page.height + _CAPTION // 2, caption, (small, small))
    return np.asarray(canvas)


def _size(points: Sequence[NDArray[np.float32]], area: int, view: View) -> tuple[int, int]:
    aspect = float(np.median([seen_aspect(model_points, view) for model_points in points]))
    aspect = min(max(aspect, _MIN_ASPECT), _MAX_ASPECT)
    return round(math.sqrt(area * aspect)), round(math.sqrt(area / aspect))


def _draw(choice: RendererChoice, options: RenderOptions, task: _Task) -> Picture:
    return choice.make().render(task.model, task.camera, options)


class _Task(NamedTuple):
    """A picture to draw."""

    model: TriangleBatch
    camera: Camera

    def __str__(self) -> str:
        return f"the picture of a model of {len(self.model.triangles):,} triangles"


def _awkwardness(num: int, columns: int, width: int, height: int) -> float:
    """Deviation of a page from a square without gaps."""
    rows = math.ceil(num / columns)
    shape = math.log(columns * (width + GAP) / (rows * (height + _CAPTION + GAP)))
    return abs(shape) + 4 * (rows * columns - num) / num


def _line(
    draw: ImageDraw.ImageDraw, between: tuple[int, int], middle: int, texts: tuple[str, str], fonts: tuple[_Font, _Font]
) -> None:
    """One text from the left in ink, one from the right, fainter and clipped to the remaining width."""
    start, end = between
    draw.text((start, middle), texts[0], INK, fonts[0], anchor="lm")
    room = end - start - draw.textlength(texts[0], fonts[0]) - GAP
    if draw.textlength(texts[1], fonts[1]) <= room:
        draw.text((end, middle), texts[1], FAINT, fonts[1], anchor="rm")
