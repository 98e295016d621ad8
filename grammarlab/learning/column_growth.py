"""Growth of columns if they cannot explain the scores: features of further kinds, and longer paths.

Both are functions of the scored designs and their scores only, independent of their order.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import Floats, Ints
from grammarlab.features.patterns.pattern import Feature
from grammarlab.learning.designs.design_space import AbstractDesignSpace, Designs
from grammarlab.learning.settings import FeatureOptions
from grammarlab.preference.base import MAX_SCORE
from grammarlab.preference.cells.further_columns import NOISES, required_columns
from grammarlab.preference.cells.person_error import BLUNDERS
from grammarlab.preference.likelihood import log_likelihood

FURTHER_FAMILIES = ("paths", "symbols", "draws", "skips", "counts", "comparisons")
"""Kinds of features of which those that the scores need are added."""


def further(
    space: AbstractDesignSpace[Designs],
    designs: Sequence[Designs],
    scores: Floats,
    options: FeatureOptions,
    extra: tuple[Feature, ...],
) -> tuple[Feature, ...]:
    """Features of `FURTHER_FAMILIES` without which cells do not explain scores, and points that explain scores better.

    Args:
        space: the design space.
        designs: all n scored designs.
        scores: [n] their scores.
        options: the features that are used in any case.
        extra: features found by a search, which are used in any case.
    """
    table = space.vocabulary(designs, options).apply(designs)
    others = space.vocabulary(designs, replace(options, families=FURTHER_FAMILIES)).apply(designs)
    new = [index for index, feature in enumerate(others.features) if feature not in table.features]
    joined = {feature: price for feature, price in space.joined(designs, table, scores).items() if feature not in extra}
    points = space.points(table, scores)
    if not new and not joined and not points:
        return ()
    features = (*(others.features[index] for index in new), *joined)
    measured = space.values(designs, (*extra, *joined))
    values = [table.counts.toarray(), measured[:, : len(extra)], others.counts[:, new].toarray()]
    rows, width = np.column_stack([*values, measured[:, len(extra) :]]), len(table.features) + len(extra)
    last = len(extra) + len(others.group_names)
    groups = np.concatenate([np.arange(len(extra)), len(extra) + others.groups[new], last + np.arange(len(joined))])
    groups = groups + len(table.group_names)
    continuous = np.any(rows % 1.0 != 0.0, axis=0)
    prices = np.concatenate([np.zeros(len(new)), list(joined.values())])
    every = np.append(table.groups, groups)
    explanation = required_columns(rows, scores, groups=every, continuous=continuous, num_known=width, prices=prices)
    added = tuple(features[column - width] for column in explanation.columns.tolist())
    evidence = {fit.feature: _log_likelihood(fit.predicted, scores) - fit.price for fit in points}
    best = max(evidence, key=lambda feature: evidence[feature], default=None)
    return added if best is None or evidence[best] <= explanation.log_posterior else (*added, best)


def _log_likelihood(values: Floats, scores: Floats) -> float:
    """Log-likelihood of scores [n] for values [n], with the most likely noise."""
    values = np.clip(values, 0.0, MAX_SCORE)
    return max(float(np.trace(log_likelihood(scores, values, noise, BLUNDERS[1]))) for noise in NOISES)


def path_length(
    space: AbstractDesignSpace[Designs],
    designs: Sequence[Designs],
    scores: Sequence[tuple[Ints, Floats]],
    features: FeatureOptions,
    extra: tuple[Feature, ...],
) -> int:
    """The shortest paths that leave the fewest designs with equal rows and different scores (paper 4.5.1).

    Only scores that were given more than once count: a person with errors gives contradicting scores, and longer paths
    would explain them.

    Args:
        space: the design space.
        designs: all n scored designs.
        scores: for each factor, indices of designs, each once, and their scores.
        features: the features, with the initial length.
        extra: features found by a search, which may also distinguish designs.
    """
    searched = space.values(designs, extra)
    fewest, best = -1, features.path_length
    # Continuous columns distinguish all designs, and so explain nothing.
    counted = replace(features, families=tuple(family for family in features.families if family != "draws"))
    scores = [(indices[again], values[again]) for indices, values in scores for again in (_is_repeated(values),)]
    for length in range(features.path_length, max(features.path_length, space.longest_path) + 1):
        vocabulary = space.vocabulary(designs, replace(counted, path_length=length))
        rows = np.column_stack([vocabulary.apply(designs).rows(), searched])
        number = sum(num_conflicts(rows[indices], values) for indices, values in scores)
        if fewest < 0 or number < fewest:
            fewest, best = number, length
        if not number:
            break
    return best


def _is_repeated(scores: Floats) -> NDArray[np.bool_]:
    """[n] whether scores were given more than once."""
    _, index, counts = np.unique(scores, return_inverse=True, return_counts=True)
    return counts[index.reshape(-1)] > 1


def num_conflicts(rows: Floats, scores: Floats) -> int:
    """Number of sets of designs with equal rows [n, F] and different scores [n], which no function of rows explains.

    >>> num_conflicts(np.array([[1.0], [2.0], [1.0]]), np.array([10.0, 0.0, 90.0]))
    1
    """
    _, kind = np.unique(rows, axis=0, return_inverse=True)
    order = np.lexsort((scores, kind.ravel()))
    kind, scores = kind.ravel()[order], scores[order]
    starts = np.flatnonzero(np.diff(kind, prepend=-1))
    ends = np.append(starts[1:], len(kind)) - 1
    return int((scores[ends] > scores[starts]).sum()) if len(kind) else 0
