"""Sums of draws that explain scores, liked in some interval: towers of 140 to 170 m, for any heights of their blocks.

A half-space (`grammarlab.features.search.thresholds`) has one bound and reads every draw. Here a sum is found term by
term, with a sign for each draw, and a draw counts 0 if a model does not use it. If no such sum explains the scores, a
draw may be multiplied by a number that each model chooses, such as the height of a floor by the number of floors.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple, TypeAlias

import numpy as np

from grammarlab.arrays import Floats, Ints
from grammarlab.derivation.forest import Forest
from grammarlab.features.patterns.counts import count
from grammarlab.features.patterns.pattern import HalfSpace, Pattern, Sum, Term

MAX_TERMS = 6
"""Largest number of draws in a sum."""
MIN_SCORES = 32
"""Smallest number of scores; with fewer, some sum of many draws explains anything."""
MAX_SCORES = 400
"""Largest number of models; of more, an even selection by score is used."""
MAX_DRAWS = 64
"""Largest number of columns; of more, those that explain most alone are used."""
_MAX_NUMBERS, _MAX_MULTIPLES = 2, 16
"""Largest number of numbers that multiply draws, and of multiplied draws; those that explain most alone are used."""
_MAX_BRANCHES = 12
"""Largest number of branches of a choice whose branch number may multiply draws."""
_NUM_BOUNDS = 24
"""Number of bounds of intervals that are tried, evenly spaced by rank."""
_NUM_PAIRED = 24
"""Number of columns of which pairs are tried, those that explain most alone."""
_NUM_STARTS = 4
"""Number of pairs that sums grow from."""
_MIN_STEP_SHARE = 0.25
"""Smallest share of the variance of scores on the sides of a half-space that further steps explain."""
_SCORE_TOLERANCE = 1e-6
"""Largest difference of equal scores, in points."""
_SCORES_PER_MEAN = 12
"""Held-out scores are predicted by the mean of one in 12 other scores."""
_NUM_FOLDS = 3
"""Number of parts of the scores, each held out once."""
_MIN_SUPPORT = 0.15
"""Smallest share of the errors at held-out scores that sums found without them must remove."""
_MIN_GAIN = 0.05
"""Smallest removed error, as a share of the variance of all scores."""


Number: TypeAlias = tuple[tuple[Pattern, float], ...]
"""A weighted sum of counts of patterns."""


def find_steps(forests: Sequence[Forest], scores: Floats, space: HalfSpace) -> Sum | None:
    """The sum of a half-space, if scores on its two sides have steps at further bounds; otherwise None.

    Args:
        forests: the scored models.
        scores: [n] scores of the models, in their order.
        space: the half-space.
    """
    total = Sum.of(space.sites, space.weights, space.logarithmic)
    inside, sums = np.concatenate([count(forest, [space, total]) for forest in forests]).T
    residuals = scores.astype(np.float64)
    for side in (inside == 0.0, inside != 0.0):
        residuals[side] -= residuals[side].mean() if side.any() else 0.0
    is_unexplained = float(np.abs(residuals).max(initial=0.0)) > _SCORE_TOLERANCE
    return total if is_unexplained and explained(sums[:, None], residuals)[0] > _MIN_STEP_SHARE else None


class PricedSum(NamedTuple):
    """A sum of draws."""

    sum: Sum
    price: float
    """What the choice of its terms costs, in nats."""


class _Candidate(NamedTuple):
    """A sum of columns."""

    signs: Floats
    """[C] -1, 0 or 1."""
    worth: float
    """Log-likelihood gained by its best interval, minus the price of choosing its terms."""


def _worth(candidate: _Candidate) -> float:
    return candidate.worth


def find_sum(
    forests: Sequence[Forest], scores: Floats, names: Sequence[str], readers: Mapping[str, tuple[Pattern, ...]]
) -> PricedSum | None:
    """Sum of draws of which an interval explains most of the scores; None if held-out scores do not confirm it.

    Many sums explain some: whether scores need this one is for others to judge.

    Args:
        forests: the scored models.
        scores: [n] scores of the models, in their order.
        names: candidate draws, by `Site.name`.
        readers: branches that use some of them (`grammarlab.features.search.attribute_readers`).
    """
    if len(scores) < MIN_SCORES or len(names) < 2:
        return None
    rows = np.arange(len(scores))
    if len(scores) > MAX_SCORES:
        rows = np.argsort(scores, kind="stable")[rows[:MAX_SCORES] * len(scores) // MAX_SCORES]
        scores = scores[rows]
    terms = _terms(forests, names, readers)
    values = _values(forests, terms)[rows]
    plain = _most_explaining(values, scores, MAX_DRAWS)
    terms, values = [terms[index] for index in plain], values[:, plain]
    uses = np.where([bool(term.readers) for term in terms], values != 0.0, 1.0)
    result = _supported(terms, values, uses, scores)
    if result is not None:
        return result
    numbers = _numbers(forests)
    counts = _counts(forests, numbers)[rows]
    selected = _most_explaining(counts, scores, _MAX_NUMBERS)
    multiples = [term._replace(times=numbers[index]) for index in selected for term in terms]
    multiplied = _values(forests, multiples)[rows]
    # That a draw is used, together with the number, may be all that matters.
    counts = (1.0 + np.repeat(counts[:, selected], len(terms), axis=1)) * np.tile(uses, len(selected))
    selected = _most_explaining(multiplied, scores, _MAX_MULTIPLES)
    terms += [multiples[index] for index in selected]
    values, uses = np.append(values, multiplied[:, selected], axis=1), np.append(uses, counts[:, selected], axis=1)
    return _supported(terms, values, uses, scores) if selected else None


def _supported(terms: Sequence[Term], values: Floats, uses: Floats, scores: Floats) -> PricedSum | None:
    """The sum of terms that explains most, if held-out scores confirm it.

    Args:
        terms: [C] candidate terms.
        values: [n, C] values of the terms.
        uses: [n, C] how often a model uses each draw.
        scores: [n] scores of the models.
    """
    alone = np.flatnonzero([bool(term.times) for term in terms])
    signs = _best(values, scores, alone)
    if signs is None or not _has_support(values, uses, scores, alone):
        return None
    used = np.flatnonzero(signs).tolist()
    total = Sum(tuple(terms[index]._replace(weight=float(signs[index] * signs[used[0]])) for index in used))
    return PricedSum(total, float(_prices(signs[None])[0]))


def _terms(forests: Sequence[Forest], names: Sequence[str], readers: Mapping[str, tuple[Pattern, ...]]) -> list[Term]:
    """A term for each draw, with its readers if some models do not use it."""
    gated = [Term(name, 1.0, readers.get(name, ())) for name in names]
    plain = [term._replace(readers=()) for term in gated]
    always = (_values(forests, gated) == _values(forests, plain)).all(axis=0)
    return [plain[index] if is_used else gated[index] for index, is_used in enumerate(always.tolist())]


def _values(forests: Sequence[Forest], terms: Sequence[Term]) -> Floats:
    """[n, C] values of terms."""
    none = np.zeros((0, len(terms)))
    return np.concatenate([none, *(count(forest, [Sum((term,)) for term in terms]) for forest in forests)])


def _numbers(forests: Sequence[Forest]) -> list[Number]:
    """Numbers that a model chooses once: which of three or more branches of a rule it takes, counted from 0."""
    branches: dict[tuple[str, int], set[int]] = {}
    for rule in (rule for forest in forests for rule in forest.rules if rule.branch):
        branches.setdefault((rule.symbol, rule.parameters), set()).add(rule.branch[0])
    chosen = [
        tuple((Pattern(*key, (branch,)), float(branch)) for branch in sorted(choices))
        for key, choices in sorted(branches.items())
        if 2 < len(choices) <= _MAX_BRANCHES
    ]
    times = _counts(forests, [tuple((pattern, 1.0) for pattern, _ in number) for number in chosen])
    once = times.max(axis=0, initial=0.0) == 1.0
    return [number[1:] for number, is_once in zip(chosen, once.tolist(), strict=True) if is_once]


def _counts(forests: Sequence[Forest], numbers: Sequence[Number]) -> Floats:
    """[n, K] weighted counts of patterns."""
    patterns = [pattern for number in numbers for pattern, _ in number]
    none = np.zeros((0, len(patterns)))
    weighted = np.concatenate([none, *(count(forest, patterns) for forest in forests)])
    weighted = weighted * np.array([weight for number in numbers for _, weight in number])
    ends = np.cumsum([0, *(len(number) for number in numbers)])
    return np.diff(np.cumsum(np.pad(weighted, ((0, 0), (1, 0))), axis=1)[:, ends], axis=1)


def _most_explaining(values: Floats, scores: Floats, most: int) -> list[int]:
    """Ascending indices of the columns [n, C] that explain most of scores [n] alone."""
    return sorted(np.argsort(-explained(values, scores), kind="stable")[:most].tolist())


def _best(values: Floats, scores: Floats, alone: Ints) -> Floats | None:
    """Signs [C] of the sum of columns [n, C] with the largest value; None if one column has an equal value.

    Columns ``alone`` [K] may be a sum of one term.
    """
    width = values.shape[1]
    if width < 2:
        return None
    single = _worths(values, np.eye(width), scores)
    paired = np.sort(np.argsort(-single, kind="stable")[:_NUM_PAIRED])
    first, second = (paired[indices] for indices in np.triu_indices(len(paired), 1))
    begin = [_Candidate(np.eye(width)[index], float(single[index])) for index in alone.tolist()]
    candidates = [_climbed(values, scores, start, (1.0,)) for start in sorted(begin, key=_worth)[-_NUM_STARTS:]]
    for allowed in ((1.0,), (1.0, -1.0)):
        pairs = np.tile(np.eye(width)[first], (len(allowed), 1))
        pairs[np.arange(len(pairs)), np.tile(second, len(allowed))] = np.repeat(allowed, len(first))
        worths = _worths(values, pairs, scores)
        for index in np.argsort(-worths, kind="stable")[:_NUM_STARTS].tolist():
            candidates.append(_climbed(values, scores, _Candidate(pairs[index], float(worths[index])), allowed))
    best = max(candidates, key=_worth)
    least = max(0.0, np.delete(single, alone).max(initial=0.0))
    several = np.count_nonzero(best.signs) > 1 or bool(best.signs[alone].any())
    return best.signs if best.worth > least and several else None


def _climbed(values: Floats, scores: Floats, candidate: _Candidate, allowed: tuple[float, ...]) -> _Candidate:
    """Local search: the best change of one sign, or else the best exchange of two terms, while the value grows."""
    while True:
        for trials in (changed(candidate.signs, allowed), _exchanged(candidate.signs, allowed)):
            worths = _worths(values, trials, scores)
            worths[np.count_nonzero(trials, axis=1) > MAX_TERMS] = -np.inf
            index = int(np.argmax(worths)) if len(worths) else 0
            if (worths > candidate.worth).any():
                candidate = _Candidate(trials[index], float(worths[index]))
                break
        else:
            return candidate


def changed(signs: Floats, allowed: tuple[float, ...]) -> Floats:
    """[K, C] signs [C] with one of them changed."""
    column, sign = np.tile(np.arange(len(signs)), len(allowed)), np.repeat(allowed, len(signs))
    result = np.repeat(signs[None], len(column), axis=0)
    result[np.arange(len(column)), column] = np.where(signs[column] == sign, 0.0, sign)
    return result


def _exchanged(signs: Floats, allowed: tuple[float, ...]) -> Floats:
    """[K, C] signs [C] with one term left out and another one added."""
    added = changed(signs, allowed)
    added = added[np.count_nonzero(added, axis=1) > np.count_nonzero(signs)]
    used = np.flatnonzero(signs)
    exchanged = np.tile(added, (len(used), 1))
    exchanged[np.arange(len(exchanged)), np.repeat(used, len(added))] = 0.0
    return exchanged


def _worths(values: Floats, signs: Floats, scores: Floats) -> Floats:
    """[K] log-likelihood gained by sums of columns [n, C] with signs [K, C], minus the price of their terms."""
    shares = np.minimum(explained(values @ signs.T, scores), 1.0 - 1e-9)
    return -0.5 * len(scores) * np.log1p(-shares) - _prices(signs)


def _prices(signs: Floats) -> Floats:
    """[K] what the choice of the terms of sums with signs [K, C] costs, in nats."""
    # Sums of equal signs are more likely: a sum with both signs pays for the choice of its signs.
    choices = np.where((signs < 0.0).any(axis=1), 2.0, 1.0) * signs.shape[1]
    return np.log(choices) * np.count_nonzero(signs, axis=1)


def explained(columns: Floats, scores: Floats) -> Floats:
    """[C] largest share of the variance of scores [n] that three intervals of each column [n, C] explain.

    >>> explained(np.array([[0.0], [1.0], [2.0], [3.0]]), np.array([0.0, 9.0, 9.0, 0.0]))
    array([1.])
    """
    num = len(scores)
    centred = scores - scores.mean()
    total = float(centred @ centred)
    order = np.argsort(columns, axis=0, kind="stable")
    values = np.take_along_axis(columns, order, axis=0)
    sums = np.concatenate([np.zeros((1, columns.shape[1])), np.cumsum(centred[order], axis=0)])
    # Intervals do not end between equal values, but at the next place where the values differ.
    index = np.arange(num + 1)[:, None]
    apart = np.pad(values[1:] > values[:-1], ((1, 1), (0, 0)), constant_values=True)
    ends = np.minimum.accumulate(np.where(apart, index, num)[::-1], axis=0)[::-1]
    ends = ends[np.unique(np.linspace(0, num, min(_NUM_BOUNDS, num) + 1).astype(np.int64))]
    sums = np.take_along_axis(sums, ends, axis=0)
    first, last = np.triu_indices(len(ends), 1)
    inside = sums[last] - sums[first]
    between = inside**2 / np.maximum(ends[last] - ends[first], 1)
    for outside, rest in ((sums[first], ends[first]), (-sums[last], num - ends[last])):
        between = between + outside**2 / np.maximum(rest, 1)
    return between.max(axis=0) / total if total > 0.0 else np.zeros(columns.shape[1])


def _has_support(values: Floats, uses: Floats, scores: Floats, alone: Ints) -> bool:
    """Whether sums found without some of the scores explain these scores better than the use of their terms alone.

    Args:
        values: [n, C] draws.
        uses: [n, C] how often a model uses each of them.
        scores: [n] scores of the models.
        alone: [K] columns that may be a sum of one term.
    """
    fold = np.empty(len(scores), dtype=np.int64)
    fold[np.argsort(scores, kind="stable")] = np.arange(len(scores)) % _NUM_FOLDS
    sum_error = use_error = mean_error = 0.0
    # Each draw replaced by its mean, so that only its use is left.
    means_of = uses * (values.sum(axis=0) / np.maximum(uses.sum(axis=0), 1.0))
    for number in range(_NUM_FOLDS):
        is_held_out = fold == number
        best = _best(values[~is_held_out], scores[~is_held_out], alone)
        signs = np.zeros(values.shape[1]) if best is None else best
        used = uses[:, signs != 0.0]
        for columns in (values, means_of):
            sums = columns @ signs
            predicted = (
                scores.mean()
                if best is None
                else _predicted(sums[~is_held_out], scores[~is_held_out], sums[is_held_out])
            )
            error = float(((scores[is_held_out] - predicted) ** 2).sum())
            sum_error, mean_error = (
                (sum_error + error, mean_error) if columns is values else (sum_error, mean_error + error)
            )
        of_use = np.unique(used, axis=0, return_inverse=True)[1].reshape(-1)
        number_of = np.bincount(of_use[~is_held_out], minlength=of_use.max() + 1)
        means = np.bincount(of_use[~is_held_out], scores[~is_held_out], of_use.max() + 1) + scores.mean()
        use_error += float(((scores - means[of_use] / (number_of[of_use] + 1.0))[is_held_out] ** 2).sum())
    total_error = float(((scores - scores.mean()) ** 2).sum())
    use_error = min(use_error, mean_error, total_error)
    return sum_error < (1.0 - _MIN_SUPPORT) * use_error and use_error - sum_error > _MIN_GAIN * total_error


def _predicted(sums: Floats, scores: Floats, others: Floats) -> Floats:
    """The mean score of the models whose sums are nearest."""
    nearest = np.argsort(np.abs(others[:, None] - sums), axis=1, kind="stable")[
        :, : max(1, len(sums) // _SCORES_PER_MEAN)
    ]
    return scores[nearest].mean(axis=1)
