"""Steps that can be undone and done again."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Generic, TypeVar

Document = TypeVar("Document")
"""What is edited; every change makes another one."""
MOST = 500
"""Steps that are kept."""


@dataclass
class History(Generic[Document]):
    """States of a document, one after the other."""

    present: Document
    past: list[tuple[str, Document]] = field(default_factory=list)
    """What was done next, in words, and the state before that."""
    future: list[tuple[str, Document]] = field(default_factory=list)
    """What was undone, the last first, and the state after it."""

    def do(self, words: str, document: Document) -> None:
        """A step; what was undone before is gone."""
        self.past = [*self.past, (words, self.present)][-MOST:]
        self.future = []
        self.present = document

    def undo(self) -> str:
        """One step back; the words of what was undone, empty when there was nothing."""
        return self._step(self.past, self.future)

    def redo(self) -> str:
        """One step forward; the words of what was done again, empty when there was nothing."""
        return self._step(self.future, self.past)

    def _step(self, source: list[tuple[str, Document]], target: list[tuple[str, Document]]) -> str:
        if not source:
            return ""
        words, document = source.pop()
        target.append((words, self.present))
        self.present = document
        return words
