"""Parts of a facade as springs: preferred size along an axis, and give.

A leaf is a spring, parts in a row are springs in series, and parts side by side across are parallel springs. So each
part is a spring, and the energy of a facade without grids is in closed form: grids can only increase it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from grammarlab.facade.tree import LEAF, Facade, Floats

_STIFF = 1e-6
"""Give of a held spring, as a fraction of its own: 0 would not allow parallel held springs."""


@dataclass(frozen=True, slots=True)
class Springs:
    """N springs: at a size s each has the energy rest + (s - length)^2 / give."""

    length: Floats
    """[N] size of least energy, metres."""
    give: Floats
    """[N] > 0, square metres per unit of energy."""
    rest: Floats
    """[N] energy at that size, >= 0: from different preferred sizes of parallel parts."""

    def energy(self, node: int, size: float) -> float:
        """Energy of a node at a size, metres."""
        return float(self.rest[node] + (size - self.length[node]) ** 2 / self.give[node])


def springs(
    facade: Facade, along: int, wanted: Floats, weight: Floats, held: Mapping[int, float] | None = None
) -> Springs:
    """Each node of a facade as a spring.

    Args:
        facade: the facade.
        along: 0 for widths, 1 for heights.
        wanted: [N] target sizes of leaves, metres.
        weight: [L] weights of leaves, as in `leaf_weights`.
        held: locked sizes of nodes, metres; their springs have hardly any give.
    """
    held = held or {}
    parent, axis = facade.parent.tolist(), facade.axis.tolist()
    length, give, rest = ([0.0] * len(facade) for _ in range(3))
    stiffness, pull, square = ([0.0] * len(facade) for _ in range(3))
    for leaf, size, least in zip(facade.leaves.tolist(), wanted[facade.leaves].tolist(), weight.tolist(), strict=True):
        length[leaf], give[leaf] = size, 1.0 / least**2
    for node in range(len(facade) - 1, -1, -1):
        if axis[node] not in {LEAF, along}:
            length[node], give[node] = pull[node] / stiffness[node], 1.0 / stiffness[node]
            rest[node] += max(square[node] - pull[node] * length[node], 0.0)
        if node in held:
            rest[node] += (held[node] - length[node]) ** 2 / give[node]
            length[node], give[node] = held[node], _STIFF * give[node]
        above = parent[node]
        if node == 0:
            break
        rest[above] += rest[node]
        if axis[above] == along:
            length[above] += length[node]
            give[above] += give[node]
        else:
            stiffness[above] += 1.0 / give[node]
            pull[above] += length[node] / give[node]
            square[above] += length[node] ** 2 / give[node]
    return Springs(np.array(length), np.array(give), np.array(rest))
