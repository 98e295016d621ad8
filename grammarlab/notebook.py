"""Scoring rounds in a notebook: the page of a session as a widget.

Needs the extra ``notebook``: ``pip install 'grammarlab[notebook]'``.
"""

from __future__ import annotations

import logging
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Unpack

from grammarlab import scoring
from grammarlab.extras import named_extras
from grammarlab.preference.labels.table import Labels
from grammarlab.runs.requests.examples import find_rules
from grammarlab.runs.serving.windows import Argument, Message
from grammarlab.scoring.session import Session, SessionOptions
from grammarlab.scoring.workers.labels import read_labels_or_session

with named_extras():
    import anywidget
    import traitlets

LOG = logging.getLogger(__name__)
PAGE = Path(scoring.__file__).parent / "static"


@dataclass(eq=False)
class _OpenSession:
    """A session that is open in this process."""

    session: Session
    path: Path
    """Resolved."""
    inode: int
    given: tuple[str, Path, SessionOptions]
    """Text of the rule file, folder of its assets, and options that it was opened with."""
    newest: str = ""
    """Identifier of the widget that was made last for it."""
    warned: set[str] = field(default_factory=set)
    """Warnings that were logged."""

    @classmethod
    def of(cls, grammar: str, path: Path, options: SessionOptions) -> _OpenSession:
        """The session of a file: the one that is open if it is the same, else one that takes its place."""
        place, source = path.resolve(), find_rules(grammar, options.get("assets"))
        given = source.text(), source.assets.resolve(), options
        known = _OPEN.get(place)
        if known is not None and not known.has_its_file():
            # First of all, since SQLite would take the new file's log for its own.
            known.close()
            known = None
        if known is not None and known.given == given:
            return known
        session = Session(grammar, path, **options)
        if known is not None:
            known.close()
        _OPEN[place] = cls(session, place, place.stat().st_ino, given)
        return _OPEN[place]

    def has_its_file(self) -> bool:
        """Whether the file is still there, and not another one."""
        return self.path.exists() and self.path.stat().st_ino == self.inode

    def close(self) -> None:
        """Ends the session."""
        self.session.close()
        if _OPEN.get(self.path) is self:
            del _OPEN[self.path]

    def warn(self, warnings: Sequence[str]) -> None:
        """Logs each warning once, whichever widgets hear of it."""
        for warning in warnings:
            if warning not in self.warned:
                self.warned.add(warning)
                LOG.warning(warning)


_OPEN: dict[Path, _OpenSession] = {}
"""By file. A cell that is run again makes another widget while ipywidgets keeps the one before it, which must not mean
another session with processes of its own."""


class ScoringSession(anywidget.AnyWidget):
    """Models to look at and to score; what was scored is in the session file before the page says so.

    As the last line of a cell, ``ScoringSession("building", path="buildings.db")`` shows the page. What a person can do
    there, a program can do with `do`. A cell that is run again goes on with the session that is open: widgets of one
    file share it, until the newest of them is closed.

    >>> from tempfile import TemporaryDirectory
    >>> with TemporaryDirectory() as folder:
    ...     session = ScoringSession("toy", path=Path(folder) / "towers.db", jobs=0)
    ...     models = session.do("state")["grids"][0]["models"]
    ...     _ = session.do("score", models=models[:2], score=80)
    ...     scores = session.labels.scores
    ...     session.close()
    >>> scores.tolist()
    [80.0, 80.0]
    """

    _esm = PAGE / "page.js"
    _css = PAGE / "page.css"

    state = traitlets.Dict(read_only=True, help="What the page shows: factors, models, scores, predictions.")

    def __init__(self, grammar: str, path: Path | str, **options: Unpack[SessionOptions]) -> None:
        """Opens a session file, or begins one.

        Args:
            grammar: a rule file or the name of a shipped grammar.
            path: the session file, ends in .db.
            **options: as of `grammarlab.scoring.session.Session`.

        Raises:
            TypeError: for an option that there is not.
            UsageError: when the session was begun with another grammar.
            LanguageError: for a grammar with errors.
            AssetError: for a file that is no session.
        """
        super().__init__()
        self._path = Path(path)
        self._opened = _OpenSession.of(grammar, self._path, options)
        self._opened.newest = self.model_id
        self._session = self._opened.session
        self.on_msg(self._receive)
        self._unlisten = self._session.listen(self._tell)

    @property
    def labels(self) -> Labels:
        """All scores and comparisons so far, of all factors."""
        return read_labels_or_session(self._path)[0]

    def do(self, command: str, **arguments: Argument) -> Message:
        """Does what the page does, and waits for the answer.

        Args:
            command: such as ``score``, ``compare``, ``update``; `grammarlab.scoring.commands` has all.
            **arguments: of the command: ``session.do("populate", way="uncertainty")``.

        Raises:
            GrammarlabError: when it is refused; says why.
        """
        result, _ = self._session.call(command, (), **arguments)
        return result

    def close(self) -> None:
        """Ends the session and its processes, unless a newer widget goes on with it.

        The file can be opened again at any time.
        """
        # Widgets are closed when they are collected, also those whose session could not be opened.
        if hasattr(self, "_unlisten") and self.comm is not None:
            if self._opened.newest == self.model_id:
                self._opened.close()
            self._unlisten()
        super().close()

    def _receive(self, _widget: object, message: object, buffers: Sequence[memoryview]) -> None:
        self._session.handle(message, [bytes(buffer) for buffer in buffers], self._tell)

    def _tell(self, message: Message, buffers: Sequence[bytes]) -> None:
        if message.get("event") == "state":
            self.set_trait("state", message["state"])
            self._opened.warn(message["state"]["warnings"])
        self.send(message, list(buffers))
