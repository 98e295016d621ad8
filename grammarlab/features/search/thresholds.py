"""Bounds on continuous draws, and relations of two draws, that explain scores.

A preference that steps at a bound cannot be learned by smooth interpolation; found as a feature, the step is one
column. Bounds are those of one draw, ``height < 5``, or of a half-space, ``width * depth * height < 125``. They are
halfway between the nearest models on both sides, so that scores of models near a bound (`margins`) narrow it. A
relation is the ratio or the difference of two draws, such as height to width.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import Floats
from grammarlab.derivation.forest import Forest
from grammarlab.errors import UsageError
from grammarlab.features.patterns.counts import count
from grammarlab.features.patterns.pattern import Draw, HalfSpace, Sum, Threshold
from grammarlab.features.search.sums import explained

MAX_RELATIONS = 8
"""Largest number of relations."""
MAX_TERMS = 4
"""Largest number of draws in a half-space, since people consider few things."""
_MAX_DRAWS = 48
"""Largest number of draws; of more, the first ones are used."""
_MIN_POSITIVE = 1e-300
"""Smallest argument of a logarithm."""
_NUM_SHUFFLES = 199
"""Number of random orders of the scores: a bound by chance is kept once in 200 searches."""
_NUM_FOLDS = 3
"""Number of parts of the models, each held out once."""
_MAX_WRONG = 0.3
"""Largest share of held-out models on the wrong side, relative to the models of the smaller side."""
_PRICE_OF_ERRORS = 1e4
"""Cost of a model on the wrong side, relative to the sizes of the weights."""


def find_relations(forests: Sequence[Forest], scores: Floats, names: Sequence[str]) -> tuple[list[Sum], float]:
    """Ratios and differences of two draws that explain more of the scores than either draw, best first.

    Many do so by chance: whether scores need one is for others to judge.

    Args:
        forests: the scored models.
        scores: [n] scores of the models, in their order.
        names: candidate draws, by `Site.name`.

    Returns:
        The relations, and the log of the number of all: what the choice of one costs, in nats.
    """
    names = names[:_MAX_DRAWS]
    pairs = np.stack(np.triu_indices(len(names), 1), axis=1)
    if len(scores) < 2 or not len(pairs):
        return [], 0.0
    values = np.concatenate([count(forest, [Draw(name) for name in names]) for forest in forests])
    alone = explained(values, scores)
    positive = pairs[np.isin(pairs, np.flatnonzero((values > 0.0).all(axis=0))).all(axis=1)]
    relations: list[tuple[float, Sum]] = []
    for logarithmic, possible in ((True, positive), (False, pairs)):
        columns = np.log(np.maximum(values, _MIN_POSITIVE)) if logarithmic else values
        shares = explained(columns[:, possible[:, 0]] - columns[:, possible[:, 1]], scores)
        for index in np.flatnonzero(shares > alone[possible].max(axis=1)).tolist():
            first, second = (int(site) for site in possible[index])
            relations.append((float(shares[index]), Sum.of((names[first], names[second]), (1.0, -1.0), logarithmic)))
    best = sorted(relations, key=lambda item: -item[0])[:MAX_RELATIONS]
    return [relation for _, relation in best], float(np.log(2 * len(pairs)))


def find_thresholds(
    forests: Sequence[Forest], scores: Floats, names: Sequence[str], most: int = 4
) -> tuple[Threshold, ...]:
    """Bounds that explain most of the scores, best first, at most one per draw.

    Only bounds that explain more than any bound explains of the same scores in random orders are kept. Few high scores
    among many low ones have such bounds by chance more often than normal scores.

    Args:
        forests: the scored models.
        scores: [n] their scores, in their order; or the residuals of a preference.
        names: candidate draws, by `Site.name`.
        most: largest number of bounds.
    """
    columns = _values(forests, names, len(scores))
    if len(scores) < 2 or not names or scores.var() <= 0.0:
        return ()
    splits = _Splits.of(columns)
    shares, bounds = splits.best(scores)
    randomness = np.random.default_rng(0)
    least = max(splits.best(randomness.permutation(scores))[0].max() for _ in range(_NUM_SHUFFLES))
    ranked = sorted(zip((-shares).tolist(), names, bounds.tolist(), strict=True))
    return tuple(Threshold(name, bound) for share, name, bound in ranked[:most] if -share > least)


def find_half_space(forests: Sequence[Forest], inside: NDArray[np.bool_], names: Sequence[str]) -> HalfSpace | None:
    """Half-space of draws, or of their logarithms, that contains the chosen models; None if there is none.

    Of those with the fewest errors, the one with the fewest draws is used; weights of 1 and -1 are preferred.
    It has at most `MAX_TERMS` draws, is wrong for fewer than a tenth of the models on either side,
    and half-spaces found without a third of the models are right about that third.

    Args:
        forests: the models.
        inside: [n] whether they should lie in the half-space.
        names: candidate draws, by `Site.name`.
    """
    values = _values(forests, names, len(inside))
    best = _best_half_space(values, inside)
    if best is None or not _has_support(values, inside):
        return None
    used = np.flatnonzero(best.weights).tolist()
    sites = tuple(names[i] for i in used)
    return HalfSpace(sites, tuple(best.weights[used].tolist()), best.bound, best.logarithmic)


def margins(forests: Sequence[Forest], feature: Threshold | HalfSpace) -> Floats:
    """[n] distance of each model from a bound; negative inside, infinite if a logarithm is undefined."""
    space = HalfSpace((feature.site,), (1.0,), feature.bound) if isinstance(feature, Threshold) else feature
    columns = np.concatenate([np.zeros((0, len(space.sites))), *(count(f, _draws(space.sites)) for f in forests)])
    if space.logarithmic:
        with np.errstate(divide="ignore", invalid="ignore"):
            columns = np.log(columns)
    with np.errstate(invalid="ignore"):
        distance = columns @ np.array(space.weights) - space.bound
    return np.where(np.isfinite(columns).all(axis=1), distance, np.inf)


def _values(forests: Sequence[Forest], names: Sequence[str], num_models: int) -> Floats:
    """[n, len(names)] the draws of the models."""
    values = np.concatenate([np.zeros((0, len(names))), *(count(forest, _draws(names)) for forest in forests)])
    if len(values) != num_models:
        raise UsageError(f"expected a score for each of {len(values)} models, found {num_models}")
    return values


def _draws(names: Sequence[str]) -> list[Draw]:
    return [Draw(name) for name in names]


class _Splits(NamedTuple):
    """All bounds on each of C columns."""

    order: NDArray[np.int64]
    """[n, C] ascending order of each column."""
    values: Floats
    """[n, C] values in ascending order."""

    @classmethod
    def of(cls, columns: Floats) -> _Splits:
        """The bounds on columns [n, C], n >= 2."""
        order = np.argsort(columns, axis=0, kind="stable")
        return cls(order, np.take_along_axis(columns, order, axis=0))

    def best(self, scores: Floats) -> tuple[Floats, Floats]:
        """[C] the share of the variance of scores [n], not all equal, that the best bound explains, and this bound."""
        residuals, below = scores - scores.mean(), np.arange(1, len(scores))[:, None]
        sums = np.cumsum(residuals[self.order], axis=0)[:-1]
        explained = sums**2 * len(scores) / (below * (len(scores) - below))
        explained = np.where(self.values[1:] > self.values[:-1], explained, 0.0)
        index = explained.argmax(axis=0)[None]
        low, high = (np.take_along_axis(self.values, index + side, axis=0)[0] for side in (0, 1))
        return explained.max(axis=0) / float(residuals @ residuals), (low + high) / 2.0


def _best_half_space(values: Floats, inside: NDArray[np.bool_]) -> _ThresholdFit | None:
    """The best bound on a sum of at most `MAX_TERMS` columns [n, C], or of their logarithms."""
    candidates: list[_ThresholdFit] = []
    for logarithmic in (False, True):
        if logarithmic and not (values > 0.0).all():
            continue
        columns = np.log(values) if logarithmic else values
        weights = _of_few_terms(columns, inside)
        if weights is None or not weights.any():
            continue
        weights = weights / np.abs(weights).max()
        candidates += [_fit(columns, inside, trial, logarithmic) for trial in (np.round(weights), weights)]
    good = [fit for fit in candidates if fit.errors < 0.1 * min(inside.sum(), (~inside).sum())]
    return min(
        good,
        key=lambda fit: (fit.errors, np.count_nonzero(fit.weights), (fit.weights % 1.0).any(), -fit.gap),
        default=None,
    )


class _ThresholdFit(NamedTuple):
    errors: int
    gap: float
    """Gap between the two sides, relative to their extent; negative if they overlap."""
    weights: Floats
    bound: float
    logarithmic: bool


def _of_few_terms(columns: Floats, inside: NDArray[np.bool_]) -> Floats | None:
    """Weights of a sum that is lower inside, of the columns with the largest weights in a sum of all."""
    weights = _separating(columns, inside)
    if weights is None or np.count_nonzero(weights) <= MAX_TERMS:
        return weights
    most = np.argsort(-np.abs(weights) * columns.std(axis=0), kind="stable")[:MAX_TERMS]
    few_weights = _separating(columns[:, most], inside)
    if few_weights is None:
        return None
    weights = np.zeros(columns.shape[1])
    weights[most] = few_weights
    return weights


def _separating(columns: Floats, inside: NDArray[np.bool_]) -> Floats | None:
    """Weights of a sum that is lower inside than outside: a support vector machine with few weights.

    Linear program in weights (positive and negative parts), bound and errors.
    """
    from scipy.optimize import linprog  # noqa: PLC0415  # this import takes a third of the start of a small run

    if inside.all() or not inside.any():
        return None
    spread = columns.std(axis=0)
    usable = spread > 0.0
    scaled = columns[:, usable] / spread[usable]
    num_models, width = scaled.shape
    sign = np.where(inside, 1.0, -1.0)[:, None]
    # sign * (scaled @ weights - bound) <= -1 + errors
    inequality = np.hstack((sign * scaled, -sign * scaled, -sign, -np.eye(num_models)))
    price = np.concatenate((np.ones(2 * width), [0.0], np.full(num_models, _PRICE_OF_ERRORS / num_models)))
    limits = [(0.0, None)] * (2 * width) + [(None, None)] + [(0.0, None)] * num_models
    solved = linprog(price, A_ub=inequality, b_ub=np.full(num_models, -1.0), bounds=limits, method="highs")
    if not solved.success:
        return None
    weights = np.zeros(columns.shape[1])
    weights[usable] = (solved.x[:width] - solved.x[width : 2 * width]) / spread[usable]
    return weights


def _fit(columns: Floats, inside: NDArray[np.bool_], weights: Floats, logarithmic: bool) -> _ThresholdFit:
    """The best bound for given weights."""
    sums = columns @ weights
    order = np.argsort(sums, kind="stable")
    # Errors if the first k are inside.
    wrong = np.concatenate(([0], np.cumsum(~inside[order]))) + np.concatenate(
        (np.cumsum(inside[order][::-1])[::-1], [0])
    )
    ends = np.concatenate(([sums[order[0]] - 1.0], sums[order], [sums[order[-1]] + 1.0]))
    split = int(np.argmin(np.where(ends[1:] > ends[:-1], wrong, len(wrong) + 1)))
    gap = float(ends[split + 1] - ends[split]) / max(float(np.ptp(sums)), 1e-300)
    return _ThresholdFit(int(wrong[split]), gap, weights, float(ends[split] + ends[split + 1]) / 2.0, logarithmic)


def _has_support(values: Floats, inside: NDArray[np.bool_]) -> bool:
    """Whether half-spaces found without some of the models are right about these models.

    Enough columns can separate any few models; such a half-space has no meaning for other models.
    """
    fold = np.empty(len(inside), dtype=np.int64)
    for side in (inside, ~inside):
        fold[side] = np.arange(side.sum()) % _NUM_FOLDS
    wrong = 0
    for number in range(_NUM_FOLDS):
        is_held_out = fold == number
        fit = _best_half_space(values[~is_held_out], inside[~is_held_out])
        if fit is None:
            return False
        columns = np.log(values[is_held_out]) if fit.logarithmic else values[is_held_out]
        wrong += int(((columns @ fit.weights < fit.bound) != inside[is_held_out]).sum())
    return wrong < _MAX_WRONG * min(inside.sum(), (~inside).sum())
