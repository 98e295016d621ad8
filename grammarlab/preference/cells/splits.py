"""Splits of designs into two or more parts, with prior probabilities, and intervals that explain scores.

Columns of one group are alternatives of one choice: a group may divide designs by all of its alternatives at once. A
count divides them at a bound, at one number, into odd and even, or number by number; a continuous column at a bound.
Each group has the same share of the prior mass, since few groups matter; a continuous one has less, since it can
explain anything.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import Flags, Floats, Ints

_CONTINUOUS_SHARE = 0.15
"""Prior mass of a continuous group; all others have 1."""
_MAX_BOUNDS = 24
"""Number of bounds on a continuous column, evenly spaced by rank."""
_MAX_NUMBERS = 10
"""Largest number of different counts that are divided number by number; others are divided at bounds only."""
_MAX_PARTS = 12
"""Largest number of patterns of a group that are parts of one split."""
_TOLERANCE = 1e-6
"""Largest difference, or squared distance, of equal values of columns; it allows for rounding errors."""
_PIECE_BITS = 31
"""Number of bits of a random number per sum: sums of 2^22 such numbers are exact in float64."""


class Above(NamedTuple):
    """Whether a column is above a bound."""

    column: int
    bound: float

    @property
    def columns(self) -> tuple[int, ...]:
        """Indices of the columns that the split reads."""
        return (self.column,)

    def parts(self, rows: Floats) -> Ints:
        """[m] number of the part of each row."""
        return (rows[:, self.column] > self.bound).astype(np.int64)


class Equal(NamedTuple):
    """Whether a column has a value."""

    column: int
    value: float

    @property
    def columns(self) -> tuple[int, ...]:
        """Indices of the columns that the split reads."""
        return (self.column,)

    def parts(self, rows: Floats) -> Ints:
        """[m] number of the part of each row."""
        return (np.abs(rows[:, self.column] - self.value) < _TOLERANCE).astype(np.int64)


class Odd(NamedTuple):
    """Whether a column is an odd number of steps away from a value."""

    column: int
    first: float
    step: float

    @property
    def columns(self) -> tuple[int, ...]:
        """Indices of the columns that the split reads."""
        return (self.column,)

    def parts(self, rows: Floats) -> Ints:
        """[m] number of the part of each row."""
        return np.round((rows[:, self.column] - self.first) / self.step).astype(np.int64) % 2


class Patterns(NamedTuple):
    """Index of the pattern of the columns; -1 for none of them."""

    columns: tuple[int, ...]
    patterns: Floats
    """[parts, columns] values of the columns in each part."""

    def parts(self, rows: Floats) -> Ints:
        """[m] number of the part of each row."""
        distance = ((rows[:, None, list(self.columns)] - self.patterns) ** 2).sum(axis=2)
        nearest = distance.argmin(axis=1)
        return np.where(distance[np.arange(len(rows)), nearest] < _TOLERANCE, nearest, -1)


Split = Above | Equal | Odd | Patterns


@dataclass(frozen=True, eq=False)
class Splits:
    """All splits of n labelled rows."""

    splits: tuple[Split, ...]
    """[S] splits, in the order of their groups."""
    parts: NDArray[np.int16]
    """[S, n] number of the part of each row."""
    log_prior: Floats
    """[S] log of the prior mass; the masses sum to at most 1."""
    halves: Flags
    """[H, n] the different splits of all labels into two; the first label is on the side of zeros."""
    half_of: Ints
    """[S] index of each split in `halves`; -1 for splits into more parts."""
    log_mass: Floats
    """[H] log of the prior mass of each of `halves`."""
    many: Ints
    """[M] splits into more than two parts, without duplicates."""
    members: NDArray[np.float32]
    """[parts of all splits of `many`, n] 1 if a row is in a part."""
    starts: Ints
    """[M] index of the first part of each of `many`."""

    def drawn(self, ways: Ints, randomness: np.random.Generator) -> int:
        """One of the splits equal to given divisions, drawn in proportion to prior mass.

        Args:
            ways: indices into `halves`, then `many`.
            randomness: generator.
        """
        way = int(ways[_drawn(self._mass[ways], randomness)])
        if way >= len(self.halves):
            return int(self.many[way - len(self.halves)])
        alike = self._by_half[self._starts[way] : self._starts[way + 1]]
        return int(alike[_drawn(np.exp(self.log_prior[alike]), randomness)])

    @cached_property
    def _mass(self) -> Floats:
        """[H + M] prior mass of `halves`, then `many`."""
        return np.exp(np.concatenate([self.log_mass, self.log_prior[self.many]]))

    @cached_property
    def _by_half(self) -> Ints:
        """[S] splits, ordered by `half_of`."""
        return np.argsort(self.half_of, kind="stable")

    @cached_property
    def _starts(self) -> Ints:
        """[H + 1] where the splits of each half begin among them."""
        return np.searchsorted(self.half_of[self._by_half], np.arange(len(self.halves) + 1))

    def mass_of(self, part_of: Ints, labels: Ints) -> float:
        """Prior mass of all splits equal to a given division; 0 if there is none.

        Args:
            part_of: [c] the part of each label.
            labels: [c] indices.
        """
        if not np.ptp(part_of):
            return 0.0
        if len(np.unique(part_of)) == 2:
            halves = self.halves[:, labels]
            alike = ((halves ^ halves[:, :1]) == (part_of != part_of[0])).all(axis=1)
            return float(np.exp(self.log_mass[alike]).sum())
        parts = self.parts[self.many][:, labels]
        _, first, part_index = np.unique(part_of, return_index=True, return_inverse=True)
        several = np.array([len(np.unique(numbers)) for numbers in parts], dtype=np.int64) == len(first)
        alike = several & (parts == parts[:, first[part_index.reshape(-1)]]).all(axis=1)
        return float(np.exp(self.log_prior[self.many[alike]]).max(initial=0.0))

    @classmethod
    def of(
        cls,
        rows: Floats,
        groups: Ints,
        continuous: Flags,
        scores: Floats,
        near: Collection[Above] = (),
        priors: Floats | None = None,
    ) -> Splits:
        """Splits that distinguish rows.

        Columns of many values are divided at some bounds, evenly spaced by rank, and at both ends of the interval that
        explains the scores best.

        Args:
            rows: [n, F] rows to divide.
            groups: [F] group numbers.
            continuous: [F] whether columns are continuous instead of counts.
            scores: [n] scores of the rows, 0-100.
            near: splits near which columns of many values are divided at every bound.
            priors: [F] how likely columns are to matter, relative to each other; None if all are equally likely. A
                group has the prior of its most likely column.
        """
        varying = np.flatnonzero(np.ptp(rows, axis=0) > 0.0) if len(rows) else np.zeros(0, dtype=np.int64)
        bounds = _bounds_of(rows, varying, scores, near)
        shares = {
            group: _CONTINUOUS_SHARE if continuous[varying[groups[varying] == group]].all() else 1.0
            for group in np.unique(groups[varying]).tolist()
        }
        if priors is not None:
            shares = {group: share * float(priors[groups == group].max()) for group, share in shares.items()}
        total = sum(shares.values())
        splits: list[Split] = []
        log_prior: list[float] = []
        for group, share in shares.items():
            for mass, subset in _of_group(rows, varying[groups[varying] == group], continuous, bounds):
                splits += subset
                log_prior += [float(np.log(mass * share / total / len(subset)))] * len(subset)
        parts = np.array([split.parts(rows) for split in splits], dtype=np.int16).reshape(len(splits), len(rows))
        sizes = parts.max(axis=1, initial=0) + 1
        two, many = np.flatnonzero(sizes == 2), np.flatnonzero(sizes > 2)
        sides = (parts[two] == 1) ^ (parts[two][:, :1] == 1)
        first, half_index = different(sides)
        half_of = np.full(len(splits), -1)
        half_of[two] = half_index
        many = many[np.sort(np.unique(parts[many], axis=0, return_index=True)[1])] if len(many) else many
        members = [parts[split] == np.arange(sizes[split])[:, None] for split in many]
        return cls(
            tuple(splits),
            parts,
            np.array(log_prior),
            sides[first],
            half_of,
            np.log(np.bincount(half_index, np.exp(np.array(log_prior)[two]))),
            many,
            np.concatenate([np.zeros((0, len(rows)), dtype=bool), *members]).astype(np.float32),
            np.cumsum(np.append(0, sizes[many]))[:-1].astype(np.int64),
        )


def best_intervals(values: Floats, scores: Floats) -> Floats:
    """[C, 2] ends of the interval of each column [n, C] inside and outside of which scores [n] vary least.

    Ends lie halfway between neighbouring values, or are infinite.

    >>> best_intervals(np.array([[1.0], [2.0], [3.0], [5.0]]), np.array([0.0, 90.0, 80.0, 10.0])).tolist()
    [[1.5, 4.0]]
    """
    num, width = values.shape
    order = np.argsort(values, axis=0, kind="stable")
    ascending = np.take_along_axis(values, order, axis=0)
    sums = np.concatenate([np.zeros((1, width)), np.cumsum((scores - scores.mean())[order], axis=0)])
    bounds = np.full((num + 1, width), np.inf)
    bounds[0] = -np.inf
    bounds[1:num] = (ascending[1:] + ascending[:-1]) / 2.0
    # No interval ends between equal values.
    apart = np.ones((num + 1, width), dtype=bool)
    apart[1:num] = ascending[1:] > ascending[:-1]
    ends = np.empty((width, 2))
    first, last = np.triu_indices(num + 1, 1)
    is_partial = last - first < num
    first, last = first[is_partial], last[is_partial]
    size = (last - first).astype(np.float64)
    # Scores are centred, so that what is outside has the opposite sum.
    scale = 1.0 / size + 1.0 / (num - size)
    # Column by column, since pairs of bounds are many.
    for column in range(width):
        inside = sums[last, column] - sums[first, column]
        between = np.where(apart[first, column] & apart[last, column], inside**2 * scale, -1.0)
        best = int(np.argmax(between)) if len(between) else 0
        ends[column] = (bounds[first[best], column], bounds[last[best], column]) if len(between) else (-np.inf, np.inf)
    return ends


def different(sides: Flags) -> tuple[Ints, Ints]:
    """[K] the first of each set of equal rows [J, c], and [J] the index of each row among these."""
    # Rows are compared by random sums of their columns: sums of different rows are almost never equal.
    factors = _factors(sides.shape[1])
    # BLAS adds floats many times faster than integers; sums wrap at 2^64.
    low, high = (
        sides.astype(np.float64) @ np.stack([factors % 2**_PIECE_BITS, factors >> _PIECE_BITS], axis=1)
    ).T.astype(np.int64)
    _, first, index = np.unique(low + (high << _PIECE_BITS), return_index=True, return_inverse=True)
    return first, index.reshape(-1)


def _drawn(mass: Floats, randomness: np.random.Generator) -> int:
    """An index, drawn in proportion to mass."""
    total = np.cumsum(mass)
    return int(np.searchsorted(total, randomness.random() * total[-1], side="right").clip(0, len(mass) - 1))


def _bounds_of(rows: Floats, columns: Ints, scores: Floats, near: Collection[Above]) -> dict[int, Floats]:
    """Bounds on columns: all of them if there are few values."""
    ascending = np.sort(rows[:, columns], axis=0)
    middle, apart = (ascending[1:] + ascending[:-1]) / 2.0, ascending[1:] > ascending[:-1]
    bounds = {column: middle[apart[:, index], index] for index, column in enumerate(columns.tolist())}
    many = [column for column, column_bounds in bounds.items() if len(column_bounds) > _MAX_BOUNDS]
    for column, ends in zip(many, best_intervals(rows[:, many], scores) if many else (), strict=True):
        bounds[column] = _some(bounds[column], ends, [split.bound for split in near if split.column == column])
    return bounds


def _some(bounds: Floats, exactly: Floats, around: Sequence[float]) -> Floats:
    """Some of ascending bounds: evenly spaced by rank, some exact ones, and all next to others."""
    few = np.linspace(0, len(bounds) - 1, _MAX_BOUNDS).astype(np.int64)
    is_selected = np.isin(bounds, exactly)
    is_selected[few] = True
    for index in np.searchsorted(bounds[few], around).tolist():
        is_selected[few[max(index - 1, 0)] : few[min(index + 1, _MAX_BOUNDS - 1)]] = True
    return bounds[is_selected]


def _of_group(
    rows: Floats, columns: Ints, continuous: Flags, bounds: Mapping[int, Floats]
) -> Iterator[tuple[float, Sequence[Split]]]:
    """Sets of splits of a group, each with its share of the prior mass of the group."""
    counts, rest = columns[~continuous[columns]], 1.0
    if len(counts) > 1:
        patterns = np.unique(rows[:, counts], axis=0)
        if 2 < len(patterns) <= _MAX_PARTS:
            rest = 0.5
            yield 0.5, [Patterns(tuple(counts.tolist()), patterns)]
    for column in columns.tolist():
        share, above = rest / len(columns), [Above(column, bound) for bound in bounds[column].tolist()]
        if continuous[column] or not 1 < len(above) < _MAX_NUMBERS:
            yield share, above
            continue
        values = np.unique(rows[:, column])
        yield 0.6 * share, above
        yield 0.2 * share, [Equal(column, value) for value in values[1:-1].tolist()]
        yield 0.1 * share, [Patterns((column,), values[:, None])]
        yield 0.1 * share, [Odd(column, float(values[0]), float(np.diff(values).min()))]


@cache
def _factors(number: int) -> Ints:
    """[number] different random numbers from 1 to 2^62."""
    return np.random.default_rng(0).integers(1, 2**62, number, dtype=np.int64)
