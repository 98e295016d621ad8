"""Scoring rounds in a notebook: the page of a session as a widget.

Needs the extra ``notebook``: ``pip install 'grammarlab[notebook]'``.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import anywidget
import traitlets

from grammarlab.preference.labels import Labels
from grammarlab.runs import scoring
from grammarlab.runs.scoring.labels import read_labels_or_session
from grammarlab.runs.scoring.session import Session
from grammarlab.runs.scoring.windows import Message

PAGE = Path(scoring.__file__).parent / "page"


class ScoringSession(anywidget.AnyWidget):
    """Models to look at and to score; what was scored is in the session file before the page says so.

    >>> session = ScoringSession("building", path="buildings.db")  # doctest: +SKIP
    >>> session.labels  # doctest: +SKIP

    The last line of a cell shows it. What a person can do on the page, a program can do with `do`.
    """

    _esm = PAGE / "page.js"
    _css = PAGE / "page.css"

    state = traitlets.Dict(read_only=True, help="What the page shows: factors, models, scores, predictions.")

    def __init__(self, grammar: str, path: Path | str, **options: Any) -> None:
        """Opens a session file, or begins one.

        Args:
            grammar: a rule file or the name of a shipped grammar.
            path: the session file, ends in .db.
            **options: of `grammarlab.runs.scoring.session.Session`: seed, size, assets, stored_grammar, jobs.

        Raises:
            TypeError: for an option that there is not.
            UsageError: when the session was begun with another grammar.
            LanguageError: for a grammar with errors.
            AssetError: for a file that is no session.
        """
        super().__init__()
        self._path = Path(path)
        self._session = Session(grammar, path, **options)
        self.on_msg(self._receive)
        self._session.listen(self._tell)

    @property
    def labels(self) -> Labels:
        """All scores so far, of all factors."""
        return read_labels_or_session(self._path)

    def do(self, command: str, **arguments: Any) -> Message:
        """Does what the page does, and waits for the answer.

        Args:
            command: such as ``score``, ``populate``, ``update``; `grammarlab.runs.scoring.commands` has all.
            **arguments: of the command: ``session.do("populate", way="uncertainty")``.

        Raises:
            GrammarlabError: when it is refused; says why.
        """
        result, _ = self._session.call(command, **arguments)
        return result

    def close(self) -> None:
        """Ends the session and its processes; the file can be opened again at any time."""
        # Widgets are closed when they are collected, also those whose session could not be opened.
        if hasattr(self, "_session"):
            self._session.close()
        super().close()

    def _receive(self, _widget: object, message: object, buffers: Sequence[memoryview]) -> None:
        self._session.handle(message, [bytes(buffer) for buffer in buffers], self._pass_on)

    def _pass_on(self, message: Message, buffers: Sequence[bytes]) -> None:
        self.send(message, list(buffers))

    def _tell(self, message: Message, buffers: Sequence[bytes]) -> None:
        if message.get("event") == "state":
            self.set_trait("state", message["state"])
        self._pass_on(message, buffers)
