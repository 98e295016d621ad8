"""The oracle's own numbering of the places of a grammar that draw."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import fields

from grammarlab.language.syntax.syntax_tree import Call, Name, Node, RuleFile, Stochastic


def number_sites(tree: RuleFile) -> dict[int, int]:
    """For each `Stochastic`, `Call` and `Name` node, by its ``id()``, its number in the order of the tree.

    Names of switches of trim planes have none.
    """
    places = [node for node in nodes_of(tree) if isinstance(node, Stochastic | Call | Name)]
    places = [node for node in places if not (isinstance(node, Name) and node.identifier.startswith("trim."))]
    return {id(node): number for number, node in enumerate(places)}


def nodes_of(item: object) -> Iterator[Node]:
    """A node and all below it, in the order of their fields."""
    if isinstance(item, Node):
        yield item
        for member in fields(item):
            yield from nodes_of(getattr(item, member.name))
    elif isinstance(item, tuple):
        for member in item:
            yield from nodes_of(member)
