"""Learning of a session, and choice of models, in a worker process."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial

from grammarlab.errors import UsageError
from grammarlab.learning.designs.addresses import shown
from grammarlab.pages.record.model_grids import PAIRS
from grammarlab.pages.scoring.desk import SessionDesk
from grammarlab.pages.scoring.knowledge import ModelPool
from grammarlab.pages.scoring.populate import WAYS, fresh_samples, number_to_choose
from grammarlab.pages.workers.tasks import Choose, ModelChoice, Prepare, Progress, Update
from grammarlab.pages.workers.worker_pool import TaskOutcome, WorkerPool

STAYED = "The predictions are updated. The models stay, since you continued meanwhile; use Populate for others."
WIDENED = "Liked models are rare, so from now on questions include many more unusual models."
_UNLEARNED = ("default", "grammar", "density", "uncertainty", PAIRS)
"""Strategies that show samples of the grammar until something has been learned."""


class Learning:
    """Updates and choices of models. All methods and callbacks are for one thread."""

    def __init__(self, desk: SessionDesk, learners: WorkerPool, announce: Callable[[str, int, int], None]) -> None:
        """Start for a desk.

        Args:
            desk: the scores and the shown models.
            learners: pool of one process that learns.
            announce: sends progress to all windows.
        """
        self.updating: Progress | None = None
        self._desk, self._learners, self._announce = desk, learners, announce
        self._is_prepared, self._is_resumed = False, bool(desk.record.num_labels)
        self._ticket = self._choosing = 0

    def populate(self, way: str) -> None:
        """Show other models, at once or after they have been chosen; of two requests the later one is used.

        Raises:
            UsageError: If the strategy is unknown.
        """
        if way not in WAYS:
            raise UsageError(f"way: expected one of {', '.join(WAYS)}, found {shown(way)}.")
        desk = self._desk
        desk.message = None
        if self._choosing:
            self._learners.cancel(self._choosing)
        number = desk.record.numbers[desk.record.active] if way == PAIRS else desk.number
        if way == "grammar" or (way in _UNLEARNED and desk.knowledge.of(number) is None):
            desk.show(way, fresh_samples(desk.pool, desk.record, number_to_choose(way, desk.record.layout)))
            return
        self.prepare()
        choice = self._choice(way)
        if self.updating is None:
            self._progress("choosing models", 0, 1)
        done = partial(self._chosen, choice, desk.record.num_shown)
        self._choosing = self._learners.submit(Choose(desk.factors, desk.record.numbers, choice), done)

    def update(self) -> None:
        """Learn from all scores, then show other models.

        Raises:
            UsageError: If there are no scores, or an update is running.
        """
        if self._ticket:
            raise UsageError("an update is under way; wait for it, or cancel it.")
        if not self._desk.record.num_labels:
            raise UsageError("there are no scores to learn from; score some models first.")
        self._desk.message = None
        self.prepare()
        self._learn(self._choice(self._desk.record.way))

    def cancel(self) -> None:
        """Cancel an update."""
        if self._ticket:
            self._learners.cancel(self._ticket)

    def prepare(self) -> None:
        """Start counting features, and learning from existing scores, unless it was done."""
        if not self._is_prepared:
            self._is_prepared = True
            self._learners.submit(Prepare(), self._prepared, on_progress=self._progress)
            if self._is_resumed:
                self._learn(None)

    def close(self) -> None:
        """End the process."""
        self._learners.close()

    def _learn(self, choice: ModelChoice | None) -> None:
        record, features = self._desk.record, self._desk.knowledge.features
        known = 0 if features is None else features.version
        self._progress("waiting", 0, 1)
        update = Update(self._desk.factors, record.numbers, choice, known, record.wide)
        done = partial(self._learned, update, (record.num_shown, record.judgements))
        ticket = self._learners.submit(update, done, on_progress=self._progress)
        if choice is not None:
            self._ticket = ticket

    def _learned(self, update: Update, revision: tuple[int, int], outcome: TaskOutcome) -> None:
        choice, desk = update.choice, self._desk
        if choice is not None:
            self._ticket = 0
        self._progress_ended()
        if outcome.value is None:
            desk.message = outcome.error or "The update was cancelled; predictions are as they were."
            return
        found = outcome.value
        if found.wide != desk.pool.pool.wide:
            desk.pool = ModelPool(desk.store.about.seed, desk.store.about.size, found.wide)
        desk.knowledge.take(found, revision[1], update.numbers)
        # The wider pool may have been widened by this update.
        self._learners.recall = replace(update, choice=None, wide=found.wide)
        widened = (WIDENED,) if choice is not None and found.wide and not desk.record.wide else ()
        desk.message = " ".join((*found.left_out, *widened)) or None
        if choice is not None:
            # Recorded before models of a wider pool are shown, so that a killed session has it.
            labels = sum(map(len, desk.factors.values()))
            desk.note("learned", {"labels": labels, "js": found.js} | ({"wide": True} if found.wide else {}))
        if choice is not None and found.chosen is not None:
            if revision == (desk.record.num_shown, desk.record.judgements):
                desk.show(choice.way, found.chosen)
            else:
                desk.message = " ".join((STAYED, *widened))

    def _prepared(self, outcome: TaskOutcome) -> None:
        self._desk.knowledge.features = outcome.value
        self._progress_ended()
        if outcome.error:
            self._desk.message = outcome.error

    def _chosen(self, choice: ModelChoice, num_shown: int, outcome: TaskOutcome) -> None:
        self._choosing = 0
        self._progress_ended()
        if outcome.value is None:
            self._desk.message = outcome.error or None
        elif self._desk.record.num_shown == num_shown:
            self._desk.show(choice.way, outcome.value)

    def _progress(self, stage: str, done: int, total: int) -> None:
        self.updating = Progress(stage, done, total)
        self._announce(stage, done, total)

    def _progress_ended(self) -> None:
        self._desk.is_changed = True
        if not self._ticket:
            self.updating = None

    def _choice(self, way: str) -> ModelChoice:
        desk = self._desk
        # The product has no comparisons.
        factor = desk.record.active if way == PAIRS else desk.factor
        return ModelChoice(way, factor, number_to_choose(way, desk.record.layout), desk.seed)
