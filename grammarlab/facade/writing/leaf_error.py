"""How far the leaves that rules derive are from those of a facade."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from scipy.spatial import KDTree

from grammarlab.derivation import derive
from grammarlab.facade.tree import Facade
from grammarlab.language.grammar import Grammar


def leaf_error(facade: Facade, grammar: Grammar, labels: Mapping[str, str]) -> float:
    """Metres by which a side of a leaf is missed at most, when the first model of a grammar is derived.

    Args:
        facade: the leaves that are expected.
        grammar: what derives them, as boxes whose front is in the x-y plane.
        labels: what the symbols of derived leaves stand for.

    Returns:
        Infinity where leaves are missing, too many, or of other labels.
    """
    forest = derive(grammar, 1, seed=0)
    leaves = forest.leaves
    if len(leaves) != len(facade.leaves):
        return np.inf
    found = np.concatenate([leaves.position[:, :2], leaves.size[:, :2]], axis=1)
    low = facade.position[facade.leaves] - facade.position[0]
    expected = np.concatenate([low, facade.size[facade.leaves]], axis=1)
    nearest = np.asarray(KDTree(found).query(expected)[1])
    if len(np.unique(nearest)) != len(nearest):
        return np.inf
    symbols = forest.nodes.symbol[leaves.node[nearest]].tolist()
    if any(
        labels.get(forest.symbols[symbol]) != facade.name_of(leaf)
        for symbol, leaf in zip(symbols, facade.leaves.tolist(), strict=True)
    ):
        return np.inf
    corners = [np.concatenate([boxes[:, :2], boxes[:, :2] + boxes[:, 2:]], axis=1) for boxes in (found, expected)]
    return float(np.abs(corners[0][nearest] - corners[1]).max())
