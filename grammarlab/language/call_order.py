"""The order in which things that refer to each other can be dealt with."""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Iterator, Mapping
from typing import TypeVar

_K = TypeVar("_K", bound=Hashable)


def groups(calls: Mapping[_K, Iterable[_K]]) -> list[tuple[_K, ...]]:
    """The strongly connected groups of a graph, each after all that it leads to (Tarjan 1972, without recursion).

    Args:
        calls: for each thing those that it refers to, all of them keys too; their order decides between groups that
            could stand in either.

    >>> groups({"a": "bc", "b": "a", "c": ""})
    [('c',), ('a', 'b')]
    """
    place = {key: i for i, key in enumerate(calls)}
    index: dict[_K, int] = {}
    low: dict[_K, int] = {}
    waiting: dict[_K, None] = {}
    """The keys visited whose group is not complete yet, in the order of the visits."""
    found: list[tuple[_K, ...]] = []

    def visit(key: _K) -> tuple[_K, Iterator[_K]]:
        index[key] = low[key] = len(index)
        waiting[key] = None
        return key, iter(calls[key])

    for root in calls:
        work = [] if root in index else [visit(root)]
        while work:
            key, rest = work[-1]
            for callee in rest:
                if callee not in index:
                    work.append(visit(callee))
                    break
                if callee in waiting:
                    low[key] = min(low[key], index[callee])
            else:
                work.pop()
                if work:
                    above = work[-1][0]
                    low[above] = min(low[above], low[key])
                if low[key] == index[key]:
                    group = []
                    while not group or group[-1] != key:
                        group.append(waiting.popitem()[0])
                    found.append(tuple(sorted(group, key=place.__getitem__)))
    return found
