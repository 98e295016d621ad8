"""Sorting of the shown models."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from grammarlab.errors import UsageError, shown
from grammarlab.pages.record.events import Record
from grammarlab.pages.record.model_grids import ModelGrid
from grammarlab.pages.scoring.knowledge import Knowledge, ModelPool

ORDERS = ("score", "uncertainty", "random", "feature", "similarity", "shown")

Keys = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Order:
    """Criterion of an order."""

    by: str
    """One of `ORDERS`."""
    feature: str = ""
    """For ``feature``, its name."""
    models: tuple[str, ...] = ()
    """For ``similarity``, the reference models."""


def sorted_grids(
    order: Order, record: Record, knowledge: Knowledge, pool: ModelPool, factor: str, seed: int
) -> list[ModelGrid]:
    """The grids, each in a new order; models without a number come last.

    Args:
        order: criterion: the highest score, the most uncertain, the most of a feature, the most similar, or the
            model that was shown earliest comes first.
        record: the session so far.
        knowledge: the results of learning.
        pool: the models.
        factor: name of the factor whose scores and kernel are used; empty for the product.
        seed: seed of a random order.

    Raises:
        UsageError: for an unknown order, or one that needs what is not known yet.
    """
    if order.by not in ORDERS:
        raise UsageError(f"by: expected one of {', '.join(ORDERS)}, found {shown(order.by)}.")
    names = [model for grid in record.grids for model in grid.models]
    keys = dict(zip(names, _keys(order, names, record, knowledge, pool, factor, seed).tolist(), strict=True))
    return [ModelGrid(grid.title, tuple(sorted(grid.models, key=lambda model: keys[model]))) for grid in record.grids]


def _keys(
    order: Order,
    names: Sequence[str],
    record: Record,
    knowledge: Knowledge,
    pool: ModelPool,
    factor: str,
    seed: int,
) -> Keys:
    """[n] the smallest comes first."""
    if order.by == "random":
        return np.random.default_rng(seed).random(len(names))
    if order.by == "shown":
        position = {model: number for number, model in enumerate(record.shown_models)}
        return np.array([position.get(model, len(position)) for model in names], dtype=np.float64)
    index, number = knowledge.indices(names, pool), record.numbers.get(factor, 0)
    if order.by == "feature":
        return _descending(knowledge.column(order.feature), index)
    if order.by == "similarity":
        return _distances(knowledge.scaled_rows(number), index, knowledge.indices(order.models, pool))
    predicted = knowledge.predictions_of(number)
    if order.by == "uncertainty":
        if predicted is None:
            raise UsageError("nothing has been learned yet, so all are equally uncertain: score some first.")
        return _descending(predicted.std, index)
    keys = np.full(len(names), np.inf) if predicted is None else _descending(predicted.mean, index)
    scores = record.factors.get(factor, {})
    return np.array([-scores[model].score if model in scores else key for model, key in zip(names, keys, strict=True)])


def _descending(values: NDArray[np.float32], index: NDArray[np.int64]) -> Keys:
    return np.where(index >= 0, -values[index].astype(np.float64), np.inf)


def _distances(rows: NDArray[np.float32], index: NDArray[np.int64], liked: NDArray[np.int64]) -> Keys:
    """[n] squared distance to the nearest of some models."""
    liked = liked[liked >= 0]
    if not len(liked):
        raise UsageError("similar to what? Select at least one of the models that are shown.")
    apart = rows[index][:, None, :] - rows[liked][None, :, :]
    nearest = np.einsum("nlf,nlf->nl", apart, apart).min(axis=1).astype(np.float64)
    return np.where(index >= 0, nearest, np.inf)
