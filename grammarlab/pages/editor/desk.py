"""State of an editing session: document and history, active grid, variations to choose from, file, exports.

Windows receive facades as columns of numbers in buffers, and other values as JSON.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from grammarlab.errors import UsageError
from grammarlab.facade.file import save_facade
from grammarlab.facade.looks import look_of
from grammarlab.facade.size_locks import kind_of
from grammarlab.facade.sizes.size_wishes import Aspect, Wish, in_words
from grammarlab.facade.sizes.solve import Sizing
from grammarlab.facade.tree import Facade
from grammarlab.pages.desk import AbstractDocumentDesk, Exports, stem_of
from grammarlab.pages.editor.document import Document, opened
from grammarlab.pages.editor.suggestions import Suggestions, suggest
from grammarlab.pages.windows import PROTOCOL, Message
from grammarlab.runs.facade.gallery import show_facade
from grammarlab.runs.facade.grammar_file import grammar_of, save_grammar

SUFFIX = ".facade.json"
SUFFIXES = {"json": SUFFIX} | {form: f".{form}" for form in ("svg", "png", "glb", "obj", "cga")}
"""Suffixes of exported files by format."""


class EditorDesk(AbstractDocumentDesk[Document]):
    """The edited facade."""

    def __init__(
        self, facade: Facade, file: Path, target: Path, locks: tuple[Wish, ...] = (), *, is_target: bool = False
    ) -> None:
        """Start with the facade of a file and its locks.

        Args:
            facade: the facade.
            file: its file.
            target: the file to save to.
            locks: its locks.
            is_target: whether the target is that file.
        """
        document = opened(facade, locks)
        exports = Exports(SUFFIXES, self._export)
        super().__init__(target, document, saved=document if is_target else None, suffix=SUFFIX, exports=exports)
        self.title = stem_of(file)
        self.chosen = ""
        """Name of the last chosen grid, which may not exist any more."""
        self.suggestions: Suggestions | None = None
        self._sizing: tuple[Document, int, Sizing] | None = None

    def accept(self, document: Document) -> None:
        """Every document is possible."""

    def follow(self, previous: Document) -> None:
        """No other state depends on the document."""

    def write(self, path: Path, document: Document, *, is_new: bool) -> None:
        """Write a facade with its locks, and its pictures beside it."""
        save_facade(document.facade, path, document.locks, edited=not is_new)

    def _export(self, path: Path) -> None:
        export(self.document.facade, path, self.document.locks)

    @property
    def active(self) -> str:
        """Name of the active grid: the chosen one, else the one with most elements; empty if there is none."""
        grids = {grid.name: len(grid.node) for grid in self.document.facade.grids}
        return self.chosen if self.chosen in grids else max(grids, key=lambda name: grids[name], default="")

    def regrid(self, words: str, facade: Facade, chosen: str | None = None) -> None:
        """Performs a step that only changes grids."""
        self.chosen = self.active if chosen is None else chosen
        self.do(words, replace(self.document, facade=facade))

    def choose(self, grid: str) -> None:
        """Makes a grid the active one."""
        self.chosen = grid
        self.notify()

    def sizing(self, requested: Document, node: int = -1) -> Sizing:
        """The programme of the document with the locks of another one, prepared once per drag.

        Args:
            requested: the document itself, or one with locks that differ only in metres from call to call.
            node: node of these locks.
        """
        if self._sizing is None or self._sizing[0] is not self.document or self._sizing[1] != node:
            self._sizing = (self.document, node, requested.sizing())
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


def state_of(desk: EditorDesk) -> tuple[Message, tuple[bytes, bytes]]:
    """The whole state of the page, except pictures.

    The buffers are the columns of `columns.drawing`, and left, bottom, width and height of all nodes [N, 4].
    """
    document, facade = desk.document, desk.document.facade
    values, columns = drawing(facade)
    state = {
        "protocol": PROTOCOL,
        **desk.summary(),
        "title": desk.title,
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
        "formats": desk.formats,
        "drawing": values,
    }
    return {"event": "state", "state": state}, (columns, boxes(facade).astype("<f8").tobytes())


def export(facade: Facade, path: Path, locks: Sequence[Wish] = ()) -> Path:
    """Write a facade in the format of the path's suffix.

    Raises:
        FacadeError: If it cannot be written in that format.
    """
    if path.suffix == ".json":
        return save_facade(facade, path, locks)
    if path.suffix == ".cga":
        save_grammar(grammar_of(facade), facade, path)
        return path
    return show_facade(facade, path)


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


def boxes(facade: Facade) -> np.ndarray:
    """[N, 4] left, bottom, width and height of all nodes, metres, from the lower left corner of the facade."""
    return np.hstack([facade.position - facade.position[0], facade.size])


def colors(facade: Facade) -> list[str]:
    """The color of each label, with that of unlabelled leaves last."""
    return [look_of(label).color for label in (*facade.labels, "")]
