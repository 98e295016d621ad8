"""Numbers for the places in a rule file where chance or a call happens: the addresses of random draws.

They follow the text: reformatting a grammar or renaming a rule leaves every draw as it was.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import fields

from grammarlab.language.syntax import Call, Name, Node, RuleFile, Stochastic


def number_sites(tree: RuleFile) -> dict[int, int]:
    """For each `Stochastic`, `Call` and `Name` node, by its ``id()``, its number in the order of the text.

    Valid as long as the tree is alive.
    """
    return {id(node): number for number, node in enumerate(_sites(tree))}


def _sites(root: Node) -> Iterator[Node]:
    stack: list[object] = [root]
    while stack:
        item = stack.pop()
        if isinstance(item, tuple):
            stack.extend(reversed(item))
        elif isinstance(item, Node):
            if isinstance(item, Stochastic | Call | Name):
                yield item
            stack.extend(getattr(item, field.name) for field in reversed(fields(item)))
