"""Scoring rounds: all actions of a session, for one thread."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path

from grammarlab.pages.desktop import Answer, Message, Refuse
from grammarlab.pages.record.model_grids import PAIRS, Body, ModelGrid
from grammarlab.pages.record.store import Store
from grammarlab.pages.scoring.desk import SessionDesk
from grammarlab.pages.scoring.learning import Learning
from grammarlab.pages.scoring.populate import fresh_samples
from grammarlab.pages.scoring.session_files import Result, SessionFiles, answered
from grammarlab.pages.workers.tasks import FindPart, MakeGlb
from grammarlab.pages.workers.thumbnails import Thumbnails
from grammarlab.pages.workers.worker_pool import WorkerPool

_HERE = "grammarlab.pages.workers"
_LAST = 5
"""Priority of drawing over long tasks."""


class Rounds:
    """A running session. All methods and callbacks are for one thread."""

    def __init__(
        self, path: Path, store: Store, assets: Path, artists: WorkerPool, tell: Callable[[Message], None]
    ) -> None:
        """Start on an open session.

        Args:
            path: the session file.
            store: the open session file.
            assets: folder of meshes and images.
            artists: pool of processes that draw.
            tell: sends a message to all windows.
        """
        self.path = path
        self.desk = desk = SessionDesk(store)
        about = store.about
        place, deliver = (about.suffix, about.grammar, about.title, str(assets)), artists.deliver
        models = about.seed, about.size, desk.record.wide
        learners = WorkerPool(
            make=f"{_HERE}.learner:learner", arguments=(*place, *models), size=1, deliver=deliver, politeness=_LAST
        )
        makers = WorkerPool(
            make=f"{_HERE}.maker:maker",
            arguments=(*place, str(path), about.seed, about.size),
            size=1,
            deliver=deliver,
            politeness=_LAST,
        )

        def announce(what: str, stage: str, done: int, total: int) -> None:
            tell({"event": "progress", "of": what, "stage": stage, "done": done, "total": total})

        self._artists = artists
        self.learning = Learning(desk, learners, partial(announce, "update"))
        self.files = SessionFiles(desk, path, makers, announce)
        self.thumbnails = Thumbnails(artists, desk.warn)
        if not desk.record.grids:
            desk.show("default", fresh_samples(desk.pool, desk.record, desk.record.layout.models))

    def close(self) -> None:
        """End all processes."""
        self.learning.close()
        self.files.close()
        self.desk.store.close()

    def layout(self, layout: Body) -> None:
        """Change the size of the grids, and fill them; pairs are not shown in grids, and do not change.

        Raises:
            UsageError: If it is out of range.
        """
        record = self.desk.record
        before = record.layout
        self.desk.do("layout", layout)
        record = self.desk.record
        after = record.layout
        if record.way == PAIRS:
            return
        if after.grids == before.grids and after.rows * after.columns <= before.rows * before.columns:
            size = after.rows * after.columns
            self.desk.arrange([ModelGrid(grid.title, grid.models[:size]) for grid in record.grids])
        else:
            self.learning.populate(record.way)

    def prepare_if_free(self) -> None:
        """Start learning after the first pictures."""
        if self.thumbnails.shows_something and not self.thumbnails.is_hurried:
            self.learning.prepare()

    def ask_artist(self, task: MakeGlb | FindPart, result: Result, answer: Answer, refuse: Refuse) -> None:
        """Run a task about one model before all pictures."""
        self._artists.submit(task, partial(answered, answer, refuse, result), first=True)
