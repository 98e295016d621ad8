"""Samples of several densities side by side in one picture."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Protocol

import numpy as np
from PIL import Image

from grammarlab.files import atomic_file
from grammarlab.runs.pictures.sheet_page import PAPER, draw_page, lay_out
from grammarlab.runs.pictures.tiles import draw_tiles
from grammarlab.runs.work.executors import AbstractExecutor
from grammarlab.scene import Scene, triangles

WIDTH = 900
"""Approximate width of the samples of one density in pixels."""
_MARGIN = 12


class Sampled(Protocol):
    """A density that can be drawn."""

    def scene(self, num: int, seed: int, /) -> Scene:
        """Samples, as meshes."""
        ...


def draw_side_by_side(
    shown: Sequence[tuple[str, Sampled]], file: Path, *, side: int, seed: int, executor: AbstractExecutor
) -> None:
    """Draw samples of densities side by side; each model fills its picture.

    Args:
        shown: headings and densities.
        file: the picture.
        side: number of models along each side of a grid.
        seed: seed of the models.
        executor: draws the picture, which does not depend on it.
    """
    number = side * side
    batches = [triangles(sampler.scene(number, seed)) for _, sampler in shown]
    models = [batch.model(index) for batch in batches for index in range(number)]
    tiles = draw_tiles(models, (WIDTH // side) ** 2, executor)
    layout = lay_out(number, side, tiles.width, tiles.height)
    pages = []
    for place, (name, _) in enumerate(shown):
        own = tiles.pictures[place * number :][:number]
        pages.append(draw_page(layout, own, [("", "")] * number, (name, f"{number} samples")))
    gap = np.full((pages[0].shape[0], _MARGIN, 3), PAPER, np.uint8)
    joined = [part for page in pages for part in (page, gap)][:-1]
    with atomic_file(file) as part:
        Image.fromarray(np.concatenate(joined, axis=1)).save(part, format="PNG")
