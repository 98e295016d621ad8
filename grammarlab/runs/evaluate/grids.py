"""Grids of samples before and after learning, as in appendix B of the paper."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from grammarlab.derivation.derive import derive
from grammarlab.evaluation import protocol
from grammarlab.evaluation.preparation import Source, labelled_program
from grammarlab.evaluation.seeds import derived_seed
from grammarlab.runs.atomic import atomic_file
from grammarlab.runs.evaluate.task import Task, load_source, run_protocol
from grammarlab.runs.sheet_page import draw_page, lay_out
from grammarlab.runs.tiles import Tiles, draw_tiles
from grammarlab.scene import realize, triangles

SIZES = (4, 10)
"""Models along each side of a grid."""
TILE_AREA = 160 * 160
"""Pixels of the picture of one model."""
QUALITY = 85
"""Of JPEG files, 1 to 95."""
GRID_LANE = 3
"""Place below a curve's seed that the choice of samples has its seed from."""


def draw_grids(task: Task, folder: Path, jobs: int) -> dict[int, dict[str, Path]]:
    """Draw samples of the labelled set before learning and after all rounds of a task, with their true scores.

    A sample is a model of the labelled set, taken with a probability proportional to its weight; models may repeat.

    Args:
        task: a curve; it is made again to learn what it learned.
        folder: for the pictures, made when missing.
        jobs: processes; the pictures do not depend on it.

    Returns:
        ``F1-before-4x4.jpg`` and ``F1-after-4x4.jpg``, and the same with 10x10: by size, and then by stage.
    """
    material, state, curve = run_protocol(task)
    source = load_source(task.scenario)
    learned = material.weights * protocol.learned(material, state)
    stages = {
        "before": (material.weights, f"JS {material.js_original:.3f}"),
        "after": (
            learned if learned.any() else material.weights,
            f"{state.labels} labels, JS {curve.points[-1].js:.4f}",
        ),
    }
    folder.mkdir(parents=True, exist_ok=True)
    files: dict[int, dict[str, Path]] = {size: {} for size in SIZES}
    for size in SIZES:
        for stage, (weights, remark) in stages.items():
            models = choose(weights, size * size, task.seed)
            scores = [f"{100 * material.target[model]:.3g}" for model in models]
            heading = (f"{source.scenario.name} {stage}", remark)
            picture = _draw(source, models, scores, size, heading, jobs)
            files[size][stage] = folder / f"{source.scenario.name}-{stage}-{size}x{size}.jpg"
            save_picture(picture, files[size][stage])
    return files


def save_picture(picture: NDArray[np.uint8], path: Path) -> None:
    """Write pixels [height, width, 3] as JPEG, whole or not at all."""
    with atomic_file(path) as part:
        Image.fromarray(picture).save(part, "JPEG", quality=QUALITY)


def choose(weights: NDArray[np.float64], num_models: int, seed: int) -> list[int]:
    """Indices of models, each drawn on its own with a probability proportional to its weight.

    Args:
        weights: [n] >= 0, not all 0.
        num_models: how many to draw.
        seed: 0 <= seed < 2**64.
    """
    random = np.random.default_rng(derived_seed(seed, GRID_LANE))
    return random.choice(len(weights), num_models, p=weights / weights.sum()).tolist()


def _draw(
    source: Source, models: Sequence[int], scores: Sequence[str], columns: int, heading: tuple[str, str], jobs: int
) -> NDArray[np.uint8]:
    """The picture of labelled models."""
    tiles = tiles_of(source, models, jobs)
    page = lay_out(len(models), columns, tiles.width, tiles.height)
    return draw_page(page, tiles.pictures, [(score, "") for score in scores], heading)


def tiles_of(source: Source, models: Sequence[int], jobs: int) -> Tiles:
    """Pictures of labelled models, each rebuilt from its address; each fills its picture.

    Args:
        source: the scenario with its grammar.
        models: indices in the labelled set; repeats are drawn once.
        jobs: processes; the pictures do not depend on it.
    """
    program = labelled_program(source)
    different = sorted(set(models))
    forests = [derive(program, 1, source.scenario.seed, first_model=m, assets=source.assets) for m in different]
    tiles = draw_tiles([triangles(realize(forest)) for forest in forests], TILE_AREA, jobs)
    return replace(tiles, pictures=tuple(tiles.pictures[different.index(model)] for model in models))
