"""Columns composed of others that the scores need: candidates of the language of tastes, votes and weighted sums.

They are a function of the scored designs and their scores only, independent of their order.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial, reduce

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import MOST_COLUMNS, Flags, Floats
from grammarlab.features.patterns.pattern import Atom, Feature, Formula
from grammarlab.learning.chosen_candidates import chosen_candidates
from grammarlab.learning.designs.design_space import AbstractDesignSpace, Designs
from grammarlab.learning.settings import FeatureOptions
from grammarlab.preference.growth.ranks import ranks_of
from grammarlab.preference.judge.judge import judged
from grammarlab.preference.judge.votes import Vote
from grammarlab.preference.judge.weighted_sums import Measures
from grammarlab.tastes.language import Candidates
from grammarlab.tastes.quantities import is_short


def composed_columns(
    space: AbstractDesignSpace[Designs], designs: Sequence[Designs], scores: Floats, options: FeatureOptions
) -> dict[Feature, float]:
    """Features without which known columns do not explain scores, and the price of each in nats.

    Args:
        space: the design space.
        designs: all n scored designs, in batches.
        scores: [n] their scores.
        options: the known columns.
    """
    _, table = space.tabulated(designs, options)
    known = table.counts.toarray()
    candidates = space.candidates(designs)
    chosen = list(chosen_candidates(candidates.elements, scores))
    columns = np.concatenate([candidates.values, *(one.values[:, None] for one in chosen)], axis=1)
    prices = np.append(candidates.prices, [one.price for one in chosen])
    makers = [*candidates.makers, *(one.formula for one in chosen)]
    new = np.flatnonzero(~_same(columns, known))
    flags, of_flags = _flags(known, table.features)
    measures, of_measures = _measures(known, table.features, candidates)
    verdict = judged(_varying(known), columns[:, new], prices[new], flags, measures, scores)
    found = [makers[new[index]]() for index in verdict.accepted]
    found += [_formula(vote, of_flags) for vote in verdict.votes]
    found += [_weighed(some.columns, some.weights, of_measures) for some in verdict.sums]
    return dict(zip(found, verdict.prices, strict=True))


def _varying(columns: Floats) -> Floats:
    """The columns that are not constant."""
    return columns[:, np.ptp(columns, axis=0) > 0.0]


def _same(columns: Floats, others: Floats) -> Flags:
    """[C] whether a column orders the designs as one of the others does, or in reverse."""
    directions, of_others = _directions(columns), _directions(others)
    # Most columns rise or fall otherwise between some designs, which is seen without sorting them.
    same = _alike(_rising(directions), _rising(of_others))
    ranks = ranks_of(columns[:, same] * _signs(directions[same])), ranks_of(others * _signs(of_others))
    same[same] = _alike(*ranks)
    return same


def _alike(rows: NDArray[np.integer], others: NDArray[np.integer]) -> Flags:
    """[C] whether a row is equal to one of the others."""
    known = {row.tobytes() for row in others}
    return np.array([row.tobytes() in known for row in rows], dtype=bool)


def _directions(columns: Floats) -> NDArray[np.int8]:
    """[C, n-1] -1, 0 or 1 as each column falls, stays or rises from one design to the next."""
    return np.ascontiguousarray(np.sign(np.diff(columns, axis=0)).T.astype(np.int8))


def _signs(directions: NDArray[np.int8]) -> NDArray[np.int8]:
    """[C] -1 where the first step that is not level is a fall, otherwise 1."""
    first = (directions != 0).argmax(axis=1) if directions.shape[1] else np.zeros(len(directions), dtype=np.int64)
    steps = np.pad(directions, ((0, 0), (0, 1)))[np.arange(len(directions)), first]
    return np.where(steps < 0, -1, 1).astype(np.int8)


def _rising(directions: NDArray[np.int8]) -> NDArray[np.int8]:
    """[C, n-1] the directions, those of columns that begin with a fall in reverse."""
    return directions * _signs(directions)[:, None]


def _flags(known: Floats, features: Sequence[Feature]) -> tuple[Floats, list[Atom | Formula]]:
    """The different known columns of 0 and 1."""
    is_flag = ((known == 0.0) | (known == 1.0)).all(axis=0) & (np.ptp(known, axis=0) > 0.0)
    indices = np.flatnonzero(is_flag)
    # Opposite flags say the same.
    _, first = np.unique(np.abs(known[:, indices] - known[:1, indices]), axis=1, return_index=True)
    flags = [(index, features[index]) for index in indices[np.sort(first)].tolist()]
    readable = [(index, feature) for index, feature in flags if isinstance(feature, Atom | Formula)]
    return known[:, [index for index, _ in readable]], [feature for _, feature in readable]


def _measures(
    known: Floats, features: Sequence[Feature], candidates: Candidates
) -> tuple[Measures, list[Callable[[], Feature]]]:
    """The known columns that vary and that formulas can read, draws where a model uses them, and cheap candidates."""
    varying = np.flatnonzero(np.ptp(known, axis=0) > 0.0).tolist()
    readable = [index for index in varying if isinstance(features[index], Atom | Formula)]
    used = candidates.elements.used
    partly = [index for index, formula in enumerate(used.formulas) if isinstance(formula, Formula)]
    num = len(readable) + len(partly)
    cheap = np.argsort(candidates.prices, kind="stable")[: max(2 * MOST_COLUMNS - num, 0)]
    makers = [
        *(partial(features.__getitem__, index) for index in readable),
        *(partial(used.formulas.__getitem__, index) for index in partly),
        *(candidates.makers[index] for index in cheap.tolist()),
    ]
    measures = Measures(
        values=np.concatenate([known[:, readable], used.values[:, partly], candidates.values[:, cheap]], axis=1),
        # With even odds it is a candidate of the language, whose price says so.
        prices=np.append(np.full(num, np.log(2.0) + np.log(max(num, 1))), candidates.prices[cheap]),
        can_be_added=lambda columns: is_short(_weighed(columns, np.full(len(columns), 0.125).tolist(), makers)),
    )
    return measures, makers


def _weighed(
    columns: Sequence[int], weights: Sequence[float], makers: Sequence[Callable[[], Feature]]
) -> Atom | Formula:
    first, *others = (part for column in columns if isinstance(part := makers[column](), Atom | Formula))
    total = first
    for part, weight in zip(others, weights[1:], strict=True):
        size = abs(weight)
        total = Formula.of("+" if weight > 0.0 else "-", total, part if size == 1.0 else Formula.of("*", size, part))
    return total


def _formula(vote: Vote, features: Sequence[Atom | Formula]) -> Atom | Formula:
    signed = [
        features[flag] if sign > 0 else Formula.of("not", features[flag])
        for flag, sign in zip(vote.flags, vote.signs, strict=True)
    ]
    return reduce(lambda a, b: Formula.of("!=" if vote.odd else "+", a, b), signed)
