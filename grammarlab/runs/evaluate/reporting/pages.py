"""Pages of models with their true scores, as in appendix A of the paper."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from grammarlab.evaluation.pages import LikedModels, models_for_scores
from grammarlab.evaluation.preparation import Source
from grammarlab.runs.evaluate.reporting.grids import TILE_AREA, save_picture, tiles_of
from grammarlab.runs.pictures.sheet_page import PAPER, draw_page, lay_out
from grammarlab.runs.sampling.sources import load_source
from grammarlab.runs.work.executors import AbstractExecutor

COLUMNS = 8
"""Number of models of one group."""


def draw_examples(scenario: Path, folder: Path, executor: AbstractExecutor) -> Path:
    """Draw models of the labelled set for every case of a preference: a row per case, with its score and its meaning.

    Args:
        scenario: the scenario file.
        folder: folder for the picture; created if missing.
        executor: draws the picture, which does not depend on it.

    Returns:
        ``F1-scores.jpg``.

    Raises:
        GrammarlabError: If the scenario or its grammar has an error.
    """
    source = load_source(scenario)
    groups = [group for group in models_for_scores(source, COLUMNS) if group.models]
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / f"{source.scenario.name}-scores.jpg"
    save_picture(_draw(source, groups, executor), path)
    return path


def _draw(source: Source, groups: list[LikedModels], executor: AbstractExecutor) -> np.ndarray:
    tiles = tiles_of(source, [model for group in groups for model in group.models], TILE_AREA, executor)
    drawn = iter(tiles.pictures)
    blank = np.full((tiles.height, tiles.width, 3), PAPER, np.uint8)
    cells, captions = [], []
    for group in groups:
        empty = COLUMNS - len(group.models)
        cells += [*(next(drawn) for _ in group.models), *[blank] * empty]
        # Once per row, which has room for it: below one picture a long meaning would be cut.
        captions += [(f"{group.score:g}   {group.means}", "")] + [("", "")] * (COLUMNS - 1)
    heading = (f"{source.scenario.name}: models and their scores", source.scenario.title)
    return draw_page(lay_out(len(cells), COLUMNS, tiles.width, tiles.height), cells, captions, heading)
