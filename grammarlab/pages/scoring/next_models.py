"""Choice of the next models, laid out in grids."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass
from itertools import zip_longest

import numpy as np
from numpy.typing import NDArray

from grammarlab.pages.record.events import Record
from grammarlab.pages.record.model_grids import PAIRS, GridLayout, ModelGrid
from grammarlab.pages.scoring.knowledge import ModelPool

NUM_PAIRS = 8
"""Number of models that are chosen at once."""
LIKED_SHARE = 0.25
"""Share of the highest prediction from which a model is predicted to be liked."""
MIN_ADVANTAGE = 1.0
"""Points above the mean prediction from which one is higher than others: without a pattern all are equal."""


@dataclass(frozen=True, slots=True)
class WayWords:
    """A strategy for people."""

    label: str
    says: str


WAYS = {
    "default": WayWords("default", "half are predicted to be liked, the best first; half tell the most"),
    "uniform": WayWords("different", "as different as possible from each other and from all scored models"),
    "grammar": WayWords("unscored", "samples of the original that were not shown yet, whatever was scored"),
    "density": WayWords("as learned", "samples as learned from your scores, and beside them models that are avoided"),
    "uncertainty": WayWords("uncertain", "models with the most uncertain predictions"),
    "liked": WayWords("liked", "all that are predicted to be liked, the best first; New models shows the next"),
    "scored": WayWords("scored", "all that you scored, the latest first; New models shows the next"),
    "already ranked": WayWords("surprising", "scores that surprise the most, to check for mistakes"),
    PAIRS: WayWords("pairs", "two at a time, to choose the one that you prefer"),
}
"""Query strategies of `grammarlab.preference.queries`, `LISTS` and pairs, in words."""
LISTS = ("liked", "scored")
"""Strategies that list models, and choose nothing to ask about."""

_NOTHING = ModelGrid("", ())
_LIKED, _CHOSEN, _SAMPLES = "may be liked, the best first", "tell the most", "to score"
"""Titles of the halves of ``default``, once something has been learned; the last one also has samples."""
_IN_ONE = {_CHOSEN: "those that tell the most", _SAMPLES: "others to score"}
"""Words for its second half where both are one grid."""
_TITLES = {
    "default": (_SAMPLES, ""),
    "density": ("liked", "not liked"),
    "uniform": ("different", ""),
    "grammar": ("unscored", ""),
    "uncertainty": ("uncertain", ""),
    "liked": ("liked, the best first", ""),
    "scored": ("scored, the latest first", ""),
    "already ranked": ("surprising", ""),
    PAIRS: ("this one", "that one"),
}


@dataclass(frozen=True, slots=True)
class NextModels:
    """Models to show next."""

    chosen: Sequence[str]
    """Models that a strategy chose."""
    samples: Sequence[str] = ()
    """Samples of the grammar for places that are left."""

    @property
    def models(self) -> list[str]:
        """All of them, in order."""
        return [*self.chosen, *self.samples]


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
    half = (len(models) + 1) // 2 if layout.grids == 2 and way == "density" else size
    parts = (models[:half], models[half:])
    return [ModelGrid(title, tuple(part[:size])) for title, part in zip(titles[: layout.grids], parts, strict=False)]


def mixed(liked: Sequence[str], following: NextModels, layout: GridLayout) -> list[ModelGrid]:
    """Grids of models that are predicted to be liked, and of chosen ones; with one grid, one after the other.

    Args:
        liked: models that are predicted to be liked, the best first; only half of all places are theirs.
        following: models of the strategy ``default``, of which a part is shown.
        layout: number and size of grids.
    """
    liked = liked[: (layout.models + 1) // 2]
    others = [model for model in following.chosen if model not in liked]
    most = min(layout.models - len(liked), layout.rows * layout.columns)
    # Kinds of questions follow each other in the choice, and a part of it shall have all of them.
    others = [others[index * len(others) // most] for index in range(most)] if len(others) > most else others
    left = [model for model in following.samples if model not in liked][: most - len(others)]
    title = _SAMPLES if left else _CHOSEN
    if layout.grids == 1:
        return [ModelGrid(f"{_LIKED}, then {_IN_ONE[title]}", (*liked, *others, *left))]
    return [ModelGrid(_LIKED, tuple(liked)), ModelGrid(title, (*others, *left))]


def extended(shown: Sequence[ModelGrid], following: Sequence[ModelGrid]) -> list[ModelGrid]:
    """Grids with further models below those that are shown; none is shown twice."""
    now = {model for grid in shown for model in grid.models}
    return [
        ModelGrid(_joined(grid.title, more.title), (*grid.models, *(name for name in more.models if name not in now)))
        for grid, more in zip_longest(shown, following, fillvalue=_NOTHING)
    ]


def _joined(title: str, more: str) -> str:
    """Title of a grid in which models of another kind follow; it says the first and the last kind."""
    if title.endswith(more):
        return title
    return f"{title.split(', then ', maxsplit=1)[0] or 'more'}, then {more}"


def liked_models(
    pool: ModelPool,
    record: Record,
    predicted: NDArray[np.floating],
    num: int,
    seed: int,
    without: Collection[str] = (),
) -> list[str]:
    """Models without a score that are predicted to be liked, the best first.

    They are drawn in proportion to their predictions, as models that are learned are, and those that were never shown
    come before others; the best ones alone would be nearly the same.

    Args:
        pool: the pool.
        record: shown and scored models.
        predicted: [m] predicted scores of the models of the pool.
        num: number of models; fewer if fewer are predicted to be liked.
        seed: seed of the draws.
        without: models that are left out.
    """
    mean = np.maximum(predicted[: len(pool.names)].astype(np.float64), 0.0)
    typical = float(mean[: len(pool.samples)].mean())
    is_liked = mean > max(LIKED_SHARE * float(mean.max(initial=0.0)), typical + MIN_ADVANTAGE)
    keys = np.random.default_rng(seed).gumbel(size=len(mean)) + np.log(np.maximum(mean, 1e-9))
    left_out = {*record.labelled_models, *without}

    def order(index: int) -> tuple[bool, bool, float]:
        """Samples of the grammar come before unusual models."""
        return pool.names[index] in record.shown_models, index >= len(pool.samples), -float(keys[index])

    open_ones = [index for index in np.flatnonzero(is_liked).tolist() if pool.names[index] not in left_out]
    return [pool.names[index] for index in sorted(sorted(open_ones, key=order)[:num], key=lambda index: -mean[index])]


def next_scored(record: Record, factor: str, num: int) -> list[str]:
    """Models with a score of a factor, the latest first; those after the ones that are shown, around the end.

    Args:
        record: shown and scored models.
        factor: name of the factor; empty for all factors.
        num: number of models; fewer if fewer are scored.
    """
    factors = [record.factors[factor]] if factor else list(record.factors.values())
    scored = dict.fromkeys(subject for scores in factors for subject in reversed(scores) if " " not in subject)
    return after_shown(list(scored), record)[:num]


def after_shown(models: Sequence[str], record: Record) -> list[str]:
    """The models from the first one after those that are shown, then the others."""
    shown = set(record.shown_now)
    last = max((index for index, model in enumerate(models) if model in shown), default=-1)
    return [*models[last + 1 :], *models[: last + 1]]


def fresh_samples(pool: ModelPool, record: Record, num: int, without: Collection[str] = ()) -> list[str]:
    """Samples of the grammar that were never shown, then shown ones without a score.

    Args:
        pool: the pool; its samples are independent, so any of them follow the grammar.
        record: shown and scored models.
        num: number of models; fewer if there are no more.
        without: models that are left out.
    """
    scored = {*record.labelled_models, *without}
    now = set(record.shown_now)
    kinds: Iterable[Iterable[str]] = (
        (model for model in pool.samples if model not in record.shown_models and model not in scored),
        (model for model in pool.samples if model in record.shown_models and model not in scored and model not in now),
    )
    samples = [model for kind in kinds for model in kind]
    return samples[:num]
