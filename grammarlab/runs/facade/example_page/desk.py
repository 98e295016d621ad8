"""State of a correction session: the analysis of an example, corrections that can be undone, file, and results."""

from __future__ import annotations

import json
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path

from PIL import Image

from grammarlab.errors import FacadeError
from grammarlab.facade.examples.analysis.correction import corrected, dumps, with_corrections
from grammarlab.facade.examples.analysis.example import Example, analyse
from grammarlab.facade.examples.building.shown.pictures import building_picture, label_picture
from grammarlab.facade.examples.building.stock import stock_of
from grammarlab.facade.examples.mesh.reading import read_mesh
from grammarlab.facade.examples.mesh.surface import edge_numbers
from grammarlab.facade.examples.synthesis import synthesize
from grammarlab.files import rewrite_text, write_text
from grammarlab.runs.facade.editor.history import History
from grammarlab.runs.facade.example_page.edits import Document
from grammarlab.runs.facade.gallery import sheet
from grammarlab.runs.facade.synthesis.built import Built, build


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
