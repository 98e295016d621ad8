"""Desk of a scoring session: all its actions, for one thread."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path

from grammarlab.asset_roots import AssetRoot
from grammarlab.pages.desk import AbstractDesk
from grammarlab.pages.record.events import Record
from grammarlab.pages.record.model_grids import PAIRS, Body, ModelGrid
from grammarlab.pages.record.store import Store
from grammarlab.pages.scoring.display import SessionDisplay
from grammarlab.pages.scoring.learning import Learning
from grammarlab.pages.scoring.next_models import NextModels, fresh_samples
from grammarlab.pages.scoring.session_files import FORMATS, Result, SessionFiles, answer_outcome
from grammarlab.pages.windows import Answer, Message, Refuse
from grammarlab.pages.workers.tasks import DrawContrast, FindPart, MakeGlb
from grammarlab.pages.workers.thumbnails import Thumbnails
from grammarlab.pages.workers.worker_pool import WorkerPool

_LONG_TASK_NICENESS = 5
"""Nice value of processes of long tasks, so that pictures are drawn first."""


class SessionDesk(AbstractDesk):
    """A running session. Every step is in the session file before it is answered, so nothing is ever lost."""

    formats = FORMATS

    def __init__(
        self,
        path: Path,
        store: Store,
        assets: AssetRoot,
        artists: WorkerPool,
        tell: Callable[[Message], None],
        phrase: Callable[[str], str],
    ) -> None:
        """Start on an open session.

        Args:
            path: the session file.
            store: the open session file.
            assets: folder of meshes and images.
            artists: pool of processes that draw.
            tell: sends a message to all windows.
            phrase: says warnings in the words of those who read the page.
        """
        self.target = path
        self.display = display = SessionDisplay(store, self.notify, phrase)
        about = store.about
        source, deliver = (about.suffix, about.grammar, about.title, assets), artists.deliver
        models = about.seed, about.size, display.record.wide
        learners = WorkerPool(
            make="grammarlab.pages.workers.learner:learner",
            arguments=(*source, *models),
            size=1,
            deliver=deliver,
            politeness=_LONG_TASK_NICENESS,
        )
        makers = WorkerPool(
            make="grammarlab.pages.workers.maker:maker",
            arguments=(*source, str(path), about.seed, about.size),
            size=1,
            deliver=deliver,
            politeness=_LONG_TASK_NICENESS,
        )

        def announce(task: str, stage: str, done: int, total: int) -> None:
            tell({"event": "progress", "of": task, "stage": stage, "done": done, "total": total})

        self._artists = artists
        self.learning = Learning(display, learners, partial(announce, "update"))
        self.files = SessionFiles(display, path, makers, announce)
        self.thumbnails = Thumbnails(artists, display.warn)
        if not display.record.grids:
            samples = fresh_samples(display.pool, display.record, display.record.layout.models)
            display.show("default", NextModels((), samples))

    @property
    def is_saved(self) -> bool:
        """True, since every event is in the file."""
        return True

    @property
    def is_lost(self) -> bool:
        """False, since every event is in the file."""
        return False

    def undo(self) -> Message:
        """Undo the last score, comparison, import or change of factors."""
        return self.do("undo", {})

    def redo(self) -> Message:
        """Redo the last undone one."""
        return self.do("redo", {})

    def save(self) -> Message:
        """Everything is saved already."""
        return {"saved": True, "revision": self.display.record.revision}

    def export(self, form: str, answer: Answer, refuse: Refuse) -> None:
        """Answer with all scores as the content of a label file."""
        self.files.export(f".{form}", answer, refuse)

    def rescue(self) -> Path:
        """The session file, which holds everything."""
        return self.target

    def do(self, kind: str, body: Body | Callable[[Record], Body]) -> Message:
        """Add an event; see `Store.append`. The answer says that it is in the file."""
        return {"saved": True, "revision": self.display.do(kind, body)}

    def close(self) -> None:
        """End all processes."""
        self.learning.close()
        self.files.close()
        self.display.store.close()
        self._artists.close()

    def layout(self, layout: Body) -> None:
        """Change the size of the grids, and fill them; pairs are not shown in grids, and do not change.

        Raises:
            UsageError: If it is out of range.
        """
        record = self.display.record
        before = record.layout
        self.display.do("layout", layout)
        record = self.display.record
        after = record.layout
        if record.way == PAIRS:
            return
        if after.grids == before.grids and after.rows * after.columns <= before.rows * before.columns:
            size = after.rows * after.columns
            self.display.arrange([ModelGrid(grid.title, grid.models[:size]) for grid in record.grids])
        else:
            self.learning.new_models(record.way)

    def prepare_if_free(self) -> None:
        """Start learning after the first pictures."""
        if self.thumbnails.shows_something and not self.thumbnails.is_hurried:
            self.learning.prepare()
            self.learning.learn_behind()

    def ask_artist(
        self, task: MakeGlb | FindPart | DrawContrast, result: Result, answer: Answer, refuse: Refuse
    ) -> None:
        """Run a task about one model before all pictures."""
        self._artists.submit(task, partial(answer_outcome, answer, refuse, result), first=True)
