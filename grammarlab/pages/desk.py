"""Desks: what the windows of a page work on together, with its file, its history, and the commands of all pages."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Generic, TypeVar

from grammarlab.errors import UsageError
from grammarlab.pages.requests import Request
from grammarlab.pages.windows import Answer, Message, Refuse

Document = TypeVar("Document")
"""The edited value; every change makes another one."""
MAX_STEPS = 500
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
            self.past = [*self.past, (words, self.present)][-MAX_STEPS:]
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


class AbstractDesk(ABC):
    """State that windows change together. All methods are for one thread."""

    target: Path
    """The file to save to."""
    formats: tuple[str, ...]
    """Formats of exports."""
    revision: int = 0
    """Counter of the changes that windows hear of."""

    def notify(self) -> None:
        """Let windows hear of a change."""
        self.revision += 1

    @property
    @abstractmethod
    def is_saved(self) -> bool:
        """Whether the target holds the current state."""

    @property
    @abstractmethod
    def is_lost(self) -> bool:
        """Whether no file holds the current state."""

    @abstractmethod
    def undo(self) -> Message:
        """Undo the last step; returns the answer to the window."""

    @abstractmethod
    def redo(self) -> Message:
        """Redo the last undone step; returns the answer to the window."""

    @abstractmethod
    def save(self) -> Message:
        """Save the current state atomically; returns the answer to the window."""

    @abstractmethod
    def export(self, form: str, answer: Answer, refuse: Refuse) -> None:
        """Export the current state.

        Args:
            form: one of `formats`.
            answer: receives the result, now or later.
            refuse: receives the reason of a failure that happens later.
        """

    @abstractmethod
    def rescue(self) -> Path:
        """Save what is lost otherwise to a new file beside the target, and return its path."""


DeskT = TypeVar("DeskT", bound=AbstractDesk)
"""The desk of a page."""
Command = Callable[[DeskT, Request], Message | None]
"""Function of a command; one without a result sends the answer itself."""


@dataclass(frozen=True)
class Exports:
    """Other formats of a document."""

    suffixes: Mapping[str, str]
    """Suffixes of files by format."""
    write: Callable[[Path], None]
    """Writes the current document in the format of the path's suffix."""


_NO_EXPORTS = Exports({}, lambda _: None)


class AbstractDocumentDesk(AbstractDesk, Generic[Document]):
    """A desk whose state is a document: an immutable value, of which each step makes another one."""

    def __init__(
        self,
        target: Path,
        first: Document,
        *,
        saved: Document | None = None,
        suffix: str = ".json",
        exports: Exports = _NO_EXPORTS,
    ) -> None:
        """Start with the saved document, otherwise with the first one.

        Args:
            target: the file to save to.
            first: the document without changes.
            saved: content of the target; None if it is unknown.
            suffix: suffix of rescued files.
            exports: formats to export to.
        """
        self.target, self.first, self.saved = target, first, saved
        self.history: History[Document] = History(first if saved is None else saved)
        self.draft: Document | None = None
        """The document that a person is typing, while it has mistakes; the next step replaces it."""
        self._suffix, self._exports = suffix, exports
        self.formats = tuple(exports.suffixes)
        self._exported: dict[str, Path] = {}
        """Exported files by format."""

    @abstractmethod
    def accept(self, document: Document) -> None:
        """Check a document before it becomes the current one.

        Raises:
            GrammarlabError: If it is not possible, with the reason.
        """

    @abstractmethod
    def follow(self, previous: Document) -> None:
        """Adapt other state to the current document, which has replaced a previous one."""

    @abstractmethod
    def write(self, path: Path, document: Document, *, is_new: bool) -> None:
        """Write a document atomically.

        Args:
            path: the file.
            document: what to write.
            is_new: whether the file is new; otherwise it may be a link, which stays one, and its permissions stay.
        """

    @property
    def document(self) -> Document:
        """The current document."""
        return self.history.present

    @property
    def content(self) -> Document:
        """The document with what a person is typing."""
        return self.document if self.draft is None else self.draft

    @property
    def is_saved(self) -> bool:
        """Whether the target holds the current document."""
        return self.saved is not None and self.content == self.saved

    @property
    def is_lost(self) -> bool:
        """Whether no file holds the current document."""
        return not self.is_saved and self.content != self.first

    def do(self, words: str, document: Document, *, joins: bool = False) -> None:
        """Perform a step that can be undone; one that changes nothing is not stored.

        Args:
            words: description of the step.
            document: the document after it.
            joins: whether it becomes part of the step before it, if that has the same description.

        Raises:
            GrammarlabError: If the document is not possible, with the reason.
        """
        self.accept(document)
        previous = self.document
        if document != previous:
            self.history.do(words, document, joins=joins)
        self._after_step(previous)

    def undo(self) -> Message:
        """Undo the last step; the answer has its description, empty if there is none."""
        return self._step(self.history.past, self.history.undo)

    def redo(self) -> Message:
        """Redo the last undone step; the answer has its description, empty if there is none."""
        return self._step(self.history.future, self.history.redo)

    def save(self) -> Message:
        """Save the document atomically."""
        content = self.content
        self.write(self.target, content, is_new=False)
        self.saved = content
        self.notify()
        return {"file": str(self.target), **self.done()}

    def export(self, form: str, answer: Answer, refuse: Refuse) -> None:
        """Write the document in another format beside the target; only previous exports are replaced."""
        path = self._exported.get(form) or _unused_path(self.target, self._exports.suffixes[form])
        self._exports.write(path)
        self._exported[form] = path
        answer({"file": str(path)}, ())

    def rescue(self) -> Path:
        """Save unsaved changes to a new file beside the target."""
        path = _unused_path(self.target, f".unsaved{self._suffix}")
        self.write(path, self.content, is_new=True)
        return path

    def done(self) -> Message:
        """Answer to a command that has changed the document."""
        return {"revision": self.revision}

    def summary(self) -> Message:
        """State of file and history for windows."""
        past, future = self.history.past, self.history.future
        return {
            "revision": self.revision,
            "file": str(self.target),
            "saved": self.is_saved,
            "lost": self.is_lost,
            "undo": past[-1][0] if past else "",
            "redo": future[-1][0] if future else "",
        }

    def _step(self, steps: list[tuple[str, Document]], take: Callable[[], str]) -> Message:
        if steps:
            self.accept(steps[-1][1])
        previous, words = self.document, take()
        self._after_step(previous)
        return {"words": words, **self.done()}

    def _after_step(self, previous: Document) -> None:
        self.draft = None
        self.follow(previous)
        self.notify()


