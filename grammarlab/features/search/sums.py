"""Sums of draws that explain scores, liked in some interval: towers of 140 to 170 m, for any heights of their blocks.

A half-space (`grammarlab.features.search.thresholds`) has one bound and reads every draw. Here a sum is found term by
term, with a sign for each draw, and a draw counts 0 if a model does not use it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from grammarlab.derivation.forest import Forest
from grammarlab.features.counting.counts import count
from grammarlab.features.patterns.pattern import Draw, Pattern, Sum

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

MOST_TERMS = 6
"""Largest number of draws in a sum."""
FEWEST = 32
"""Smallest number of scores; with fewer, some sum of many draws explains anything."""
MOST_SCORES = 400
"""Largest number of models; of more, an even selection by score is used."""
MOST_DRAWS = 64
"""Largest number of columns; of more, those that explain most alone are used."""
_BOUNDS = 12
"""Number of bounds of intervals that are tried, evenly spaced by rank."""
_BEGINNINGS = 4
"""Number of pairs that sums grow from."""
_FOLDS = 3
_SUPPORT = 0.15
"""Smallest share of the errors at held-out scores that sums found without them must remove."""


class _Found(NamedTuple):
    """A sum of columns."""

    signs: Floats
    """[C] -1, 0 or 1."""
    worth: float
    """Log-likelihood gained by its best interval, minus the price of choosing its terms."""


def find_sum(
    forests: Sequence[Forest], scores: Floats, names: Sequence[str], readers: Mapping[str, tuple[Pattern, ...]]
) -> Sum | None:
    """Sum of draws of which an interval explains most of the scores; None if held-out scores do not confirm it.

    Args:
        forests: the scored models.
        scores: [n] their scores, in their order.
        names: candidate draws, by `Site.name`.
        readers: branches that use some of them (`grammarlab.features.search.readers`).
    """
    if len(scores) < FEWEST or len(names) < 2:
        return None
    gates = [readers.get(name, ()) for name in names]
    parts = [Sum((name,), (1.0,), readers=(gate,) if gate else ()) for name, gate in zip(names, gates, strict=True)]
    values = np.concatenate([count(forest, parts) for forest in forests])
    drawn = np.concatenate([count(forest, [Draw(name) for name in names]) for forest in forests])
    always = (values == drawn).all(axis=0)
    if len(scores) > MOST_SCORES:
        some = np.argsort(scores, kind="stable")[np.arange(MOST_SCORES) * len(scores) // MOST_SCORES]
        values, scores = values[some], scores[some]
    kept = np.sort(np.argsort(-explained(values, scores), kind="stable")[:MOST_DRAWS])
    signs = _best(values[:, kept], scores)
    if signs is None or not _has_support(values[:, kept], ~always[kept], scores):
        return None
    used = np.flatnonzero(signs)
    terms: list[int] = kept[used].tolist()
    weights = signs[used] * signs[used[0]]
    of_terms = tuple(() if always[term] else gates[term] for term in terms)
    return Sum(tuple(names[t] for t in terms), tuple(weights.tolist()), readers=of_terms if any(of_terms) else ())


def _best(values: Floats, scores: Floats) -> Floats | None:
    """Signs [C] of the sum of columns [n, C] with the largest value; None if one column has an equal value."""
    width = values.shape[1]
    if width < 2:
        return None
    alone = _worths(values, np.eye(width), scores)
    first, second = np.triu_indices(width, 1)
    found: list[_Found] = []
    for allowed in ((1.0,), (1.0, -1.0)):
        pairs = np.tile(np.eye(width)[first], (len(allowed), 1))
        pairs[np.arange(len(pairs)), np.tile(second, len(allowed))] = np.repeat(allowed, len(first))
        worths = _worths(values, pairs, scores)
        for place in np.argsort(-worths, kind="stable")[:_BEGINNINGS].tolist():
            found.append(_climbed(values, scores, _Found(pairs[place], float(worths[place])), allowed))
    best = max(found, key=lambda each: each.worth)
    return best.signs if best.worth > max(alone.max(), 0.0) and np.count_nonzero(best.signs) > 1 else None


def _climbed(values: Floats, scores: Floats, found: _Found, allowed: tuple[float, ...]) -> _Found:
    """Local search: repeat the best change of one sign until none increases the value of the sum."""
    width = len(found.signs)
    column = np.tile(np.arange(width), len(allowed))
    sign = np.repeat(allowed, width)
    while True:
        changed = np.repeat(found.signs[None], len(column), axis=0)
        changed[np.arange(len(column)), column] = np.where(found.signs[column] == sign, 0.0, sign)
        worths = _worths(values, changed, scores)
        worths[np.count_nonzero(changed, axis=1) > MOST_TERMS] = -np.inf
        place = int(np.argmax(worths))
        if worths[place] <= found.worth:
            return found
        found = _Found(changed[place], float(worths[place]))


def _worths(values: Floats, signs: Floats, scores: Floats) -> Floats:
    """[K] log-likelihood gained by sums of columns [n, C] with signs [K, C], minus the price of their terms."""
    shares = np.minimum(explained(values @ signs.T, scores), 1.0 - 1e-9)
    terms = np.count_nonzero(signs, axis=1)
    # Sums of equal signs are more likely: a sum with both signs pays for the choice of its signs.
    choices = np.where((signs < 0.0).any(axis=1), 2.0, 1.0) * values.shape[1]
    return -0.5 * len(scores) * np.log1p(-shares) - np.log(choices) * terms


def explained(columns: Floats, scores: Floats) -> Floats:
    """[C] largest share of the variance of scores [n] that three intervals of each column [n, C] explain.

    >>> explained(np.array([[0.0], [1.0], [2.0], [3.0]]), np.array([0.0, 9.0, 9.0, 0.0]))
    array([1.])
    """
    num = len(scores)
    centred = scores - scores.mean()
    total = float(centred @ centred)
    ends = np.unique(np.linspace(0, num, min(_BOUNDS, num) + 1).astype(np.int64))
    order = np.argsort(columns, axis=0, kind="stable")
    sums = np.concatenate([np.zeros((1, columns.shape[1])), np.cumsum(centred[order], axis=0)])[ends]
    values = np.take_along_axis(columns, order, axis=0)
    # Intervals do not end between equal values.
    end = np.ones((1, columns.shape[1]), dtype=bool)
    apart = np.concatenate([end, values[1:] > values[:-1], end])[ends]
    first, last = np.triu_indices(len(ends), 1)
    size = (ends[last] - ends[first])[:, None]
    inside = sums[last] - sums[first]
    between = inside**2 / size
    for outside, rest in ((sums[first], ends[first]), (-sums[last], num - ends[last])):
        between = between + outside**2 / np.maximum(rest, 1)[:, None]
    between = np.where(apart[first] & apart[last], between, 0.0)
    return between.max(axis=0) / total if total > 0.0 else np.zeros(columns.shape[1])


def _has_support(values: Floats, gated: NDArray[np.bool_], scores: Floats) -> bool:
    """Whether sums found without some of the scores explain these scores better than the use of their terms alone.

    Args:
        values: [n, C] draws.
        gated: [C] whether they are 0 in models that do not use them.
        scores: [n].
    """
    fold = np.empty(len(scores), dtype=np.int64)
    fold[np.argsort(scores, kind="stable")] = np.arange(len(scores)) % _FOLDS
    left = plain = 0.0
    for number in range(_FOLDS):
        held = fold == number
        found = _best(values[~held], scores[~held])
        signs = np.zeros(values.shape[1]) if found is None else found
        sums, used = values @ signs, values[:, gated & (signs != 0.0)] != 0.0
        predicted = scores.mean() if found is None else _predicted(sums[~held], scores[~held], sums[held])
        left += float(((scores[held] - predicted) ** 2).sum())
        of_use = np.unique(used, axis=0, return_inverse=True)[1].reshape(-1)
        number_of = np.bincount(of_use[~held], minlength=of_use.max() + 1)
        means = np.bincount(of_use[~held], scores[~held], of_use.max() + 1) + scores.mean()
        plain += float(((scores - means[of_use] / (number_of[of_use] + 1.0))[held] ** 2).sum())
    return left < (1.0 - _SUPPORT) * min(plain, float(((scores - scores.mean()) ** 2).sum()))


def _predicted(sums: Floats, scores: Floats, others: Floats) -> Floats:
    """The mean score of the models whose sums are nearest."""
    nearest = np.argsort(np.abs(others[:, None] - sums), axis=1, kind="stable")[:, : max(1, len(sums) // _BOUNDS)]
    return scores[nearest].mean(axis=1)
