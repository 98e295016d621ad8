"""Pages in a notebook as widgets: a scoring session, and a rule file that is being written.

Needs the extra ``notebook``: ``pip install 'grammarlab[notebook]'``.
"""

from __future__ import annotations

import logging
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Unpack

from grammarlab.asset_roots import AssetRoot
from grammarlab.extras import named_extras
from grammarlab.language.presets import NO_CHOICES
from grammarlab.pages import STATIC
from grammarlab.pages.record.label_exchange import read_labels_or_session
from grammarlab.pages.scoring.session import Session, SessionOptions
from grammarlab.pages.watch.watcher import Watcher
from grammarlab.pages.windows import Argument, Message
from grammarlab.preference.labels import Labels
from grammarlab.runs.sample.shipped import find_rules
from grammarlab.runs.work.workers import end_if_unguarded

with named_extras():
    import anywidget
    import traitlets

LOG = logging.getLogger(__name__)
PAGE = STATIC / "scoring"


@dataclass(eq=False)
class _OpenSession:
    """An open session of this process."""

    session: Session
    path: Path
    """Resolved path of the session file."""
    inode: int
    inputs: tuple[str, AssetRoot, SessionOptions]
    """Text of the file, folder of its assets, and options of the session."""
    newest: str = ""
    """Identifier of the newest widget of the session."""
    warned: set[str] = field(default_factory=set)
    """Warnings already logged."""

    @classmethod
    def open(cls, grammar: str, path: Path, options: SessionOptions) -> _OpenSession:
        """Session of a file: the open one if grammar and options are equal, otherwise a new one that replaces it."""
        file, source = path.resolve(), find_rules(grammar, options.get("assets"), options.get("choices", NO_CHOICES))
        inputs = source.text(), source.assets.resolve(), options
        current = _OPEN.get(file)
        if current is not None and not current.has_its_file():
            # Close first, since the old SQLite connection would use the log of the new file.
            current.close()
            current = None
        if current is not None and current.inputs == inputs:
            return current
        session = Session(grammar, path, **options)
        if current is not None:
            current.close()
        _OPEN[file] = cls(session, file, file.stat().st_ino, inputs)
        return _OPEN[file]

    def has_its_file(self) -> bool:
        """Whether the file still exists and is the same file."""
        return self.path.exists() and self.path.stat().st_ino == self.inode

    def close(self) -> None:
        """End the session."""
        self.session.close()
        if _OPEN.get(self.path) is self:
            del _OPEN[self.path]

    def warn(self, warnings: Sequence[str]) -> None:
        """Log each warning once, for any number of widgets."""
        for warning in warnings:
            if warning not in self.warned:
                self.warned.add(warning)
                LOG.warning(warning)


_OPEN: dict[Path, _OpenSession] = {}
"""Open sessions by file. A cell that is run again makes a new widget while ipywidgets keeps the old one; both share the
session and its processes."""


