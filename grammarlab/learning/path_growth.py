"""Growth of paths that cannot explain the scores: designs with equal rows and different scores need longer ones."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import Floats, Ints
from grammarlab.features.patterns.pattern import Feature
from grammarlab.learning.designs.design_space import AbstractDesignSpace, Designs
from grammarlab.learning.settings import FeatureOptions


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
        extra: composed columns, which may also distinguish designs.
    """
    composed = space.values(designs, extra)
    fewest, best = -1, features.path_length
    # Continuous columns distinguish all designs, and so explain nothing.
    counted = replace(features, families=tuple(family for family in features.families if family != "draws"))
    scores = [(indices[again], values[again]) for indices, values in scores for again in (_is_repeated(values),)]
    for length in range(features.path_length, max(features.path_length, space.longest_path) + 1):
        _, table = space.tabulated(designs, replace(counted, path_length=length))
        rows = np.column_stack([table.rows(), composed])
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
