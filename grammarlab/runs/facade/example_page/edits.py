"""Corrections of an example on the document of its file, one step at a time; every function returns a new document."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from grammarlab.errors import UsageError
from grammarlab.facade.examples.analysis.example import MOST_LINES

Document = dict[str, Any]
"""Document of `grammarlab.facade.examples.analysis.correction`."""
Wall = dict[str, Any]


def relabelled(document: Document, wall: str, cells: tuple[int, int, int, int], name: str) -> Document:
    """The document with another label for units in a rectangle of cells.

    Args:
        document: the document.
        wall: name of the wall.
        cells: first row, first column, last row and last column, from 0 at the lower left.
        name: the label, which may be new.
    """

    def change(found: Wall) -> Wall:
        labels = np.array(found["labels"], dtype=object)
        first, last = sorted(cells[0::2]), sorted(cells[1::2])
        if first[1] >= labels.shape[0] or last[1] >= labels.shape[1]:
            raise UsageError(f"{wall}: expected cells of {labels.shape[0]} rows and {labels.shape[1]} columns.")
        labels[first[0] : first[1] + 1, last[0] : last[1] + 1] = _checked(name)
        return {**found, "labels": labels.tolist()}

    return _changed(document, wall, change)


def merged(document: Document, wall: str, name: str, into: str) -> Document:
    """The document with all units of one label relabelled."""

    def change(found: Wall) -> Wall:
        if not any(name in row for row in found["labels"]):
            raise UsageError(f"{wall}: unknown label {name!r}.")
        label = _checked(into)
        return {**found, "labels": [[label if each == name else each for each in row] for row in found["labels"]]}

    return _changed(document, wall, change)


def moved(document: Document, wall: str, axis: str, index: int, at: float) -> Document:
    """The document with a line between units, or a border, moved to a coordinate, metres, between its neighbours."""

    def change(found: Wall) -> Wall:
        lines = list(found[_lines(axis)])
        lines[_known(index, len(lines))] = at
        return {**found, _lines(axis): lines}

    return _changed(document, wall, change)


def split(document: Document, wall: str, axis: str, at: float) -> Document:
    """The document with one more line: both parts of the divided row or column keep their labels."""

    def change(found: Wall) -> Wall:
        lines, labels = list(found[_lines(axis)]), np.array(found["labels"], dtype=object)
        place = int(np.searchsorted(lines, at)) - 1
        if not 0 <= place < len(lines) - 1:
            raise UsageError(f"{wall}: expected a position between {lines[0]:g} and {lines[-1]:g} m.")
        if len(lines) > MOST_LINES:
            raise UsageError(f"{wall}: at most {MOST_LINES} {axis} are possible.")
        lines.insert(place + 1, at)
        parts = np.insert(labels, place, np.take(labels, place, axis=_axis(axis)), axis=_axis(axis))
        return {**found, _lines(axis): lines, "labels": parts.tolist()}

    return _changed(document, wall, change)


def joined(document: Document, wall: str, axis: str, index: int) -> Document:
    """The document with one line less: adjacent rows, or columns, are merged with the labels of the first one."""

    def change(found: Wall) -> Wall:
        lines, labels = list(found[_lines(axis)]), np.array(found["labels"], dtype=object)
        place = _known(index, len(lines))
        if len(lines) < 3:
            raise UsageError(f"{wall}: only one of its {axis} is left; exclude the wall instead.")
        del lines[place]
        gone = min(place, labels.shape[_axis(axis)] - 1)
        return {**found, _lines(axis): lines, "labels": np.delete(labels, gone, axis=_axis(axis)).tolist()}

    return _changed(document, wall, change)


def excluded(document: Document, wall: str) -> Document:
    """The document without a wall: it is stretched with the rest."""
    _changed(document, wall, lambda found: found)
    return {**document, "walls": [each for each in document["walls"] if each["name"] != wall]}


def included(document: Document, first: Document, wall: str) -> Document:
    """The document with an excluded wall restored from the analysis."""
    kept = {each["name"]: each for each in document["walls"]}
    walls = [kept.get(each["name"], each) for each in first["walls"] if each["name"] in {*kept, wall}]
    if len(walls) == len(kept):
        raise UsageError(f"unknown excluded wall {wall!r}.")
    return {**document, "walls": walls}


def _changed(document: Document, wall: str, change: Callable[[Wall], Wall]) -> Document:
    names = [each["name"] for each in document["walls"]]
    if wall not in names:
        raise UsageError(f"unknown wall {wall!r}; expected one of {', '.join(names)}.")
    return {**document, "walls": [change(each) if each["name"] == wall else each for each in document["walls"]]}


def _lines(axis: str) -> str:
    if axis not in {"rows", "columns"}:
        raise UsageError(f"axis: expected rows or columns, found {axis!r:.40}.")
    return axis


def _axis(axis: str) -> int:
    return 0 if _lines(axis) == "rows" else 1


def _known(index: int, count: int) -> int:
    if not 0 <= index < count:
        raise UsageError(f"line: expected 0 to {count - 1}, found {index}.")
    return index


def _checked(name: str) -> str:
    if not name.strip():
        raise UsageError("label: expected a name.")
    return name.strip()