class ScoringSession(anywidget.AnyWidget):
    """Widget to view and score models; a score is in the session file before the page shows it as saved.

    As the last line of a cell, ``ScoringSession("building", path="buildings.db")`` shows the page. A program can do the
    same actions with `do`. A cell that is run again continues the open session: widgets of one file share it until the
    newest of them is closed. In a script, use it below ``if __name__ == "__main__":``, since worker processes import
    the script again.

    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> import grammarlab as gl
    >>> with TemporaryDirectory() as folder:
    ...     session = gl.ScoringSession("toy", path=Path(folder) / "towers.db", jobs=0)
    ...     models = session.do("state")["grids"][0]["models"]
    ...     _ = session.do("score", models=models[:2], score=80)
    ...     scores = session.labels.scores
    ...     session.close()
    >>> scores.tolist()
    [80.0, 80.0]
    """

    _esm = PAGE / "page.js"
    _css = PAGE / "page.css"

    state = traitlets.Dict(read_only=True, help="State of the page: factors, models, scores, predictions.")

    def __init__(self, grammar: str, path: Path | str, **options: Unpack[SessionOptions]) -> None:
        """Open a session file, or create one.

        Args:
            grammar: a rule file, a species of trees, or the name of a shipped one.
            path: the session file, ends in .db.
            **options: options of `grammarlab.pages.scoring.session.Session`.

        Raises:
            TypeError: If an option does not exist.
            UsageError: If the session was created with another grammar.
            LanguageError: If the grammar has errors.
            AssetError: If the file is not a session.
        """
        super().__init__()
        self._path = Path(path)
        self._opened = _OpenSession.open(grammar, self._path, options)
        self._opened.newest = self.model_id
        self._session = self._opened.session
        self.on_msg(self._receive)
        self._unlisten = self._session.listen(self._tell)

    @property
    def labels(self) -> Labels:
        """All scores and comparisons so far, of all factors."""
        return read_labels_or_session(self._path)[0]

    def do(self, command: str, **arguments: Argument) -> Message:
        """Run a command of the page, and wait for the answer.

        Args:
            command: such as ``score``, ``compare``, ``update``; `grammarlab.pages.scoring.commands` lists all.
            **arguments: arguments of the command: ``session.do("new_models", way="uncertainty")``.

        Raises:
            GrammarlabError: If the command is refused, with the reason.
        """
        result, _ = self._session.call(command, (), **arguments)
        return result

    def close(self) -> None:
        """End the session and its processes, unless a newer widget uses them.

        The file can be opened again at any time.
        """
        # Garbage collection closes widgets, including those whose session could not be opened.
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


class RuleView(anywidget.AnyWidget):
    """Widget of a rule file: its model, again after every save, with mistakes, attributes, and the tree beside it.

    It is what ``grammarlab watch`` shows in the browser. In a script, use it below ``if __name__ == "__main__":``.
    """

    _esm = STATIC / "watch" / "page.js"
    _css = STATIC / "watch" / "page.css"

    state = traitlets.Dict(read_only=True, help="State of the page: seed, values of attributes, mistakes.")

    def __init__(self, grammar: str, *, assets: Path | None = None, library: Path | None = None) -> None:
        """Watch a rule file; it may have errors.

        Args:
            grammar: a rule file, or the name of a shipped one.
            assets: folder of assets, by default the one beside the file.
            library: folder of further projects that the file imports from.

        Raises:
            UsageError: If there is no such file, or it describes a species.
        """
        super().__init__()
        end_if_unguarded()
        self._watcher = Watcher(grammar, assets=assets, library=library)
        self.on_msg(self._receive)
        self._unlisten = self._watcher.listen(self._tell)

    def close(self) -> None:
        """End the processes of the widget."""
        # Garbage collection closes widgets, including those whose file could not be read.
        if hasattr(self, "_unlisten") and self.comm is not None:
            self._unlisten()
            self._watcher.close()
        super().close()

    def _receive(self, _widget: object, message: object, buffers: Sequence[memoryview]) -> None:
        self._watcher.handle(message, [bytes(buffer) for buffer in buffers], self._tell)

    def _tell(self, message: Message, buffers: Sequence[bytes]) -> None:
        if message.get("event") == "state":
            self.set_trait("state", message["state"])
        self.send(message, list(buffers))


def view(grammar: str, *, assets: Path | None = None, library: Path | None = None) -> RuleView:
    """Show the model of a rule file in a notebook, again after every save of the file in any editor.

    The page has the mistakes with their lines, sliders, menus and colours of attributes, dice for the seed, a sheet of
    sixteen models and the derivation tree; a click on a part or a row shows the other.

    Args:
        grammar: a rule file, or the name of a shipped one.
        assets: folder of assets, by default the one beside the file.
        library: folder of further projects that the file imports from.

    Returns:
        A widget; as the last line of a cell it is shown, ``close`` ends its processes.

    Raises:
        UsageError: If there is no such file, or it describes a species.

    >>> import grammarlab as gl
    >>> page = gl.view("toy")
    >>> page.close()
    """
    return RuleView(grammar, assets=assets, library=library)
