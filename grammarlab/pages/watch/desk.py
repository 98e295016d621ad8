"""State of the page of a rule file: the model as the file is now, its controls and mistakes."""

from __future__ import annotations

import secrets
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, replace
from functools import partial
from pathlib import Path
from typing import Any

from grammarlab.errors import UsageError
from grammarlab.pages.desk import AbstractDesk, History
from grammarlab.pages.watch.controls import Control
from grammarlab.pages.watch.watch_tasks import DrawPicture, MadeModel, MakeModel, Mistake, Wanted
from grammarlab.pages.windows import PROTOCOL, Answer, Message, Refuse
from grammarlab.pages.workers.tasks import FindPart
from grammarlab.pages.workers.worker_pool import TaskOutcome, WorkerPool
from grammarlab.runs.sample.shipped import RuleSource

SHEET = 16
"""Models on the sheet."""
_PICTURE = 220
"""Pixels along each side of their pictures."""
_MAX_FILES = 200
"""Largest number of rule files beside the watched one whose changes are noticed."""
_SEEDS = 1 << 32
"""Seeds of the dice, which one can still read and type."""
Tell = Callable[[Message, Sequence[bytes]], None]


class WatchDesk(AbstractDesk):
    """A rule file that another program edits, and what is wanted of it. Nothing is saved here."""

    formats = ()

    def __init__(self, source: RuleSource, bench: WorkerPool, artist: WorkerPool, tell: Tell) -> None:
        """Starts with the first model.

        Args:
            source: the rule file.
            bench: pool of one process that makes the model.
            artist: pool of one process that draws the sheet.
            tell: sends a message to all windows.
        """
        self.target, self._source = source.path, source
        self._bench, self._artist, self._tell = bench, artist, tell
        self._history = History(Wanted())
        self._stamp = self._stamp_now()
        self._ticket, self._sheet_version = 0, 0
        self.glb, self.version = b"", 0
        """The model as a GLB file, and the number of its making; the last good one while there are mistakes."""
        self.tree: tuple[list[Any], ...] = ()
        """Rows of its derivation tree."""
        self._shapes = 0
        self._controls: tuple[Control, ...] = ()
        self._mistakes: tuple[Mistake, ...] = ()
        self._make()

    @property
    def is_saved(self) -> bool:
        """True, since the file is edited elsewhere."""
        return True

    @property
    def is_lost(self) -> bool:
        """False, since the file is edited elsewhere."""
        return False

    @property
    def wanted(self) -> Wanted:
        """What is to be seen."""
        return self._history.present

    def undo(self) -> Message:
        """Show what was wanted before."""
        return self._after(self._history.undo())

    def redo(self) -> Message:
        """Show what was undone."""
        return self._after(self._history.redo())

    def save(self) -> Message:
        """Nothing has to be saved."""
        return {"revision": self.revision}

    def export(self, form: str, answer: Answer, refuse: Refuse) -> None:
        """Refuse: ``grammarlab sample`` writes models."""
        raise UsageError("This page has no exports; grammarlab sample writes models.")

    def rescue(self) -> Path:
        """The rule file."""
        return self.target

    def want(self, seed: int, model: int) -> None:
        """Show another model."""
        self._do("model", replace(self.wanted, seed=seed, model=model))

    def roll(self) -> None:
        """Show the same model of a seed by chance."""
        self._do("seed", replace(self.wanted, seed=secrets.randbelow(_SEEDS)))

    def set_attribute(self, name: str, value: str | None) -> None:
        """Set an attribute, or with None leave it to the file.

        Raises:
            UsageError: If there is no such attribute.
        """
        if name not in {control.name for control in self._controls}:
            raise UsageError(f"the rules have no attribute {name!r}.")
        values = {**dict(self.wanted.attributes), name: value}
        kept = tuple((name, value) for name, value in values.items() if value is not None)
        self._do(f"value of {name}", replace(self.wanted, attributes=kept))

    def draw_sheet(self) -> None:
        """Draw the first models of the seed with these values; windows hear of each picture."""
        self._sheet_version += 1
        version = self._sheet_version
        for model in range(SHEET):
            task = DrawPicture(replace(self.wanted, model=model), _PICTURE)
            done = partial(self._take_picture, version, model)
            self._artist.submit(task, done, is_wanted=lambda: version == self._sheet_version)

    def find_part(self, values: Mapping[str, int], answer: Answer, refuse: Refuse) -> None:
        """Answer with the rule of a part of the model, by its number or by one of its triangles."""
        kind = "triangle" if "triangle" in values else "part"

        def done(outcome: TaskOutcome) -> None:
            if outcome.value is None:
                refuse(outcome.error or "cancelled.")
            else:
                answer(asdict(outcome.value), ())

        self._bench.submit(FindPart("", values[kind], kind == "triangle"), done)

    def poll(self) -> None:
        """Make the model again once the file, or one beside it, has changed."""
        stamp = self._stamp_now()
        if stamp != self._stamp:
            self._stamp = stamp
            self._make()

    def state(self) -> Message:
        """The whole state of the page."""
        return {
            "protocol": PROTOCOL,
            "title": self._source.file,
            "file": str(self.target),
            "seed": self.wanted.seed,
            "model": self.wanted.model,
            "values": dict(self.wanted.attributes),
            "controls": [asdict(control) for control in self._controls],
            "mistakes": [asdict(mistake) for mistake in self._mistakes],
            "version": self.version,
            "shapes": self._shapes,
            "busy": bool(self._ticket),
            "undo": self._history.past[-1][0] if self._history.past else "",
            "redo": self._history.future[-1][0] if self._history.future else "",
        }

    def close(self) -> None:
        """End the processes."""
        self._bench.close()
        self._artist.close()

    def _do(self, words: str, wanted: Wanted) -> None:
        if wanted == self.wanted:
            return
        self._history.do(words, wanted, joins=True)
        self._make()

    def _after(self, words: str) -> Message:
        if words:
            self._make()
        return {"words": words}

    def _make(self) -> None:
        if self._ticket:
            self._bench.cancel(self._ticket)
        self._ticket = self._bench.submit(MakeModel(self.wanted), self._take_model)
        self.notify()

    def _take_model(self, outcome: TaskOutcome) -> None:
        if outcome.cancelled:
            return
        self._ticket = 0
        self.notify()
        if outcome.value is None:
            self._mistakes = (Mistake("error", outcome.error),)
            return
        made: MadeModel = outcome.value
        self._mistakes = made.mistakes
        if made.controls is not None:
            self._controls = made.controls
        if made.glb:
            self.glb, self.tree, self._shapes, self.version = made.glb, made.tree, made.shapes, self.version + 1

    def _take_picture(self, version: int, model: int, outcome: TaskOutcome) -> None:
        if version == self._sheet_version and outcome.value is not None:
            self._tell({"event": "picture", "model": model}, [outcome.value])

    def _stamp_now(self) -> tuple[tuple[str, int, int], ...]:
        """Names, times and sizes of the rule files in the folder, since the file may import them."""
        found: list[tuple[str, int, int]] = []
        for path in [self.target, *sorted(self.target.parent.glob("*.cga"))[:_MAX_FILES]]:
            try:
                status = path.stat()
            except OSError:  # an editor may replace the file just now
                continue
            found.append((path.name, status.st_mtime_ns, status.st_size))
        return tuple(found)
