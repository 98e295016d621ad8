"""Random facades of whole metres, in which many sides are exactly above or beside each other."""

import numpy as np
from hypothesis import strategies as st

from grammarlab.facade.tree import Facade
from tests.facade.samples import Node, across, built, leaf, stacked

LABELS = ("wall", "wall", "window", "door", "cornice")


@st.composite
def integer_facades(draw: st.DrawFn, width: int = 12, height: int = 9) -> Facade:
    """A guillotine tree with cuts at whole metres."""
    randomness = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))

    def divided(size: tuple[int, int], along: int, depth: int) -> Node:
        if size[along] < 2 or depth > 3 or (depth > 1 and randomness.random() < 0.3):
            return leaf(str(randomness.choice(LABELS)), *size)
        num = min(size[along] - 1, int(randomness.integers(1, 5)))
        cuts = np.sort(randomness.choice(np.arange(1, size[along]), num, replace=False)).tolist()
        lengths = np.diff([0, *cuts, size[along]]).tolist()
        parts = [divided((one, size[1]) if along == 0 else (size[0], one), 1 - along, depth + 1) for one in lengths]
        return across(*parts) if along == 0 else stacked(*parts)

    return built(divided((width, height), int(randomness.integers(2)), 0))
