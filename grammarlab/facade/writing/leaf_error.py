"""Differences of derived leaves and those of a facade."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from scipy.spatial import KDTree

from grammarlab.derivation import derive
from grammarlab.facade.tree import Facade, Floats
from grammarlab.facade.writing.outlines import OutlinedLeaf, store_shapes
from grammarlab.facade.writing.rule_text import AROUND
from grammarlab.language.grammar import Grammar


def leaf_error(
    facade: Facade, grammar: Grammar, labels: Mapping[str, str], outlined: Collection[OutlinedLeaf] = ()
) -> float:
    """Largest difference of the sides of leaves, metres, in the first model of a grammar.

    Args:
        facade: the expected leaves.
        grammar: a grammar of boxes whose front is in the x-y plane.
        labels: labels of the symbols of derived leaves.
        outlined: leaves whose meshes the grammar refers to.

    Returns:
        Infinity if leaves are missing, surplus, or of other labels.
    """
    found, called = derived_leaves(grammar, labels, outlined)
    if len(found) != len(facade.leaves):
        return np.inf
    expected = leaf_boxes(facade)
    nearest = np.asarray(KDTree(found).query(expected)[1])
    if len(np.unique(nearest)) != len(nearest):
        return np.inf
    if any(called[near] != facade.name_of(leaf) for near, leaf in zip(nearest, facade.leaves.tolist(), strict=True)):
        return np.inf
    return float(np.abs(corners(found)[nearest] - corners(expected)).max())


def derived_leaves(
    grammar: Grammar, labels: Mapping[str, str], outlined: Collection[OutlinedLeaf] = ()
) -> tuple[Floats, list[str]]:
    """[D, 4] left, bottom, width and height of the leaves of the first model, and their labels; none of `AROUND`."""
    if outlined:
        with TemporaryDirectory() as folder:
            store_shapes(outlined, Path(folder))
            forest = derive(grammar, 1, seed=0, assets=Path(folder))
    else:
        forest = derive(grammar, 1, seed=0)
    leaves = forest.leaves
    # The name of a symbol without a rule ends with a full stop.
    symbols = [forest.symbols[symbol].rstrip(".") for symbol in forest.nodes.symbol[leaves.node].tolist()]
    own = np.array([symbol != AROUND for symbol in symbols], dtype=bool)
    box = np.concatenate([leaves.position[:, :2], leaves.size[:, :2]], axis=1)
    return box[own], [labels.get(symbol, "") for symbol in symbols if symbol != AROUND]


def leaf_boxes(facade: Facade) -> Floats:
    """[L, 4] left, bottom, width and height of the leaves of a facade."""
    return np.concatenate([facade.position - facade.position[0], facade.size], axis=1)[facade.leaves]


def corners(boxes: Floats) -> Floats:
    """[K, 4] left, bottom, right and top of boxes."""
    return np.concatenate([boxes[:, :2], boxes[:, :2] + boxes[:, 2:]], axis=1)
