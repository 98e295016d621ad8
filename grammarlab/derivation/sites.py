"""What the random expressions of a grammar are called."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

from grammarlab.derivation.forest import Site, SiteKind
from grammarlab.language.grammar import Grammar
from grammarlab.language.syntax import Call, Import, Name, Node, Stochastic, alternatives
from grammarlab.language.walking import walk

_KINDS: dict[str, SiteKind] = {
    "assetApproxRatio": "item",
    "assetApproxSize": "item",
    "assetFitSize": "item",
    "fileRandom": "file",
    "imageApproxRatio": "item",
    "listRandom": "item",
    "p": "bernoulli",
    "rand": "uniform",
}


def function_name(node: Node) -> str:
    """The function that a node calls, with parentheses or without; empty for other nodes."""
    return node.function if isinstance(node, Call) else node.identifier if isinstance(node, Name) else ""


def describe_sites(grammar: Grammar, nodes: Sequence[Node]) -> tuple[Site, ...]:
    """The sites of a forest, named as `Site.name` says.

    Args:
        grammar: the grammar.
        nodes: its random expressions.
    """
    definitions = _definitions(grammar, nodes)
    names = _values_of_attributes(grammar, nodes)
    per_definition = Counter(definitions[id(node)] for node in nodes if id(node) not in names)
    taken = set(names.values())
    numbers: Counter[str] = Counter()
    sites: list[Site] = []
    for node in nodes:
        definition = definitions[id(node)]
        name = names.get(id(node))
        if name is None:
            numbers[definition] += 1
            plain = per_definition[definition] == 1 and definition not in taken | grammar.attributes.keys()
            name = definition if plain else f"{definition}#{numbers[definition]}"
        choices = len(node.branches) if isinstance(node, Stochastic) else 0
        kind = "choice" if isinstance(node, Stochastic) else _KINDS[function_name(node)]
        sites.append(Site(name, kind, definition, node.location.line, choices))
    return tuple(sites)


def _definitions(grammar: Grammar, nodes: Sequence[Node]) -> dict[int, str]:
    """For each random expression, by its ``id()``, the name of the definition that it stands in."""
    wanted = {id(node) for node in nodes}
    found: dict[int, str] = {}
    for definition in grammar.tree.definitions:
        name = definition.alias if isinstance(definition, Import) else definition.name
        found |= {id(node): name for node in walk(definition) if id(node) in wanted}
    return found


def _values_of_attributes(grammar: Grammar, nodes: Sequence[Node]) -> dict[int, str]:
    """By ``id()``, the random expressions whose draw is the value of an attribute, and the attribute's name."""
    random = {id(node) for node in nodes}
    found: dict[int, str] = {}
    for attribute in grammar.attributes.values():
        leaves = list(alternatives(attribute.value))
        inside = [node for node in walk(attribute.value) if id(node) in random]
        if all(id(leaf) in random and function_name(leaf) == "rand" for leaf in leaves):
            found |= {id(leaf): attribute.name for leaf in leaves}
        elif inside and inside[0] is attribute.value and (len(inside) == 1 or isinstance(attribute.value, Call)):
            found[id(attribute.value)] = attribute.name
    return found
