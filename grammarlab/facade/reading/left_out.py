"""Notes on shapes of an annotation that are not read, or not whole."""

from __future__ import annotations

from collections import Counter


def left_out_notes(kinds: Counter[str]) -> list[str]:
    """One note on shapes that are left out, by their kind in the words of the file.

    >>> left_out_notes(Counter({"polyline": 2, "tag": 1}))
    ['3 annotations are left out, since they are not areas with a label: 2 polyline, 1 tag']
    """
    if not kinds:
        return []
    parts = ", ".join(f"{number} {kind}" for kind, number in sorted(kinds.items()))
    return [f"{kinds.total()} annotations are left out, since they are not areas with a label: {parts}"]


def box_only_notes(number: int) -> list[str]:
    """A note on masks and shapes of several polygons, of which only the box is read.

    >>> box_only_notes(2)
    ['2 masks or shapes of several polygons are read as their boxes']
    """
    return [f"{number} masks or shapes of several polygons are read as their boxes"] if number else []
