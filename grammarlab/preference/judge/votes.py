"""Columns that join flags: how many of a few hold, either of two but not both, an odd number of several.

There are too many to make them all, so the scores choose: pairs by one product of matrices, numbers of flags by a beam,
odd numbers of more flags as bits (`grammarlab.preference.judge.parities`). The price of each is that of its choice
among all.
"""

from __future__ import annotations

from collections.abc import Iterator
from math import comb
from typing import NamedTuple

import numpy as np

from grammarlab.arrays import MANY, MOST_COLUMNS, ROUNDING, Floats
from grammarlab.preference.growth.screening import explained
from grammarlab.preference.judge.parities import odd_sets

MAX_TERMS = 5
"""Largest number of columns of a sum, and of flags that are counted together."""


class Vote(NamedTuple):
    """A column that joins flags."""

    flags: tuple[int, ...]
    """Indices of the flags."""
    signs: tuple[int, ...]
    """1 for each flag that counts, -1 for one that counts if it does not hold."""
    odd: bool
    """Whether the column tells if the number is odd, instead of the number."""
    price: float
    """Log of the number of kinds of votes, of sizes, and of such columns, in nats."""

    def values(self, flags: Floats) -> Floats:
        """[n] the column, for flags [n, F]."""
        held = flags[:, list(self.flags)] == (np.array(self.signs) > 0)
        number = held.sum(axis=1)
        return (number % 2 if self.odd else number).astype(np.float64)


def votes(flags: Floats, scores: Floats) -> list[Vote]:
    """Columns of flags that may explain scores more than each flag alone.

    Args:
        flags: [n, F] 0 or 1, no column constant and no two equal or opposite.
        scores: [n] 0-100.
    """
    if flags.shape[1] < 2 or not np.ptp(scores) > 0.0:
        return []
    kinds = _pairs, _odd, _numbers
    of_kind = float(np.log(len(kinds)))
    return [vote._replace(price=of_kind + vote.price) for kind in kinds for vote in kind(flags, scores)]


def _pairs(flags: Floats, scores: Floats) -> Iterator[Vote]:
    """Either of two flags but not both."""
    even = np.argsort(np.abs(flags.mean(axis=0) - 0.5), kind="stable")[:MOST_COLUMNS]
    signs = 2.0 * flags[:, even] - 1.0
    centred = scores - scores.mean()
    means = signs.T @ signs / len(scores)
    products = (signs * centred[:, None]).T @ signs / np.sqrt(np.maximum(1.0 - means**2, ROUNDING))
    first, second = np.triu_indices(len(even), 1)
    order = np.argsort(-np.abs(products[first, second]), kind="stable")[:MANY]
    price = float(np.log(comb(flags.shape[1], 2)))
    for index in order.tolist():
        yield Vote((int(even[first[index]]), int(even[second[index]])), (1, 1), True, price)


def _odd(flags: Floats, scores: Floats) -> Iterator[Vote]:
    """An odd number of several flags."""
    for members in odd_sets(flags, scores > (scores.min() + scores.max()) / 2.0, MAX_TERMS):
        price = float(np.log(comb(flags.shape[1], len(members))) + np.log(MAX_TERMS - 2))
        yield Vote(members, (1,) * len(members), True, price)


def _numbers(flags: Floats, scores: Floats) -> Iterator[Vote]:
    """How many of a few flags hold."""
    signed = np.concatenate([flags, 1.0 - flags], axis=1).astype(np.int64)
    width = flags.shape[1]
    gains = explained(signed.T, 2, scores)
    beam: list[tuple[int, ...]] = [(int(flag),) for flag in np.argsort(-gains, kind="stable")[:MANY]]
    for size in range(2, min(MAX_TERMS, width) + 1):
        found: dict[frozenset[int], float] = {}
        for members in beam:
            number = signed[:, list(members)].sum(axis=1)
            worth = explained(number + signed.T, size + 1, scores)
            worth[[member % width for member in members]] = -np.inf
            worth[[member % width + width for member in members]] = -np.inf
            for flag in np.argsort(-worth, kind="stable")[:MANY].tolist():
                if np.isfinite(worth[flag]):
                    found[frozenset((*members, flag))] = float(worth[flag])
        ranked = sorted(found, key=lambda members: (-found[members], sorted(members)))
        beam = [tuple(sorted(members)) for members in ranked[:MANY]]
        price = float(np.log(comb(width, size)) + size * np.log(2.0) + np.log(MAX_TERMS - 1))
        for members in beam:
            yield Vote(
                tuple(member % width for member in members),
                tuple(1 if member < width else -1 for member in members),
                False,
                price,
            )
