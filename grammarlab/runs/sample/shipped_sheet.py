"""One picture with a model of each shipped file."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from PIL import Image

from grammarlab.files import atomic_file
from grammarlab.runs.sample.contact_sheet import draw_page, draw_tiles, lay_out
from grammarlab.runs.sample.domains import opened
from grammarlab.runs.sample.shipped import RuleSource
from grammarlab.runs.work.executors import AbstractExecutor
from grammarlab.scene import TriangleBatch, triangles
from grammarlab.scene.scene_pictures import with_pictures

_AREA = 220 * 220
"""Pixels of the picture of a model."""


def save_sheet(sources: Sequence[RuleSource], path: Path, executor: AbstractExecutor) -> None:
    """Draw the first model of each file to a PNG file, with the name of the file.

    Args:
        sources: the files, at least one.
        path: the PNG file.
        executor: draws the pictures, which do not depend on it.
    """
    tiles = draw_tiles([_first_model(source) for source in sources], _AREA, executor)
    page = lay_out(len(sources), 0, tiles.width, tiles.height)
    captions = [(source.name, "") for source in sources]
    picture = draw_page(page, tiles.pictures, captions, ("grammarlab", "the first model of each shipped file"))
    path.parent.mkdir(parents=True, exist_ok=True)
    with atomic_file(path) as part:
        Image.fromarray(picture).save(part, "PNG")


def _first_model(source: RuleSource) -> TriangleBatch:
    space = opened(source.suffix, source.text(), source.name, source.assets)
    return triangles(with_pictures(space.scene(1, 0), source.assets)).model(0)
