"""Grids of samples before and after learning, as in appendix B of the paper."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from grammarlab.evaluation.preparation import Source
from grammarlab.files import atomic_file
from grammarlab.runs.evaluate.samples import BeforeAfter
from grammarlab.runs.pictures.sheet_page import draw_page, lay_out
from grammarlab.runs.pictures.tiles import Tiles, draw_tiles
from grammarlab.runs.sampling.sources import load_source
from grammarlab.runs.work.executors import AbstractExecutor
from grammarlab.scene import triangles

TILE_AREA = 144 * 144
"""Number of pixels of the picture of one model."""
SIZES = {4: TILE_AREA, 10: TILE_AREA // 5}
"""Number of models along each side of a grid, and of pixels of the picture of each."""
QUALITY = 70
"""JPEG quality, 1 to 95, such that the pictures of all scenarios fit in a repository."""


def draw_grids(
    scenario: Path, samples: BeforeAfter, folder: Path, executor: AbstractExecutor
) -> dict[int, dict[str, Path]]:
    """Draw samples of the labelled set with their true scores.

    Args:
        scenario: the scenario file.
        samples: the samples; a small grid shows the first ones.
        folder: folder for the pictures; created if missing.
        executor: draws the pictures, which do not depend on it.

    Returns:
        ``F1-before-4x4.jpg`` and ``F1-after-4x4.jpg``, and the same with 10x10: by size, and then by stage.
    """
    source = load_source(scenario).for_person(samples.seed)
    name = source.scenario.name
    folder.mkdir(parents=True, exist_ok=True)
    stages = {
        "before": (samples.before, (f"{name} before learning", f"JS {samples.before.js:.3f}")),
        "after": (samples.after, (f"{name} after {samples.labels} labels", f"JS {samples.after.js:.4f}")),
    }
    files: dict[int, dict[str, Path]] = {size: {} for size in SIZES}
    for size, area in SIZES.items():
        num = size * size
        # Drawn together, so that pictures side by side have one shape.
        tiles = tiles_of(source, samples.before.models[:num] + samples.after.models[:num], area, executor)
        for index, (stage, (sample, heading)) in enumerate(stages.items()):
            captions = [(f"{score:.3g}", "") for score in sample.scores[:num]]
            page = lay_out(num, size, tiles.width, tiles.height)
            picture = draw_page(page, tiles.pictures[index * num : (index + 1) * num], captions, heading)
            files[size][stage] = folder / f"{name}-{stage}-{size}x{size}.jpg"
            save_picture(picture, files[size][stage])
    return files


def save_picture(picture: NDArray[np.uint8], path: Path) -> None:
    """Write pixels [height, width, 3] as JPEG, atomically."""
    with atomic_file(path) as part:
        Image.fromarray(picture).save(part, "JPEG", quality=QUALITY, optimize=True, progressive=True)


def tiles_of(source: Source, models: Sequence[int], area: int, executor: AbstractExecutor) -> Tiles:
    """Pictures of labelled models, each rebuilt from its address; each fills its picture.

    Args:
        source: the scenario with its grammar.
        models: indices in the labelled set; repeats are drawn once.
        area: approximate number of pixels of each picture.
        executor: draws the pictures, which do not depend on it.
    """
    different = sorted(set(models))
    batch = triangles(
        source.space.realize([source.labelled_address._replace(model=model) for model in different]).scene
    )
    tiles = draw_tiles([batch.model(index) for index in range(len(different))], area, executor)
    return replace(tiles, pictures=tuple(tiles.pictures[different.index(model)] for model in models))
