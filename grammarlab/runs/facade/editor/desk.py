"""State of an editing session: document and history, active grid, variations to choose from, file."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path

from grammarlab.errors import UsageError
from grammarlab.facade.file import save_facade
from grammarlab.facade.sizes.solve import Sizing
from grammarlab.facade.sizes.wishes import Wish
from grammarlab.facade.tree import Facade
from grammarlab.runs.facade.editor.document import Document, opened
from grammarlab.runs.facade.editor.exporting import FORMATS, SUFFIX, export, stem_of, unused_path
from grammarlab.runs.facade.editor.history import History
from grammarlab.runs.facade.editor.suggestions import Suggestions, suggest


@dataclass
class EditorDesk:
    """The state; commands change it and then increment `revision`."""

    title: str
    target: Path
    """The file to save to."""
    history: History[Document]
    first: Document
    """The document when it was opened."""
    saved: Document | None
    """Content of the target; None if it is unknown."""
    revision: int = 0
    chosen: str = ""
    """Name of the last chosen grid, which may not exist any more."""
    suggestions: Suggestions | None = None
    _sizing: tuple[Document, int, Sizing] | None = None
    _exported: dict[str, Path] = field(default_factory=dict)
    """Exported files by format."""

    @classmethod
    def of(cls, facade: Facade, file: Path, target: Path, locks: tuple[Wish, ...] = ()) -> EditorDesk:
        """A desk with the facade of a file and its locks."""
        document = opened(facade, locks)
        is_there = target.exists() and target.samefile(file)
        return cls(stem_of(file), target, History(document), document, document if is_there else None)

    @property
    def document(self) -> Document:
        """The current document."""
        return self.history.present

    @property
    def active(self) -> str:
        """Name of the active grid: the chosen one, else the one with most elements; empty if there is none."""
        grids = {grid.name: len(grid.node) for grid in self.document.facade.grids}
        return self.chosen if self.chosen in grids else max(grids, key=lambda name: grids[name], default="")

    @property
    def is_saved(self) -> bool:
        """Whether the target holds the current facade."""
        return self.saved is self.document

    @property
    def is_lost(self) -> bool:
        """Whether no file holds the current facade."""
        return not self.is_saved and self.document is not self.first

    def do(self, words: str, document: Document) -> None:
        """Performs a step that can be undone."""
        self.history.do(words, document)
        self.revision += 1

    def regrid(self, words: str, facade: Facade, chosen: str | None = None) -> None:
        """Performs a step that only changes grids."""
        self.chosen = self.active if chosen is None else chosen
        self.do(words, replace(self.document, facade=facade))

    def step(self, take: Callable[[], str]) -> str:
        """Undoes or redoes a step; returns its description."""
        words = take()
        self.revision += 1
        return words

    def choose(self, grid: str) -> None:
        """Makes a grid the active one."""
        self.chosen = grid
        self.revision += 1

    def sizing(self, wished: Document, node: int = -1) -> Sizing:
        """The programme of the document with the locks of another one, prepared once per drag.

        Args:
            wished: the document itself, or one with locks that differ only in metres from call to call.
            node: node of these locks.
        """
        if self._sizing is None or self._sizing[0] is not self.document or self._sizing[1] != node:
            self._sizing = (self.document, node, wished.sizing())
        return self._sizing[2]

    def suggest(self, axis: int, *, more: bool, most: int) -> Suggestions:
        """Variations of the active grid.

        Raises:
            UsageError: If there is none.
        """
        if not self.active:
            raise UsageError("There is no grid: draw a rectangle around some windows to make one.")
        self.suggestions = suggest(self.document, self.active, axis, more=more, most=most)
        return self.suggestions

    def save(self) -> None:
        """Saves the document atomically."""
        document = self.document
        save_facade(document.facade, self.target, document.locks, edited=True)
        self.saved = document
        self.revision += 1

    def export(self, kind: str) -> Path:
        """A file of another kind beside the target; only previous exports are replaced.

        Raises:
            UsageError: If the kind is unknown.
        """
        if kind not in FORMATS:
            raise UsageError(f"format: expected one of {', '.join(FORMATS)}, found {kind!r}.")
        path = self._exported.get(kind) or unused_path(self.target, SUFFIX if kind == "json" else f".{kind}")
        self._exported[kind] = export(self.document.facade, path, self.document.locks)
        return self._exported[kind]

    def rescue(self) -> Path:
        """Saves unsaved changes to a new file beside the target."""
        return save_facade(self.document.facade, unused_path(self.target, f".unsaved{SUFFIX}"), self.document.locks)
