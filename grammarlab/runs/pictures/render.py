"""A scene as one picture."""

from __future__ import annotations

from PIL import Image

from grammarlab.errors import UsageError, check_type
from grammarlab.runs.pictures.sheet_page import draw_page, lay_out
from grammarlab.runs.pictures.tiles import draw_tiles
from grammarlab.runs.work.executors import SERIAL, AbstractExecutor
from grammarlab.scene import Scene, triangles

_FEWEST_PIXELS = 16


def render(
    scene: Scene,
    *,
    columns: int = 0,
    pixels: int = 320,
    same_scale: bool = False,
    title: str = "",
    executor: AbstractExecutor = SERIAL,
) -> Image.Image:
    """All models of a scene side by side, each with its number.

    Args:
        scene: at least one model.
        columns: number of columns; 0 for about a square.
        pixels: approximate width and height of each model in pixels.
        same_scale: whether all models have the same scale; otherwise each model fills its cell.
        title: heading of the picture.
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
    if pixels < _FEWEST_PIXELS:
        raise UsageError(f"pixels: expected at least {_FEWEST_PIXELS}, found {pixels}.")
    batch = triangles(scene)
    models = [batch.model(index) for index in range(scene.num_models)]
    tiles = draw_tiles(models, pixels * pixels, executor, same_scale=same_scale)
    page = lay_out(len(models), columns, tiles.width, tiles.height)
    captions = [(str(index), "") for index in range(len(models))]
    return Image.fromarray(draw_page(page, tiles.pictures, captions, (title, "")))
