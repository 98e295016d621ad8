"""Steps that can be undone and redone."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Generic, TypeVar

Document = TypeVar("Document")
"""The edited value; every change makes another one."""
MOST = 500
"""Largest number of stored steps."""


@dataclass
class History(Generic[Document]):
    """States of a document in order."""

    present: Document
    past: list[tuple[str, Document]] = field(default_factory=list)
    """Description of each step, and the state before it."""
    future: list[tuple[str, Document]] = field(default_factory=list)
    """Description of each undone step, the last one first, and the state after it."""

    def do(self, words: str, document: Document, *, joins: bool = False) -> None:
        """Performs a step; undone steps are discarded.

        Args:
            words: description of the step.
            document: the state after it.
            joins: whether it becomes part of the step before it, if that has the same description and was not undone.
        """
        if not (joins and not self.future and self.past and self.past[-1][0] == words):
            self.past = [*self.past, (words, self.present)][-MOST:]
            self.future = []
        self.present = document

    def undo(self) -> str:
        """Undoes a step; returns its description, or an empty text if there is none."""
        return self._step(self.past, self.future)

    def redo(self) -> str:
        """Redoes a step; returns its description, or an empty text if there is none."""
        return self._step(self.future, self.past)

    def _step(self, source: list[tuple[str, Document]], target: list[tuple[str, Document]]) -> str:
        if not source:
            return ""
        words, document = source.pop()
        target.append((words, self.present))
        self.present = document
        return words
