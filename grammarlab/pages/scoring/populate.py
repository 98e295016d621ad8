"""Choice of the next models, laid out in grids."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from grammarlab.pages.record.events import Record
from grammarlab.pages.record.model_grids import PAIRS, GridLayout, ModelGrid
from grammarlab.pages.scoring.knowledge import ModelPool

NUM_PAIRS = 8
"""Number of models that are chosen at once."""
WAYS = {
    "default": "half are predicted to be liked, to find mistakes; half are the most informative",
    "uniform": "as different as possible from each other and from all scored models",
    "grammar": "plain samples, whatever was scored",
    "density": "samples of the learned density, and beside them models that it avoids",
    "uncertainty": "models with the most uncertain predictions",
    "already ranked": "scored before, the most surprising scores first, to check for mistakes",
    PAIRS: "two at a time, to choose the one that you prefer",
}
"""Query strategies of `grammarlab.preference.queries`, and pairs, in words."""

_TITLES = {
    "default": ("may be liked", "most informative"),
    "density": ("liked", "not liked"),
    "uniform": ("different", ""),
    "grammar": ("samples", ""),
    "uncertainty": ("uncertain", ""),
    "already ranked": ("scored before", ""),
    PAIRS: ("this one", "that one"),
}


def number_to_choose(way: str, layout: GridLayout) -> int:
    """Number of models to choose for all grids; for pairs, of consecutive ones."""
    if way == PAIRS:
        return 2 * NUM_PAIRS
    # A density is chosen together with its complement, which does not fit into one grid.
    return 2 * layout.models if way == "density" and layout.grids == 1 else layout.models


def laid_out(way: str, models: Sequence[str], layout: GridLayout) -> list[ModelGrid]:
    """Grids of chosen models.

    Args:
        way: their strategy.
        models: models, at most `number_to_choose`.
        layout: number and size of grids.
    """
    titles, size = _TITLES[way], layout.rows * layout.columns
    if way == PAIRS:
        return [ModelGrid(title, tuple(models[side : len(models) // 2 * 2 : 2])) for side, title in enumerate(titles)]
    half = (len(models) + 1) // 2 if layout.grids == 2 and way in ("default", "density") else size
    parts = (models[:half], models[half:])
    return [ModelGrid(title, tuple(part[:size])) for title, part in zip(titles[: layout.grids], parts, strict=False)]


def fresh_samples(pool: ModelPool, record: Record, num: int) -> list[str]:
    """Samples of the grammar that were never shown, then shown ones without a score.

    Args:
        pool: the pool; its samples are independent, so any of them follow the grammar.
        record: shown and scored models.
        num: number of models; fewer if there are no more.
    """
    scored = record.labelled_models
    now = {model for grid in record.grids for model in grid.models}
    kinds: Iterable[Iterable[str]] = (
        (model for model in pool.samples if model not in record.shown_models and model not in scored),
        (model for model in pool.samples if model in record.shown_models and model not in scored and model not in now),
    )
    samples = [model for kind in kinds for model in kind]
    return samples[:num]
