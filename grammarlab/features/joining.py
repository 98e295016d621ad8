"""Many small forests as few large ones, for counting: labelled models are often derived one by one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import fields, replace

import numpy as np

from grammarlab.derivation.forest import Forest, Leaves, Reports
from grammarlab.derivation.materials import Materials
from grammarlab.derivation.selection import join_forests

NODES_TOGETHER = 200_000
"""Forests are joined up to about so many nodes; larger ones gain nothing."""


def join_small(forests: Forest | Sequence[Forest]) -> tuple[Forest, ...]:
    """The same models in the same order in fewer forests. Joined ones have nodes and draws only."""
    if isinstance(forests, Forest):
        return (forests,)
    groups: list[list[Forest]] = []
    size = 0
    for forest in forests:
        size += len(forest.nodes)
        if groups and size <= NODES_TOGETHER and _speaks_alike(groups[-1][0], forest):
            groups[-1].append(forest)
        else:
            groups.append([forest])
            size = len(forest.nodes)
    return tuple(join_forests([_trees_of(f) for f in group]) if len(group) > 1 else group[0] for group in groups)


def _speaks_alike(one: Forest, other: Forest) -> bool:
    return (one.symbols, one.rules, one.sites) == (other.symbols, other.rules, other.sites)


def _trees_of(forest: Forest) -> Forest:
    """The forest without what no feature looks at."""
    return replace(
        forest,
        leaves=Leaves(*(getattr(forest.leaves, field.name)[:0] for field in fields(Leaves))),
        reports=Reports(*(getattr(forest.reports, field.name)[:0] for field in fields(Reports))),
        frames=forest.frames[:0],
        meshes=forest.meshes.take(np.zeros(0, np.int64)),
        materials=Materials(forest.materials.channels[:0], ()),
        texture_maps=forest.texture_maps[:0],
    )
