"""State of a correction session: the analysis of an example, corrections that can be undone, file, and results.

Corrections change the document of the example's file, one step at a time; every function returns a new document.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from grammarlab.errors import UsageError
from grammarlab.files import rewrite_text, write_text
from grammarlab.pages.desk import AbstractDocumentDesk
from grammarlab.runs.facade.gallery import sheet
from grammarlab.synthesis.analysis.correction import corrected, dumps, with_corrections
from grammarlab.synthesis.analysis.example import MOST_LINES, Example, analyse
from grammarlab.synthesis.built import Built, build
from grammarlab.synthesis.example_pictures import building_picture, label_picture
from grammarlab.synthesis.label_synthesis import synthesize
from grammarlab.synthesis.mesh.building_files import read_mesh
from grammarlab.synthesis.mesh.surface import edge_numbers
from grammarlab.synthesis.units import stock_of

Wall = dict[str, Any]
Document = dict[str, Any]
"""Document of `grammarlab.synthesis.analysis.correction`."""


class ExampleDesk(AbstractDocumentDesk[Document]):
    """The corrections of an example."""

    def __init__(self, file: Path, target: Path, analysis: Example, saved: Document | None = None) -> None:
        """Start with the saved corrections, if any.

        Args:
            file: path of the mesh.
            target: file to save corrections to.
            analysis: the example from the analysis.
            saved: content of the target; None if it is unknown.
        """
        super().__init__(target, json.loads(dumps(analysis)), saved=saved)
        self.file, self.analysis = file, analysis
        self._label_names: dict[str, None] = {}

    @classmethod
    def open(cls, file: Path, target: Path) -> ExampleDesk:
        """A desk with the building of a file, and its saved corrections, if any.

        Raises:
            FacadeError: If the file cannot be read, or has no units, or the target belongs to another example.
        """
        analysis = analyse(read_mesh(file))
        saved = json.loads(dumps(corrected(analysis, target))) if target.exists() else None
        return cls(file, target, analysis, saved)

    def accept(self, document: Document) -> None:
        """Check that the example allows the corrections.

        Raises:
            FacadeError: If it does not, with the reason.
        """
        with_corrections(self.analysis, document)

    def follow(self, previous: Document) -> None:
        """No other state depends on the document."""

    def write(self, path: Path, document: Document, *, is_new: bool) -> None:
        """Write the corrections; a missing folder is made."""
        path.parent.mkdir(parents=True, exist_ok=True)
        (write_text if is_new else rewrite_text)(path, dumps(with_corrections(self.analysis, document)))

    @property
    def example(self) -> Example:
        """The corrected example."""
        return with_corrections(self.analysis, self.document)

    @cached_property
    def picture(self) -> Image.Image:
        """Picture of the building."""
        return building_picture(self.analysis.surface, self.analysis.mesh.colors)

    def label_names(self) -> list[str]:
        """All labels that have occurred so far, in order of first occurrence, so that their colors do not change."""
        for wall in self.document["walls"]:
            self._label_names |= dict.fromkeys(name for row in wall["labels"] for name in row)
        return list(self._label_names)

    def synthesized(self, rows: int, columns: int, seed: int) -> tuple[Built, Image.Image]:
        """A new building from the corrected example, and a picture: example, labels, new labels, new building."""
        example = replace(self.example, notes=())
        stock = stock_of([example])
        main = synthesize(stock.grids, rows, columns, seed=seed)[0]
        building = build(example, stock, main, None, (None, None, None), seed, edge_numbers(example.surface), {})
        pictures = [
            self.picture,
            label_picture(example.main.grid),
            label_picture(main.grid),
            building_picture(building.surface, stock.colors),
        ]
        return building, sheet(pictures)


def relabelled(document: Document, wall: str, cells: tuple[int, int, int, int], name: str) -> Document:
    """The document with another label for units in a rectangle of cells.

    Args:
        document: the document.
        wall: name of the wall.
        cells: first row, first column, last row and last column, from 0 at the lower left.
        name: the label, which may be new.
    """

    def change(target: Wall) -> Wall:
        labels = np.array(target["labels"], dtype=object)
        first, last = sorted(cells[0::2]), sorted(cells[1::2])
        if first[1] >= labels.shape[0] or last[1] >= labels.shape[1]:
            raise UsageError(f"{wall}: expected cells of {labels.shape[0]} rows and {labels.shape[1]} columns.")
        labels[first[0] : first[1] + 1, last[0] : last[1] + 1] = _checked(name)
        return {**target, "labels": labels.tolist()}

    return _changed(document, wall, change)


def merged(document: Document, wall: str, name: str, into: str) -> Document:
    """The document with all units of one label relabelled."""

    def change(target: Wall) -> Wall:
        if not any(name in row for row in target["labels"]):
            raise UsageError(f"{wall}: unknown label {name!r}.")
        label = _checked(into)
        return {**target, "labels": [[label if cell == name else cell for cell in row] for row in target["labels"]]}

    return _changed(document, wall, change)


def moved(document: Document, wall: str, axis: str, index: int, position: float) -> Document:
    """The document with a line between units, or a border, moved to a coordinate, metres, between its neighbours."""

    def change(target: Wall) -> Wall:
        lines = list(target[_lines(axis)])
        _check_index(index, len(lines))
        lines[index] = position
        return {**target, _lines(axis): lines}

    return _changed(document, wall, change)


def split(document: Document, wall: str, axis: str, position: float) -> Document:
    """The document with one more line: both parts of the divided row or column keep their labels."""

    def change(target: Wall) -> Wall:
        lines, labels = list(target[_lines(axis)]), np.array(target["labels"], dtype=object)
        index = int(np.searchsorted(lines, position)) - 1
        if not 0 <= index < len(lines) - 1:
            raise UsageError(f"{wall}: expected a position between {lines[0]:g} and {lines[-1]:g} m.")
        if len(lines) > MOST_LINES:
            raise UsageError(f"{wall}: at most {MOST_LINES} {axis} are possible.")
        lines.insert(index + 1, position)
        parts = np.insert(labels, index, np.take(labels, index, axis=_axis(axis)), axis=_axis(axis))
        return {**target, _lines(axis): lines, "labels": parts.tolist()}

    return _changed(document, wall, change)


def joined(document: Document, wall: str, axis: str, index: int) -> Document:
    """The document with one line less: adjacent rows, or columns, are merged with the labels of the first one."""

    def change(target: Wall) -> Wall:
        lines, labels = list(target[_lines(axis)]), np.array(target["labels"], dtype=object)
        _check_index(index, len(lines))
        if len(lines) < 3:
            raise UsageError(f"{wall}: only one of its {axis} is left; exclude the wall instead.")
        del lines[index]
        removed = min(index, labels.shape[_axis(axis)] - 1)
        return {**target, _lines(axis): lines, "labels": np.delete(labels, removed, axis=_axis(axis)).tolist()}

    return _changed(document, wall, change)


def excluded(document: Document, wall: str) -> Document:
    """The document without a wall: it is stretched with the rest."""
    _changed(document, wall, lambda target: target)
    return {**document, "walls": [item for item in document["walls"] if item["name"] != wall]}


def included(document: Document, first: Document, wall: str) -> Document:
    """The document with an excluded wall restored from the analysis."""
    present = {item["name"]: item for item in document["walls"]}
    walls = [present.get(item["name"], item) for item in first["walls"] if item["name"] in {*present, wall}]
    if len(walls) == len(present):
        raise UsageError(f"unknown excluded wall {wall!r}.")
    return {**document, "walls": walls}


def _checked(name: str) -> str:
    if not name.strip():
        raise UsageError("label: expected a name.")
    return name.strip()


def _changed(document: Document, wall: str, change: Callable[[Wall], Wall]) -> Document:
    names = [item["name"] for item in document["walls"]]
    if wall not in names:
        raise UsageError(f"unknown wall {wall!r}; expected one of {', '.join(names)}.")
    return {**document, "walls": [change(item) if item["name"] == wall else item for item in document["walls"]]}


def _lines(axis: str) -> str:
    if axis not in {"rows", "columns"}:
        raise UsageError(f"axis: expected rows or columns, found {axis!r:.40}.")
    return axis


def _check_index(index: int, count: int) -> None:
    if not 0 <= index < count:
        raise UsageError(f"line: expected 0 to {count - 1}, found {index}.")


def _axis(axis: str) -> int:
    return 0 if _lines(axis) == "rows" else 1
