"""Random facades."""

import numpy as np
from hypothesis import strategies as st

from grammarlab.facade.tree import LEAF, Facade, laid_out, plain


@st.composite
def trees(draw: st.DrawFn, max_nodes: int = 40) -> Facade:
    """A random guillotine tree."""
    randomness = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    parent, axis = [-1], [LEAF]

    def divide(node: int, along: int, depth: int) -> None:
        if depth > 4 or len(parent) >= max_nodes or (depth and randomness.random() < 0.4):
            return
        axis[node] = along
        for _ in range(int(randomness.integers(2, 5))):
            parent.append(node)
            axis.append(LEAF)
            divide(len(parent) - 1, 1 - along, depth + 1)

    divide(0, int(randomness.integers(2)), draw(st.integers(0, 1)))
    wanted = randomness.uniform(0.1, 3.0, (len(parent), 2))
    position, size = laid_out(np.array(parent), np.array(axis, dtype=np.int8), wanted)
    names = [str(randomness.choice(["wall", "window", ""])) if each == LEAF else "" for each in axis]
    return plain(np.array(parent), np.array(axis, dtype=np.int8), position, size, names)
