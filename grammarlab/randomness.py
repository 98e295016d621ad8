"""Addressed random numbers: a draw is a pure function of its place.

A key is one 64-bit word. Keys form a tree: the root key of a model comes from the seed and the model's index, a
child's key from its parent's key and its place. A draw is the key hashed with the draw's own site. Nothing is streamed,
so model 17 of seed 5 is the same alone, in any batch and on any worker.

The hash is the finaliser of SplitMix64 (Steele, Lea and Flood, OOPSLA 2014, "Fast splittable pseudorandom number
generators"), applied to ``key + (word + 1) * golden ratio``.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Keys = NDArray[np.uint64]

_GOLDEN = 0x9E3779B97F4A7C15
_MIX_1 = np.uint64(0xBF58476D1CE4E5B9)
_MIX_2 = np.uint64(0x94D049BB133111EB)
_30, _27, _31, _11 = np.uint64(30), np.uint64(27), np.uint64(31), np.uint64(11)
_TO_UNIT = 2.0**-53


def _step(words: int | NDArray[np.integer]) -> NDArray[np.uint64] | np.uint64:
    if isinstance(words, int):
        return np.uint64((words + 1) * _GOLDEN & 0xFFFFFFFFFFFFFFFF)
    return (words.astype(np.uint64) + np.uint64(1)) * np.uint64(_GOLDEN)


def fold(keys: Keys, words: int | NDArray[np.integer]) -> Keys:
    """The keys [N] of the places ``words`` (integers >= 0, a scalar or [N]) below ``keys`` [N]."""
    z = keys + _step(words)
    z ^= z >> _30
    z *= _MIX_1
    z ^= z >> _27
    z *= _MIX_2
    z ^= z >> _31
    return z


def root_keys(seed: int | Keys, models: NDArray[np.integer]) -> Keys:
    """Keys [N] of models from their indices and a seed (any integer below 2**64), or one seed per model [N]."""
    return fold(fold(np.zeros(len(models), np.uint64), seed), models)


def uniforms(keys: Keys, site: int | NDArray[np.integer]) -> NDArray[np.float64]:
    """One uniform draw in [0, 1) for each key, at a site (an integer >= 0, a scalar or one per key)."""
    return (fold(keys, site) >> _11).astype(np.float64) * _TO_UNIT


def derived_seed(seed: int, *path: int) -> int:
    """Seed of a branch below a seed: 0 <= result < 2**64, different for different paths.

    Args:
        seed: 0 <= seed < 2**64.
        path: indices of the branches below the seed, each at least 0; at least one.
    """
    key = root_keys(seed, np.array(path[:1]))
    for index in path[1:]:
        key = fold(key, index)
    return int(key[0])
