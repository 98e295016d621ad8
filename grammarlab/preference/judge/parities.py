"""Sets of flags of which an odd number holds where designs are liked, or disliked.

Each flag alone tells nothing, so that such a set cannot be found flag by flag: all sets of few flags are tried, as
bits.
"""

from __future__ import annotations

from collections.abc import Iterator
from math import comb

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import FEW, Flags, Floats

Words = NDArray[np.uint64]

_MAX_TRIALS = 300_000
"""Largest number of sets of a size that are tried, those of the most even flags. More are only slower."""


def odd_sets(flags: Floats, liked: Flags, most: int) -> Iterator[tuple[int, ...]]:
    """Sets of three flags or more whose parity agrees, or disagrees, most with being liked, a few of each size.

    Args:
        flags: [n, F] 0 or 1.
        liked: [n] whether designs are liked.
        most: largest number of flags of a set.

    >>> flags = np.random.default_rng(0).integers(0, 2, (64, 9)).astype(float)
    >>> (2, 4, 5, 8) in odd_sets(flags, flags[:, [2, 4, 5, 8]].sum(axis=1) % 2 == 1, 5)
    True
    """
    even = np.argsort(np.abs(flags.mean(axis=0) - 0.5), kind="stable")
    bits, wanted, num = _packed(flags[:, even].T > 0.0), _packed(liked[None])[0], len(liked)
    # Parities of all sets of the size before, in the order of their last flag: of those before a flag, the first.
    before = np.zeros((1, bits.shape[1]), dtype=np.uint64)
    for size in range(1, most + 1):
        blocks, best = list[Words](), list[tuple[int, int]]()
        for flag in range(size - 1, _width(len(bits), size)):
            parities = before[: comb(flag, size - 1)] ^ bits[flag]
            agreement = np.abs(2 * np.bitwise_count(parities ^ wanted).sum(axis=1, dtype=np.int64) - num)
            better = np.flatnonzero(agreement > (best[-1][0] if len(best) == FEW else 0))
            better = better[np.argsort(-agreement[better], kind="stable")[:FEW]]
            best += [(int(agreement[index]), comb(flag, size) + index) for index in better.tolist()]
            best = sorted(best, reverse=True)[:FEW]
            blocks.append(parities)
        if size >= 3:
            yield from (tuple(sorted(even[list(_set_of(rank, size))].tolist())) for _, rank in best)
        if not blocks:
            return
        before = np.concatenate(blocks)


def _set_of(rank: int, size: int) -> Iterator[int]:
    """The set of a size at a place in the order of last flags, then of the flags before them, last one first.

    >>> [list(_set_of(place, 2)) for place in range(4)]
    [[1, 0], [2, 0], [2, 1], [3, 0]]
    """
    for remaining in range(size, 0, -1):
        flag = remaining - 1
        while comb(flag + 1, remaining) <= rank:
            flag += 1
        yield flag
        rank -= comb(flag, remaining)


def _width(number: int, size: int) -> int:
    """Number of flags of which all sets of a size are tried."""
    while comb(number, size) > _MAX_TRIALS:
        number -= 1
    return number


def _packed(bits: Flags) -> Words:
    """[F, W] bits [F, n] in words of 64."""
    padded = np.pad(bits, ((0, 0), (0, -bits.shape[1] % 64)))
    return np.packbits(padded, axis=1).view(np.uint64)
