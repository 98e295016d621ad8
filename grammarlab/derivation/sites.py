"""Names of the random expressions of a grammar."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

from grammarlab.derivation.forest import Site, SiteKind
from grammarlab.language.grammar import Grammar
from grammarlab.language.numbering import Place, function_name
from grammarlab.language.syntax.tree import Call, Numbered, Stochastic, alternatives

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


def describe_sites(grammar: Grammar, places: Sequence[Place]) -> tuple[Site, ...]:
    """Sites of a forest, with names as described by `Site.name`.

    Args:
        grammar: the grammar.
        places: its random places.
    """
    names = _values_of_attributes(grammar, places)
    per_definition = Counter(place.owner for place in places if place.node.number not in names)
    taken = set(names.values())
    numbers: Counter[str] = Counter()
    sites: list[Site] = []
    for place in places:
        node, owner = place.node, place.owner
        name = names.get(node.number)
        if name is None:
            numbers[owner] += 1
            plain = per_definition[owner] == 1 and owner not in taken | grammar.attributes.keys()
            name = owner if plain else f"{owner}#{numbers[owner]}"
        choices = len(node.branches) if isinstance(node, Stochastic) else 0
        kind = "choice" if isinstance(node, Stochastic) else _KINDS[function_name(node)]
        sites.append(Site(name, kind, owner, node.location.line, choices))
    return tuple(sites)


def _values_of_attributes(grammar: Grammar, places: Sequence[Place]) -> dict[int, str]:
    """Names of attributes, by the number of the random expression whose draw is the attribute's value."""
    by_owner: dict[str, list[Place]] = {}
    for place in places:
        by_owner.setdefault(place.owner, []).append(place)
    found: dict[int, str] = {}
    for name, attribute in grammar.attributes.items():
        inside = [place.node for place in by_owner.get(name, ()) if place.definition is attribute]
        uniform = {node.number for node in inside if function_name(node) == "rand"}
        leaves = [leaf.number if isinstance(leaf, Numbered) else -1 for leaf in alternatives(attribute.value)]
        if uniform.issuperset(leaves):
            found |= dict.fromkeys(leaves, name)
        elif inside and inside[0] is attribute.value and (len(inside) == 1 or isinstance(attribute.value, Call)):
            found[inside[0].number] = name
    return found
