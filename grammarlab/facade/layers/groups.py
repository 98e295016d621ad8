"""Alignment groups: the words of layers that are aligned with each other."""

from __future__ import annotations

from collections.abc import Mapping

from grammarlab.facade.layers.letters import Word

Group = tuple[int, str]
"""An axis, 0 for x and 1 for y, and the name of an alignment group on it."""


def sharing_groups(words: Mapping[Group, tuple[Word, ...]]) -> dict[Group, int]:
    """For each group, the number of groups of several words that share symbols with it, directly or through others.

    Their size errors are one and the same, so that each group may count only its share.
    """
    parts: list[tuple[set[Group], set[str]]] = []
    for group, rows in words.items():
        groups, symbols = {group}, {letter.symbol for word in rows for letter in word if letter.size is not None}
        apart = []
        for part in parts:
            if part[1].isdisjoint(symbols):
                apart.append(part)
            else:
                groups, symbols = groups | part[0], symbols | part[1]
        parts = [*apart, (groups, symbols)]
    return {
        group: max(sum(len(set(words[other])) > 1 for other in groups), 1) for groups, _ in parts for group in groups
    }
