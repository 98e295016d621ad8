"""The order in which things that refer to each other can be computed."""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Mapping
from graphlib import TopologicalSorter
from typing import TypeVar

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components

_K = TypeVar("_K", bound=Hashable)


def groups(calls: Mapping[_K, Iterable[_K]]) -> list[tuple[_K, ...]]:
    """The strongly connected groups of a graph, each after all that it leads to.

    >>> groups({"a": "bc", "b": "a", "c": ""})
    [('c',), ('a', 'b')]
    """
    number = {key: i for i, key in enumerate(calls)}
    edges = np.array([(number[key], number[callee]) for key in calls for callee in calls[key]], dtype=np.int64)
    tails, heads = edges.reshape(-1, 2).T
    size = (len(number), len(number))
    _, label = connected_components(csr_array((np.ones(len(tails)), (tails, heads)), size), connection="strong")
    leads_to: dict[int, set[int]] = {group: set() for group in label.tolist()}
    for tail, head in zip(label[tails].tolist(), label[heads].tolist(), strict=True):
        if tail != head:
            leads_to[tail].add(head)
    members: dict[int, list[_K]] = {group: [] for group in leads_to}
    for key, group in zip(calls, label.tolist(), strict=True):
        members[group].append(key)
    return [tuple(members[group]) for group in TopologicalSorter(leads_to).static_order()]