def opened_target(file: Path, output: Path | None, ending: str, suffix: str) -> tuple[Path, bool]:
    """The file to save to, and whether it is the opened file.

    Args:
        file: the opened file.
        output: the requested file; None for a new one in the current folder.
        ending: required last suffix of a requested file.
        suffix: all suffixes of a new file.

    Raises:
        UsageError: If the requested file cannot be saved to.
    """
    target = (
        _checked_target(output, ending) if output else _unused_path(Path(f"{stem_of(file)}.edited{ending}"), suffix)
    )
    return target, target.exists() and target.samefile(file)


def stem_of(path: Path) -> str:
    """The name of a file of a facade or a design without its suffixes.

    >>> stem_of(Path("house.facade.json")), stem_of(Path("house.json")), stem_of(Path("house.toml"))
    ('house', 'house', 'house')
    """
    return path.name.removesuffix(".toml").removesuffix(".json").removesuffix(".facade")


def _skip(_desk: AbstractDesk, _request: Request) -> Message:
    """The answer to a drag that a later one has replaced."""
    return {"skipped": True}


def _undo(desk: AbstractDesk, _request: Request) -> Message:
    return desk.undo()


def _redo(desk: AbstractDesk, _request: Request) -> Message:
    return desk.redo()


def _save(desk: AbstractDesk, _request: Request) -> Message:
    return desk.save()


def _export(desk: AbstractDesk, request: Request) -> None:
    if not desk.formats:
        raise UsageError("This page has no exports.")
    desk.export(request.one_of("format", desk.formats), request.answer, request.refuse)


DESK_COMMANDS: dict[str, Command[AbstractDesk]] = {
    "skip": _skip,
    "undo": _undo,
    "redo": _redo,
    "save": _save,
    "export": _export,
}
"""Commands of all pages."""


def _unused_path(path: Path, suffix: str) -> Path:
    """An unused path with this suffix in the same folder, numbered if needed."""
    stem, number = stem_of(path), 1
    while (candidate := path.with_name(f"{stem}{f'-{number}' if number > 1 else ''}{suffix}")).exists():
        number += 1
    return candidate


def _checked_target(path: Path, ending: str = ".json") -> Path:
    """A path to which a facade, or another file with this suffix, can be saved.

    Raises:
        UsageError: If its folder is missing, or it has another suffix.
    """
    if path.suffix.lower() != ending:
        raise UsageError(f"{path}: expected the name of a file that ends in {ending}.")
    if not path.parent.is_dir():
        raise UsageError(f"{path}: there is no folder {str(path.parent)!r}; create it first.")
    return path
