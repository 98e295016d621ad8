"""Pins of parcels that a city does not have, and the ids that may be meant."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Sequence
from difflib import get_close_matches
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from grammarlab.city.parcel_addresses import Pins
from grammarlab.errors import shown
from grammarlab.geometry.footprints.footprint import Remark

_MOST_NAMES = 20
"""Ids that a remark names."""
_MOST_NEAREST = 3
"""Nearest ids that are named for one that is unknown."""
_LEAST_LIKENESS = 0.6
"""Share of the letters that a near id has in common with an unknown one."""
_NEIGHBOURS = 64
"""Ids before and behind an unknown one in an order that are compared with it."""


def unknown_pins(pins: Pins, ids: NDArray[np.object_], path: Path) -> list[Remark]:
    """A remark that names the pins without a parcel, if there are any.

    Args:
        pins: pins of these and of other parcels.
        ids: [N] different ids of the parcels of the city.
        path: file of the pins.
    """
    known = frozenset(ids.tolist()) if len(pins) else frozenset()
    unknown = [pin.id for pin in pins.rows if pin.id not in known]
    if not unknown:
        return []
    named = unknown[:_MOST_NAMES]
    texts = [_with_nearest(name, near) for name, near in zip(named, nearest_ids(named, ids.tolist()), strict=True)]
    if len(unknown) > len(named):
        texts.append(f"and {len(unknown) - len(named):,} more")
    share = f"{len(unknown):,} of {len(pins):,} pins change nothing, as no parcel of the city has their ids"
    return [Remark(str(path), "identity", f"{share}: {', '.join(texts)}")]


def nearest_ids(names: Sequence[str], ids: Sequence[str]) -> list[list[str]]:
    """The ids most like each of some names, the most alike first; none if no id is like it.

    Compared are the neighbours of a name in the order of the ids, read forwards and backwards: they begin or end as it
    does. So a wrong letter, a lost zero in front and a lost part number are found among a million ids.

    >>> nearest_ids(["7", "ab-12"], ["007", "AB-12", "AB-21", "x"])
    [[], ['AB-12', 'AB-21']]
    """
    folded = [text.casefold() for text in ids]
    forwards = sorted(zip(folded, ids, strict=True))
    backwards = sorted(zip((text[::-1] for text in folded), ids, strict=True))
    found: list[list[str]] = []
    for name in names:
        word = name.casefold()
        near = {*_neighbours(forwards, word), *_neighbours(backwards, word[::-1])}
        by_word = {text.casefold(): text for text in sorted(near)}
        found.append([by_word[one] for one in get_close_matches(word, by_word, _MOST_NEAREST, _LEAST_LIKENESS)])
    return found


def _neighbours(order: Sequence[tuple[str, str]], word: str) -> list[str]:
    """The ids on both sides of a word."""
    place = bisect_left(order, (word,))
    return [text for _, text in order[max(place - _NEIGHBOURS, 0) : place + _NEIGHBOURS]]


def _with_nearest(name: str, near: Sequence[str]) -> str:
    return f"{shown(name)} (near are {', '.join(map(shown, near))})" if near else shown(name)
