"""Many small forests as few large ones, for counting: labelled models are often derived one by one."""

from __future__ import annotations

from collections.abc import Sequence

from grammarlab.derivation.forest import Forest
from grammarlab.derivation.selection import join_forests
from grammarlab.features.stripping import without_geometry

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
    return tuple(join_forests([without_geometry(f) for f in group]) if len(group) > 1 else group[0] for group in groups)


def _speaks_alike(one: Forest, other: Forest) -> bool:
    return (one.symbols, one.rules, one.sites) == (other.symbols, other.rules, other.sites)
