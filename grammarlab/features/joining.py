"""Many small forests as few large ones, for counting: labelled models are often derived one by one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import fields, replace

import numpy as np

from grammarlab.derivation.forest import Draws, Forest, Nodes

NODES_TOGETHER = 200_000
"""Forests are joined up to about so many nodes; larger ones gain nothing."""


def join_small(forests: Forest | Sequence[Forest]) -> tuple[Forest, ...]:
    """The same models in the same order in fewer forests. Joined ones have nodes and draws only, and no addresses."""
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
    return tuple(_join(group) if len(group) > 1 else group[0] for group in groups)


def _speaks_alike(one: Forest, other: Forest) -> bool:
    return (one.symbols, one.rules, one.sites) == (other.symbols, other.rules, other.sites)


def _join(group: Sequence[Forest]) -> Forest:
    models = np.cumsum([0, *(forest.num_models for forest in group)])
    rows = np.cumsum([0, *(len(forest.nodes) for forest in group)])
    nodes = [
        replace(
            forest.nodes,
            model=forest.nodes.model + np.int32(models[i]),
            parent=np.where(forest.nodes.parent < 0, -1, forest.nodes.parent + rows[i]).astype(np.int32),
        )
        for i, forest in enumerate(group)
    ]
    draws = [replace(forest.draws, node=forest.draws.node + np.int32(rows[i])) for i, forest in enumerate(group)]
    leaves = replace(group[0].leaves, **{f.name: getattr(group[0].leaves, f.name)[:0] for f in fields(group[0].leaves)})
    return replace(
        group[0],
        num_models=int(models[-1]),
        nodes=Nodes(*(np.concatenate([getattr(n, f.name) for n in nodes]) for f in fields(Nodes))),
        draws=Draws(*(np.concatenate([getattr(d, f.name) for d in draws]) for f in fields(Draws))),
        leaves=leaves,
        reports=replace(group[0].reports, node=np.zeros(0, np.int32), key=np.zeros(0, np.int32), value=np.zeros(0)),
    )
