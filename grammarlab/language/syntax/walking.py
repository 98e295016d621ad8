"""Iteration over the nodes of a syntax tree, in the order of the text."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import fields
from functools import cache
from typing import Any

from grammarlab.language.syntax.tree import Node, Numbered, RuleFile


def children(node: Node) -> list[Node]:
    """Children of a node, in the order of its fields."""
    found: list[Node] = []
    for name in _field_names(type(node)):
        _gather(getattr(node, name), found)
    return found


def walk(node: Node) -> Iterator[Node]:
    """The node and all nodes below it, in preorder."""
    waiting = [node]
    while waiting:
        current = waiting.pop()
        yield current
        waiting += reversed(children(current))


def number(tree: RuleFile) -> None:
    """Assign numbers (`Numbered.number`) to the nodes of a new tree, in the order of the text.

    So reformatting a grammar or renaming a rule changes no draw.
    """
    for place, node in enumerate(node for node in walk(tree) if isinstance(node, Numbered)):
        object.__setattr__(node, "number", place)  # safe to mutate: the tree is new and not shared yet


@cache
def _field_names(kind: type[Any]) -> tuple[str, ...]:
    return tuple(field.name for field in fields(kind) if field.name not in ("location", "number"))


def _gather(value: object, found: list[Node]) -> None:
    if isinstance(value, Node):
        found.append(value)
    elif isinstance(value, tuple):
        for item in value:
            _gather(item, found)
