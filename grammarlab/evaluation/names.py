"""Objects from lists of names."""

from __future__ import annotations

from collections.abc import Mapping
from difflib import get_close_matches
from typing import TypeVar

from grammarlab.errors import UsageError

Named = TypeVar("Named")


def chosen(names: str, known: Mapping[str, Named], what: str) -> tuple[Named, ...]:
    """Objects from a comma-separated list, in its order.

    Args:
        names: ``default,paper``; each name once.
        known: all objects by name.
        what: noun for one of them, for messages: ``method``.

    Raises:
        UsageError: If a name is unknown, repeated or missing.
    """
    wanted = [name.strip() for name in names.split(",") if name.strip()]
    if not wanted:
        raise UsageError(f"which {what}s? Give names from: {', '.join(known)}; several with commas between.")
    for name in wanted:
        if name not in known:
            near = get_close_matches(name, known, n=1)
            hint = f" Did you mean {near[0]!r}?" if near else ""
            raise UsageError(f"unknown {what} {name!r}.{hint} Expected one of {', '.join(known)}.")
        if wanted.count(name) > 1:
            raise UsageError(f"{what} {name!r} is given twice.")
    return tuple(known[name] for name in wanted)


def chosen_one(name: str, known: Mapping[str, Named], what: str) -> Named:
    """Object from a single name; for the arguments see `chosen`.

    Raises:
        UsageError: If the name is unknown, or there are several names.
    """
    found = chosen(name, known, what)
    if len(found) != 1:
        raise UsageError(f"expected one {what}, found {len(found)} in {name!r}.")
    return found[0]
