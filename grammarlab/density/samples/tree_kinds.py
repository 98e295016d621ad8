"""A species from example trees: kinds with narrower ranges that make the examples likelier.

The examples of a kind of the original are divided in two by a bound on one parameter, again and again, and each part
has its own ranges: a density estimation tree (Ram and Gray, KDD 2011). An end of a range is moved, and a part is
divided, only if the examples get likelier by more nats than chance would allow: n evenly drawn numbers leave a share s
at an end of their range free with probability (1 - s)^n, so that the gain -n log(1 - s) exceeds log(m / p) at one of m
ends with probability p at most.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from grammarlab.arrays import Flags, Floats, Ints
from grammarlab.density.samples.sampled import NUM_SAMPLES
from grammarlab.errors import UsageError
from grammarlab.features.columns.formula_names import MOST_NAMED
from grammarlab.preference.base import MIN_SHARE
from grammarlab.trees.accepted_trees import log_density
from grammarlab.trees.parameters import COLUMNS, IS_INTEGER, IS_LOG, PARAMETERS, SPREAD
from grammarlab.trees.species import Kind, Species

_CHANCE = 0.01
"""Probability with which examples of the original, from which nothing is to be learned, move an end of a range."""
_MAX_KINDS = 64
"""Largest number of kinds, a budget: more are not read by a person."""
_STEPS = 200
"""Ends of ranges are rounded outwards to steps of at least one 200th of the original range."""


def species_of_examples(species: Species, rows: Floats) -> Species:
    """Species near another one that makes examples likely.

    Args:
        species: the original.
        rows: [n, P] parameters of the examples, n >= 1, which it can draw.

    Raises:
        UsageError: If there are no examples, or it cannot draw one of them.
    """
    if not len(rows):
        raise UsageError("there are no example trees to learn from.")
    kind = _kinds_of(species, rows)
    stride = -(-len(rows) // NUM_SAMPLES)
    rows, kind = rows[::stride], kind[::stride]
    kinds = [
        part
        for index in np.unique(kind).tolist()
        for part in _parts_of(species.kinds[index], rows[kind == index], len(rows))
    ]
    low, high = (np.array([getattr(part, end) for part in kinds]) for end in ("low", "high"))
    return replace(species, kinds=tuple(kinds), typical=np.clip(species.typical, low.min(axis=0), high.max(axis=0)))


def _kinds_of(species: Species, rows: Floats) -> Ints:
    """[n] the most probable kind of each tree."""
    logs = np.array(
        [
            np.log(kind.weight) + log_density(replace(species, kinds=(replace(kind, weight=1.0),)), rows)
            for kind in species.kinds
        ]
    )
    impossible = np.flatnonzero(np.isneginf(logs).all(axis=0))
    if len(impossible):
        raise UsageError(
            f"{len(impossible):,} of {len(rows):,} examples are not trees of this species: "
            f"{_reason(species, rows[impossible[0]])}. Learn from trees that the file itself can make."
        )
    return np.argmax(logs, axis=0)


def _reason(species: Species, row: Floats) -> str:
    """The parameter of a tree that the nearest kind cannot have."""
    outside = [(row < kind.low) | (row > kind.high) for kind in species.kinds]
    kind, columns = min(zip(species.kinds, outside, strict=True), key=lambda pair: int(pair[1].sum()))
    column = int(np.flatnonzero(columns)[0])
    return f"{COLUMNS[column]} is {row[column]:.6g}, and not within {kind.low[column]:.6g} to {kind.high[column]:.6g}"


@dataclass(frozen=True, slots=True)
class _Shares:
    """Examples as shares of the ranges of a kind: the C columns that vary."""

    low: Floats
    """[n, C] 0 to 1: the share of the range below each value."""
    high: Floats
    """[n, C] the share up to and including it; the same for continuous columns."""
    is_count: Flags
    """[C]"""

    @classmethod
    def of(cls, kind: Kind, columns: Ints, rows: Floats) -> _Shares:
        """Shares [n, C] of rows [n, P]."""
        low, high = kind.low[columns], kind.high[columns]
        is_count, values = IS_INTEGER[columns], rows[:, columns]
        end = np.where(is_count, high + 1.0, high)
        is_log = IS_LOG[columns]
        step = np.where(is_count, 1.0, 0.0)
        safe, top = np.where(is_log, low, 1.0), np.where(is_log, end, 2.0)

        def share(numbers: Floats) -> Floats:
            logs = np.log(np.where(is_log, numbers, 1.0) / safe) / np.log(top / safe)
            return np.where(is_log, logs, (numbers - low) / (end - low))

        return cls(share(values), share(values + step), is_count)

    @property
    def price(self) -> float:
        """Nats that an end of a range must gain."""
        return math.log(2.0 * max(len(self.is_count), 1) / _CHANCE)

    def ranges(self, num: Floats, low: Floats, high: Floats) -> tuple[Floats, Floats, Floats]:
        """Ends of ranges of parts, and what they gain.

        Args:
            num: [G] examples in each part.
            low: [G, C] smallest share of each.
            high: [G, C] largest share of each.

        Returns:
            [G, C] starts, [G, C] ends, and [G] gains in nats beyond the price.
        """
        num, price = num[:, None], self.price
        # The mean distance of an evenly drawn number from the end of its range, beyond the extreme examples.
        gap = np.where(self.is_count, 0.0, (high - low) / np.maximum(num - 1.0, 1e-9))
        gap = np.maximum(gap, 0.5 * np.maximum(MIN_SHARE - (high - low), 0.0))
        start, end = np.clip(low - gap, 0.0, 1.0 - MIN_SHARE), np.clip(high + gap, MIN_SHARE, 1.0)
        start = np.where(-num * np.log1p(-start) > price, start, 0.0)
        end = np.where(-num * np.log(end) > price, end, 1.0)
        gains = -num * np.log(np.maximum(end - start, MIN_SHARE)) - price * ((start > 0.0).astype(float) + (end < 1.0))
        return start, end, gains.sum(axis=1)


def _parts_of(kind: Kind, rows: Floats, num_all: int) -> Iterator[Kind]:
    """The kinds that the examples of a kind are divided into."""
    # A range of sizes from 0 is drawn evenly, and its upper part, which has a logarithm, would not be.
    columns = np.flatnonzero((kind.low < kind.high) & ~(IS_LOG & (kind.low <= 0.0)))
    shares = _Shares.of(kind, columns, rows)
    pending, leaves = [np.arange(len(rows))], 0
    while pending:
        part = pending.pop()
        halves = _divided(shares, part) if leaves + len(pending) + 2 <= _MAX_KINDS else None
        if halves is not None:
            pending += halves
            continue
        leaves += 1
        yield _narrowed(kind, columns, shares, part, rows, num_all)


def _divided(shares: _Shares, part: Ints) -> list[Ints] | None:
    """The halves of a part; None if it is better left whole."""
    num = len(part)
    if num < 4 or not len(shares.is_count):
        return None
    low, high = shares.low[part], shares.high[part]
    whole = shares.ranges(np.array([num]), low.min(axis=0)[None], high.max(axis=0)[None])[2][0]
    sizes = np.arange(1, num, dtype=np.float64)
    weights = sizes * np.log(sizes / num) + (num - sizes) * np.log(1.0 - sizes / num)
    best, halves = whole + math.log(len(shares.is_count) * num / _CHANCE), None
    for column in range(len(shares.is_count)):
        order = np.argsort(low[:, column], kind="stable")
        ordered_low, ordered_high = low[order], high[order]
        below = (np.minimum.accumulate(ordered_low)[:-1], np.maximum.accumulate(ordered_high)[:-1])
        above = (
            np.minimum.accumulate(ordered_low[::-1])[::-1][1:],
            np.maximum.accumulate(ordered_high[::-1])[::-1][1:],
        )
        gains = weights + shares.ranges(sizes, *below)[2] + shares.ranges(num - sizes, *above)[2]
        gains[ordered_low[1:, column] == ordered_low[:-1, column]] = -np.inf
        index = int(np.argmax(gains))
        if gains[index] > best:
            best, halves = gains[index], [part[order[: index + 1]], part[order[index + 1 :]]]
    return halves


def _narrowed(kind: Kind, columns: Ints, shares: _Shares, part: Ints, rows: Floats, num_all: int) -> Kind:
    """The kind of a part of the examples."""
    low, high = kind.low.copy(), kind.high.copy()
    num, smallest, largest = len(part), shares.low[part].min(axis=0), shares.high[part].max(axis=0)
    start, end, _ = shares.ranges(np.array([num]), smallest[None], largest[None])
    for index, column in enumerate(columns.tolist()):
        values = rows[part, column]
        if start[0, index] > 0.0:
            low[column] = _value(kind, column, start[0, index], values.min(), np.floor)
        if end[0, index] < 1.0:
            high[column] = _value(kind, column, end[0, index], values.max(), np.ceil)
    names = [
        index
        for index in np.argsort(end[0] - start[0], kind="stable").tolist()
        if end[0, index] - start[0, index] < 1.0
    ]
    words = ", ".join(_words(int(columns[index]), low, high) for index in names[:MOST_NAMED])
    return Kind(num / num_all, low, high, words or kind.means)


def _value(kind: Kind, column: int, share: float, extreme: float, outwards: np.ufunc) -> float:
    """An end of a range: of counts the extreme example, otherwise a share of the original range, rounded."""
    low, high = float(kind.low[column]), float(kind.high[column])
    if IS_INTEGER[column]:
        return float(extreme)
    value = low * (high / low) ** share if IS_LOG[column] else low + (high - low) * share
    digits = math.ceil(-math.log10((high - low) / _STEPS))
    rounded = float(np.round(outwards(value * 10.0**digits) / 10.0**digits, max(digits, 0)))
    return min(max(rounded, low), high)


def _words(column: int, low: Floats, high: Floats) -> str:
    name = COLUMNS[column]
    parameter = PARAMETERS[name if name in PARAMETERS else name.removesuffix(SPREAD)]
    return f"{name} {low[column]:.6g} to {high[column]:.6g} {parameter.unit}".rstrip()
