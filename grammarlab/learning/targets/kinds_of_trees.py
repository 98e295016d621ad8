"""Kinds of a learned species: the kinds of the original, each divided at bounds on parameters.

Each leaf of a regression tree over parameters is a box of ranges. A part of a kind in such a box has its mass, times
the score of the leaf, as weight, and draws evenly within its ranges as before. So the density of all parts is that of
the species times the scores, exactly.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from grammarlab.arrays import ROUNDING, Flags, Floats
from grammarlab.features.columns.formula_names import MOST_NAMED
from grammarlab.learning.designs.tree_columns import unit_of, words_of_name
from grammarlab.preference.regression_tree import Split
from grammarlab.preference.simplified import SimplifiedPreference
from grammarlab.trees.parameters import COLUMN, COLUMNS, IS_INTEGER, IS_LOG
from grammarlab.trees.species import Kind, Species

_HABITS: Mapping[str, tuple[str, str]] = {
    "scale": ("small", "tall"),
    "ratio": ("slender", "stout"),
    "base_size": ("low-branched", "bare below"),
    "length_1": ("narrow", "spreading"),
    "down_angle_1": ("ascending", "drooping"),
    "branches_1": ("open", "dense"),
    "leaves": ("sparse", "leafy"),
}
"""Words for trees in the lower and in the upper half of a range."""


class Part(NamedTuple):
    """A part of a kind."""

    kind: int
    """Index of the kind in the original species."""
    score: float
    low: Floats
    """[P] start of each range; this and the next as in `Kind`."""
    high: Floats


def divisible(species: Species) -> Flags:
    """[P] columns whose ranges can be divided exactly: a part of a range is drawn on the scale of the whole.

    A range of sizes that begins at 0 is drawn evenly, and its upper part, which does not, would be drawn by logarithm.
    """
    from_zero = np.any([(kind.low <= 0.0) & (kind.high > kind.low) for kind in species.kinds], axis=0)
    return ~(IS_LOG & from_zero)


def parts_of(species: Species, preference: SimplifiedPreference, columns: Sequence[str]) -> list[Part]:
    """Parts with scores above 0; neighbouring parts of equal scores are merged.

    Args:
        species: the original.
        preference: a function of parameters, in their units.
        columns: [F] names of its columns.
    """
    boxes = [
        (score, low, high)
        for score, low, high in zip(
            preference.scores.tolist(),
            *_bounds(preference.tree, [COLUMN.get(name, -1) for name in columns]),
            strict=True,
        )
        if score > 0.0
    ]
    parts = [
        part
        for index, kind in enumerate(species.kinds)
        for box in boxes
        if (part := _inside(index, kind, *box)) is not None
    ]
    return _merged(parts)


def with_parts(species: Species, parts: Sequence[Part]) -> Species:
    """The species whose kinds are parts, weighted by mass and score.

    Args:
        species: the original.
        parts: at least one.
    """
    weights = np.array([part.score * mass_of(species.kinds[part.kind], part) for part in parts])
    weights *= [species.kinds[part.kind].weight for part in parts]
    weights /= weights.sum()
    order = np.argsort(-weights, kind="stable").tolist()
    kinds = tuple(
        Kind(float(weights[index]), parts[index].low, parts[index].high, words_of(species, parts[index]))
        for index in order
    )
    return replace(species, kinds=kinds, typical=np.clip(species.typical, kinds[0].low, kinds[0].high))


def mass_of(kind: Kind, part: Part) -> float:
    """Probability of a part among the trees of a kind."""
    return float(np.exp(np.log(_shares(kind, part)).sum()))


def words_of(species: Species, part: Part) -> str:
    """A part in words: how its ranges differ from those of its kind."""
    kind = species.kinds[part.kind]
    shares = _shares(kind, part)
    narrow = [int(column) for column in np.argsort(shares, kind="stable") if shares[column] < 1.0 - ROUNDING]
    habits = [word for column in narrow if (word := _habit(kind, part, column))]
    conditions = [_range_words(kind, part, column) for column in narrow[:MOST_NAMED]]
    conditions += ["…"] if len(narrow) > MOST_NAMED else []
    text = f"{', '.join(habits[:2])}: {', '.join(conditions)}" if habits and conditions else ", ".join(conditions)
    return f"{kind.means}; {text}" if kind.means and text else kind.means or text


def _habit(kind: Kind, part: Part, column: int) -> str:
    """A word for a part in one half of a range; empty if there is none."""
    words = _HABITS.get(COLUMNS[column])
    if words is None:
        return ""
    scale = np.log if IS_LOG[column] and kind.low[column] > 0.0 else float
    low, high, start, end = (scale(float(ends[column])) for ends in (kind.low, kind.high, part.low, part.high))
    middle = (low + high) / 2.0
    return words[0] if end <= middle else words[1] if start >= middle else ""


def _range_words(kind: Kind, part: Part, column: int) -> str:
    name, unit = words_of_name(COLUMNS[column]), unit_of(COLUMNS[column])
    unit = unit if unit in ("", "°") else f" {unit}"
    low, high = (f"{float(ends[column]):.3g}" for ends in (part.low, part.high))
    if part.low[column] == part.high[column]:
        return f"{name} {low}{unit}"
    if part.low[column] <= kind.low[column]:
        return f"{name} {'at most' if IS_INTEGER[column] else 'below'} {high}{unit}"
    if part.high[column] >= kind.high[column]:
        return f"{name} {'at least' if IS_INTEGER[column] else 'from'} {low}{unit}"
    return f"{name} {low} to {high}{unit}"


def _bounds(tree: Sequence[Split], columns: Sequence[int]) -> tuple[list[Floats], list[Floats]]:
    """[P] lower bounds, included, and upper ones, excluded, of each leaf."""
    low, high = [np.full(len(COLUMNS), -np.inf)], [np.full(len(COLUMNS), np.inf)]
    for split in tree:
        column = columns[split.column]
        low.append(low[split.leaf].copy())
        high.append(high[split.leaf].copy())
        low[-1][column] = max(low[-1][column], split.bound)
        high[split.leaf][column] = min(high[split.leaf][column], split.bound)
    return low, high


def _inside(index: int, kind: Kind, score: float, low: Floats, high: Floats) -> Part | None:
    """The part of a kind between bounds; None if it is empty."""
    # Constants are single values, as whole numbers are.
    single = IS_INTEGER | (kind.low == kind.high)
    start = np.maximum(kind.low, np.where(IS_INTEGER, np.ceil(low), low))
    end = np.minimum(kind.high, np.where(IS_INTEGER, np.ceil(high) - 1.0, high))
    is_empty = np.where(single, (start > end) | (~IS_INTEGER & (kind.low >= high)), start >= end)
    return None if is_empty.any() else Part(index, score, start, end)


def _shares(kind: Kind, part: Part) -> Floats:
    """[P] share of the range of each column of a kind that a part has."""
    end, whole_end = (np.where(IS_INTEGER, high + 1.0, high) for high in (part.high, kind.high))
    varies = kind.low < kind.high
    log = IS_LOG & (kind.low > 0.0) & varies
    one = np.ones(len(varies))
    size = np.where(log, np.log(np.where(log, end, 1.0) / np.where(log, part.low, 1.0)), end - part.low)
    whole = np.where(log, np.log(np.where(log, whole_end, 1.0) / np.where(log, kind.low, 1.0)), whole_end - kind.low)
    return np.where(varies, size / np.where(varies, whole, 1.0), one)


def _merged(parts: list[Part]) -> list[Part]:
    """Parts without neighbours of the same kind and score that differ in one range only."""
    parts = list(parts)
    pairs = _neighbours(parts)
    while (pair := next(pairs, None)) is not None:
        first, second = pair
        union = parts[first]._replace(
            low=np.minimum(parts[first].low, parts[second].low), high=np.maximum(parts[first].high, parts[second].high)
        )
        parts = [part for index, part in enumerate(parts) if index not in (first, second)] + [union]
        pairs = _neighbours(parts)
    return parts


def _neighbours(parts: Sequence[Part]) -> Iterator[tuple[int, int]]:
    step = np.where(IS_INTEGER, 1.0, 0.0)
    for second, part in enumerate(parts):
        for first, other in enumerate(parts[:second]):
            if (part.kind, part.score) != (other.kind, other.score):
                continue
            different = np.flatnonzero((part.low != other.low) | (part.high != other.high))
            if len(different) != 1:
                continue
            column = int(different[0])
            if step[column] + min(part.high[column], other.high[column]) == max(part.low[column], other.low[column]):
                yield first, second
