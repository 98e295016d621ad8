"""Types of CGA, and contexts of expressions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

Types = frozenset[str]
"""Types that a value may have."""

ANY: Types = frozenset({"float", "bool", "string", "float[]", "bool[]", "string[]"})
ARRAYS: Types = frozenset({"float[]", "bool[]", "string[]"})
FLOAT: Types = frozenset({"float"})
BOOL: Types = frozenset({"bool"})
STRING: Types = frozenset({"string"})
_NAMES = {"size": FLOAT, "tile": FLOAT, "any": ANY, "place": ANY}


@dataclass(frozen=True, slots=True)
class Scope:
    """Context of an expression."""

    locals: frozenset[str] = frozenset()
    """Parameters and local variables."""
    selectors: frozenset[str] = frozenset()
    """Words that select components in this context."""
    relative: bool = False
    """Whether ``'`` is allowed."""
    floating: bool = False
    """Whether ``~`` is allowed."""

    def plain(self) -> Scope:
        """The same context, inside an argument."""
        return replace(self, selectors=frozenset(), relative=False, floating=False)


def types_of(names: Sequence[str]) -> Types:
    """Types from the names in a signature."""
    return frozenset[str]().union(*(_NAMES.get(name, frozenset({name})) for name in names))


def in_words(types: Types) -> str:
    """Types in the words of messages."""
    words = {"float": "a number", "bool": "a boolean", "string": "a string"}
    words |= {f"{kind}[]": f"an array of {kind}s" for kind in ("float", "bool", "string")}
    return "anything" if types == ANY else " or ".join(words[kind] for kind in sorted(types)) or "nothing"


def advice(wanted: Types, found: Types) -> str:
    """Hint for a conversion from the found type to the expected type; empty if there is none."""
    if wanted == STRING:
        return "str(…) converts to a string"
    if wanted == FLOAT and found == STRING:
        return "float(…) converts a string to a number"
    return ""
