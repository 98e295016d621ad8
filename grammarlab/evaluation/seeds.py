"""Seeds that follow from other seeds."""

from __future__ import annotations

import numpy as np

from grammarlab.randomness import fold, root_keys


def derived_seed(seed: int, *places: int) -> int:
    """A seed for a place below a seed: 0 <= result < 2**64, different for different places.

    Args:
        seed: 0 <= seed < 2**64.
        places: >= 0, at least one.
    """
    key = root_keys(seed, np.array(places[:1]))
    for place in places[1:]:
        key = fold(key, place)
    return int(key[0])
