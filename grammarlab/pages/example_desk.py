"""State of a correction session: the analysis of an example, corrections that can be undone, file, and results.

Corrections of an example on the document of its file, one step at a time; every function returns a new document.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from grammarlab.errors import FacadeError, UsageError
from grammarlab.files import rewrite_text, write_text
from grammarlab.pages.editor.history import History
from grammarlab.runs.facade.built import Built, build
from grammarlab.runs.facade.gallery import sheet
from grammarlab.synthesis.analysis.correction import corrected, dumps, with_corrections
from grammarlab.synthesis.analysis.example import MOST_LINES, Example, analyse
from grammarlab.synthesis.example_pictures import building_picture, label_picture
from grammarlab.synthesis.label_synthesis import synthesize
from grammarlab.synthesis.mesh.building_files import read_mesh
from grammarlab.synthesis.mesh.surface import edge_numbers
from grammarlab.synthesis.units import stock_of

Document = dict[str, Any]
"""Document of `grammarlab.synthesis.analysis.correction`."""
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


@dataclass
class ExampleDesk:
    """The state; commands change it and then increment `revision`."""

    file: Path
    """Path of the mesh."""
    target: Path
    """File to save corrections to."""
    found: Example
    """The example from the analysis."""
    first: Document
    """The same as a document."""
    history: History[Document]
    saved: Document | None = None
    """Content of the target; None if it is unknown."""
    revision: int = 0
    names: list[str] = field(default_factory=list)
    """Labels in order of first occurrence, so that their colors do not change."""

    @classmethod
    def of(cls, file: Path, target: Path) -> ExampleDesk:
        """A desk with the building of a file, and its saved corrections, if any.

        Raises:
            FacadeError: If the file cannot be read, or has no units, or the target belongs to another example.
        """
        found = analyse(read_mesh(file))
        first = json.loads(dumps(found))
        if not target.exists():
            return cls(file, target, found, first, History(first))
        document = json.loads(dumps(corrected(found, target)))
        return cls(file, target, found, first, History(document), document)

    @property
    def document(self) -> Document:
        """The current document."""
        return self.history.present

    @property
    def is_saved(self) -> bool:
        return self.saved is self.document

    @property
    def is_lost(self) -> bool:
        """Whether no file holds the current corrections."""
        return not self.is_saved and self.document is not self.first

    @property
    def example(self) -> Example:
        """The corrected example."""
        return with_corrections(self.found, self.document)

    @cached_property
    def picture(self) -> Image.Image:
        """Picture of the building."""
        return building_picture(self.found.surface, self.found.mesh.colors)

    def do(self, words: str, document: Document) -> None:
        """Performs a step that can be undone.

        Raises:
            FacadeError: If the example does not allow it; with the reason.
        """
        with_corrections(self.found, document)
        self.history.do(words, document)
        self.revision += 1

    def step(self, *, forward: bool) -> str:
        """Undoes or redoes a step; returns its description."""
        words = self.history.redo() if forward else self.history.undo()
        self.revision += 1
        return words

    def label_names(self) -> list[str]:
        """All labels that have occurred so far."""
        for wall in self.document["walls"]:
            for name in (each for row in wall["labels"] for each in row):
                if name not in self.names:
                    self.names.append(name)
        return self.names

    def save(self) -> None:
        """Saves the corrections atomically."""
        document = self.document
        self.target.parent.mkdir(parents=True, exist_ok=True)
        rewrite_text(self.target, dumps(self.example))
        self.saved = document
        self.revision += 1

    def rescue(self) -> Path:
        """Saves unsaved changes to a new file beside the target."""
        for number in range(1, 1_000):
            path = self.target.with_name(f"{self.target.stem}.unsaved{number}.json")
            if not path.exists():
                write_text(path, dumps(self.example))
                return path
        raise FacadeError(f"{self.target.parent} has too many files of unsaved changes: delete some.")

    def tried(self, rows: int, columns: int, seed: int) -> tuple[Built, Image.Image]:
        """A new building from the corrected example, and a picture: example, labels, new labels, new building."""
        example = replace(self.example, notes=())
        stock = stock_of([example])
        main = synthesize(stock.grids, rows, columns, seed=seed)[0]
        made = build(example, stock, main, None, (None, None, None), seed, edge_numbers(example.surface), {})
        pictures = [
            self.picture,
            label_picture(example.main.grid),
            label_picture(main.grid),
            building_picture(made.surface, stock.colors),
        ]
        return made, sheet(pictures)
