"""State of an editing session: document and history, active grid, variations to choose from, file.

State of a desk for windows.

Drawing data of facades for a page: numbers as columns in buffers, other values as JSON.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from grammarlab.errors import UsageError
from grammarlab.facade.file import save_facade
from grammarlab.facade.looks import look_of
from grammarlab.facade.size_locks import kind_of
from grammarlab.facade.sizes.size_wishes import Aspect, Wish, in_words
from grammarlab.facade.sizes.solve import Sizing
from grammarlab.facade.tree import Facade
from grammarlab.pages.desktop import Message
from grammarlab.pages.editor.document import Document, opened
from grammarlab.pages.editor.exporting import FORMATS, SUFFIX, export, stem_of, unused_path
from grammarlab.pages.editor.history import History
from grammarlab.pages.editor.suggestions import Suggestions, suggest


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


def drawing(facade: Facade) -> tuple[Message, bytes]:
    """Drawing data of a facade.

    Returns:
        label: [L] index of each leaf into `colors`; -1 for none.
        picture: [L] index of each leaf's picture, -1 for none.
        outlines: for each leaf with an outline: its index among leaves, and its corners as fractions of its box.
        And as bytes [L, 8] doubles: left, bottom, width and height in metres, left, bottom, right and top of its part
        of the picture.
    """
    leaves = facade.leaves
    counts = np.diff(facade.outline_offsets)[leaves]
    values = {
        "width": facade.width,
        "height": facade.height,
        "label": facade.label[leaves].tolist(),
        "picture": facade.picture[leaves].tolist(),
        "outlines": [
            {"leaf": leaf, "corners": facade.outline(int(leaves[leaf])).tolist()}
            for leaf in np.flatnonzero(counts).tolist()
        ],
    }
    return values, np.hstack([boxes(facade)[leaves], facade.window[leaves]]).astype("<f8").tobytes()


def colors(facade: Facade) -> list[str]:
    """The color of each label, with that of unlabelled leaves last."""
    return [look_of(label).color for label in (*facade.labels, "")]


def boxes(facade: Facade) -> np.ndarray:
    """[N, 4] left, bottom, width and height of all nodes, metres, from the lower left corner of the facade."""
    return np.hstack([facade.position - facade.position[0], facade.size])


PROTOCOL = 1


def state_of(desk: EditorDesk) -> tuple[Message, tuple[bytes, bytes]]:
    """The whole state of the page, except pictures.

    The buffers are the columns of `columns.drawing`, and left, bottom, width and height of all nodes [N, 4].
    """
    document, facade = desk.document, desk.document.facade
    values, columns = drawing(facade)
    past, future = desk.history.past, desk.history.future
    state = {
        "protocol": PROTOCOL,
        "revision": desk.revision,
        "title": desk.title,
        "file": str(desk.target),
        "saved": desk.is_saved,
        "lost": desk.is_lost,
        "undo": past[-1][0] if past else "",
        "redo": future[-1][0] if future else "",
        "labels": list(facade.labels),
        "colors": colors(facade),
        "leaves": facade.leaves.tolist(),
        "parent": facade.parent.tolist(),
        "names": facade.label.tolist(),
        "pictures": len(facade.pictures),
        "grids": [
            {
                "name": grid.name,
                "rows": grid.num_rows,
                "columns": grid.num_columns,
                "nodes": grid.node.tolist(),
            }
            for grid in facade.grids
        ],
        "active": desk.active,
        "locks": [
            {
                "node": lock.node,
                "what": kind_of(lock),
                "words": in_words(lock, facade),
                "range": [lock.least, lock.most] if isinstance(lock, Aspect) else [],
            }
            for lock in document.locks
        ],
        "formats": FORMATS,
        "drawing": values,
    }
    return {"event": "state", "state": state}, (columns, boxes(facade).astype("<f8").tobytes())
