"""The types of CGA, and where an expression stands."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

Types = frozenset[str]
"""The types that a value may have."""

ANY: Types = frozenset({"float", "bool", "string", "float[]", "bool[]", "string[]"})
ARRAYS: Types = frozenset({"float[]", "bool[]", "string[]"})
FLOAT: Types = frozenset({"float"})
BOOL: Types = frozenset({"bool"})
STRING: Types = frozenset({"string"})
_NAMES = {"size": FLOAT, "tile": FLOAT, "any": ANY, "place": ANY}


@dataclass(frozen=True, slots=True)
class Scope:
    """Where an expression stands."""

    locals: frozenset[str] = frozenset()
    """Parameters and local variables."""
    selectors: frozenset[str] = frozenset()
    """Words that select components there."""
    relative: bool = False
    """Whether ``'`` has a meaning."""
    floating: bool = False
    """Whether ``~`` has a meaning."""

    def plain(self) -> Scope:
        """The same place, inside an argument."""
        return replace(self, selectors=frozenset(), relative=False, floating=False)


def types_of(names: Sequence[str]) -> Types:
    """The types that the names of a signature stand for."""
    return frozenset[str]().union(*(_NAMES.get(name, frozenset({name})) for name in names))


def in_words(types: Types) -> str:
    """Types as a message names them."""
    words = {"float": "a number", "bool": "a boolean", "string": "a string"}
    words |= {f"{kind}[]": f"an array of {kind}s" for kind in ("float", "bool", "string")}
    return "anything" if types == ANY else " or ".join(words[kind] for kind in sorted(types)) or "nothing"


def advice(wanted: Types, found: Types) -> str:
    """What makes a value of the wanted type of one of the found type; empty where nothing does."""
    if wanted == STRING:
        return "str(…) makes a string"
    if wanted == FLOAT and found == STRING:
        return "float(…) makes a number of a string"
    return ""
