"""Roles: the same choice under different symbols, such as the roof of an office and the roof of a house.

Two symbols have one role if at least two of their alternatives have the same name without the symbol's own words and
those that all of its alternatives have: OfficeFlat and OfficeGable of OfficeRoof are HouseFlat and HouseGable of
HouseRoof. A word of the symbol that is all that one of its alternatives has is kept: RoofOffice and RoofHouse of
RoofOfOffice. Symbols without such a partner are comparable if they have the same branches, alternative by alternative.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from grammarlab.arrays import MOST_COLUMNS, NUM_LEVELS, Ints, connected
from grammarlab.tastes.labelled_nodes import LabelledNodes

_MIN_AGREEING = 2
"""Smallest number of alternatives with the same name of symbols of one role."""
_WORDS = re.compile(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+|\d+|[^\W\d_]+")


@dataclass(frozen=True)
class Roles:
    """Kinds of choices; choices of one kind are comparable."""

    kind: Ints
    """[unknown + 1] kind of the choice of each label; -1 for none."""
    number: Ints
    """[unknown + 1] number of the alternative among those of its kind, from 1; 0 for none."""
    shared: tuple[int, ...]
    """Kinds of several symbols with the same names of alternatives."""

    @classmethod
    def of(cls, nodes: LabelledNodes) -> Roles:
        """The kinds of all choices of few alternatives."""
        members = _choices(nodes)
        names = {symbol: _names(nodes, symbol, labels) for symbol, labels in members.items()}
        group = _groups(names)
        kinds: dict[object, int] = {}
        kind, number = np.full(nodes.labels.unknown + 1, -1), np.zeros(nodes.labels.unknown + 1, dtype=np.int64)
        numbers: dict[int, dict[object, int]] = {}
        for symbol, labels in members.items():
            branches = [nodes.labels.rules[label].branch for label in labels]
            is_shared = symbol in group
            key = ("role", group[symbol]) if is_shared else ("branches", tuple(branches))
            index = kinds.setdefault(key, len(kinds))
            of_kind = numbers.setdefault(index, {})
            for label, name in zip(labels, names[symbol] if is_shared else branches, strict=True):
                kind[label], number[label] = index, of_kind.setdefault(name, len(of_kind) + 1)
        shared = tuple(index for key, index in kinds.items() if isinstance(key, tuple) and key[0] == "role")
        return cls(kind, number, shared)


def _choices(nodes: LabelledNodes) -> dict[str, list[int]]:
    """Labels of the alternatives of each choice, by branch."""
    members: dict[str, list[int]] = {}
    for label in nodes.alternatives:
        members.setdefault(nodes.labels.symbol_of(label), []).append(label)
    return {
        symbol: sorted(labels, key=lambda label: nodes.labels.rules[label].branch)
        for symbol, labels in members.items()
        if len(labels) <= NUM_LEVELS and not nodes.labels.is_overloaded(symbol)
    }


def _names(nodes: LabelledNodes, symbol: str, labels: Sequence[int]) -> list[str]:
    """Names of alternatives without the words of their symbol and those that all have; empty if some have none.

    An alternative that no model has is known by its line only, and is like no other.
    """
    names = [nodes.names.branch(label) for label in labels]
    listed = [[name] if _is_bare(name) else words_of(name) for name in names]
    named = [words for words, name in zip(listed, names, strict=True) if not _is_bare(name)]
    common = set(named[0]).intersection(*named) if len(named) > 1 else set[str]()
    own = set(words_of(symbol))
    for others in (common | own, own, common):
        shortened = [" ".join(word for word in words if word not in others) for words in listed]
        if all(shortened) and len(set(shortened)) == len(labels):
            return [
                f"{symbol} {short}" if _is_bare(name) else short for short, name in zip(shortened, names, strict=True)
            ]
    return []


def words_of(name: str) -> list[str]:
    """Words of a name; singular and plural are one."""
    return [word.lower().removesuffix("s") or word for word in _WORDS.findall(name)]


def _is_bare(name: str) -> bool:
    """Whether a branch has no name of its own."""
    return "%" in name or name.startswith("line ")


def _groups(names: Mapping[str, Sequence[str]]) -> dict[str, int]:
    """A number for each group of symbols that have one role; nothing for symbols alone."""
    symbols = [symbol for symbol, listed in names.items() if listed][:MOST_COLUMNS]
    pairs = [
        (i, j)
        for i, first in enumerate(symbols)
        for j, second in enumerate(symbols[:i])
        if len(set(names[first]) & set(names[second])) >= _MIN_AGREEING
    ]
    if not pairs:
        return {}
    component = connected(len(symbols), *np.array(pairs, dtype=np.int64).T)
    size = np.bincount(component)
    return {s: number for s, number in zip(symbols, component.tolist(), strict=True) if size[number] > 1}
