"""Places in the rule text that made the shapes of a forest."""

from __future__ import annotations

from dataclasses import dataclass

from grammarlab.derivation.forest import Forest
from grammarlab.errors import Location
from grammarlab.language.numbering import Numbering


@dataclass(frozen=True, slots=True)
class RuleOrigin:
    """Origin of a node in the rule text."""

    symbol: str
    made_at: Location | None
    """The successor that made it; None for the initial shape."""
    rule_at: Location | None
    """The branch of the rule that rewrote it; None for a leaf."""


def origin_of(forest: Forest, numbering: Numbering, node: int) -> RuleOrigin:
    """Origin of a node of a forest in the rule text.

    Args:
        forest: models of a grammar.
        numbering: numbering of the grammar.
        node: row of the node.
    """
    nodes = forest.nodes
    rule, parent = int(nodes.rule[node]), int(nodes.parent[node])
    made_at = None
    if parent >= 0:
        made_at = numbering.branches[nodes.rule[parent]].successors[nodes.child[node]].location
    return RuleOrigin(
        forest.symbols[nodes.symbol[node]], made_at, numbering.branches[rule].location if rule >= 0 else None
    )


def way_to(forest: Forest, node: int) -> list[int]:
    """Nodes on the path from the root to a node, both included."""
    way = [node]
    while (parent := int(forest.nodes.parent[way[-1]])) >= 0:
        way.append(parent)
    return way[::-1]
