"""Topological order of definitions that refer to each other."""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Iterator, Mapping
from typing import TypeVar

_K = TypeVar("_K", bound=Hashable)


def groups(calls: Mapping[_K, Iterable[_K]]) -> list[tuple[_K, ...]]:
    """Strongly connected components of a graph, each after all its successors (Tarjan 1972, without recursion).

    Args:
        calls: successors of each node; every successor is a key. Their order decides between components that have no
            order.

    >>> groups({"a": "bc", "b": "a", "c": ""})
    [('c',), ('a', 'b')]
    """
    key_index = {key: i for i, key in enumerate(calls)}
    index: dict[_K, int] = {}
    low: dict[_K, int] = {}
    stack: dict[_K, None] = {}
    """Visited keys whose component is not complete yet, in the order of the visits."""
    components: list[tuple[_K, ...]] = []

    def visit(key: _K) -> tuple[_K, Iterator[_K]]:
        index[key] = low[key] = len(index)
        stack[key] = None
        return key, iter(calls[key])

    for root in calls:
        work = [] if root in index else [visit(root)]
        while work:
            key, rest = work[-1]
            for callee in rest:
                if callee not in index:
                    work.append(visit(callee))
                    break
                if callee in stack:
                    low[key] = min(low[key], index[callee])
            else:
                work.pop()
                if work:
                    above = work[-1][0]
                    low[above] = min(low[above], low[key])
                if low[key] == index[key]:
                    group = []
                    while not group or group[-1] != key:
                        group.append(stack.popitem()[0])
                    components.append(tuple(sorted(group, key=key_index.__getitem__)))
    return components
