"""Learning of a session, and choice of models, in a worker process."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial

from grammarlab.errors import UsageError, shown
from grammarlab.pages.record.model_grids import PAIRS
from grammarlab.pages.scoring.display import SessionDisplay
from grammarlab.pages.scoring.knowledge import ModelPool
from grammarlab.pages.scoring.populate import LISTS, WAYS, fresh_samples, liked_models, next_scored, number_to_choose
from grammarlab.pages.workers.tasks import Choose, ModelChoice, Prepare, Progress, Update
from grammarlab.pages.workers.worker_pool import Report, TaskOutcome, WorkerPool

UNCHANGED_MODELS = (
    "The predictions are updated. The models stay, since you continued meanwhile; use New models for others."
)
WIDER_POOL = "Liked models are rare, so from now on questions include many more unusual models."
NUM_BEHIND = 8
"""New scores from which on they are learned from while the person goes on."""
_UNLEARNED = ("default", "grammar", "density", "uncertainty", PAIRS)
"""Strategies that show samples of the grammar until something has been learned."""


class Learning:
    """Updates and choices of models. All methods and callbacks are for one thread."""

    def __init__(
        self, display: SessionDisplay, learners: WorkerPool, announce: Callable[[str, int, int], None]
    ) -> None:
        """Start with the record of a session.

        Args:
            display: the scores and the shown models.
            learners: pool of one process that learns.
            announce: sends progress to all windows.
        """
        self.updating: Progress | None = None
        self._display, self._learners, self._announce = display, learners, announce
        self._is_prepared, self._is_resumed = False, bool(display.record.num_labels)
        self._ticket = self._choosing = 0
        self._behind_revision = 0
        """`Record.label_revision` of the scores that were learned from last while the person went on."""
        self._is_behind = False
        """Whether new scores are being learned from while the person goes on."""

    def populate(self, way: str) -> None:
        """Show other models, at once or after they have been chosen; of two requests the later one is used.

        Raises:
            UsageError: If the strategy is unknown.
        """
        if way not in WAYS:
            raise UsageError(f"way: expected one of {', '.join(WAYS)}, found {shown(way)}.")
        display = self._display
        display.message = None
        if self._choosing:
            self._learners.cancel(self._choosing)
        if way in LISTS:
            display.show(way, self._listed(way))
            return
        number = display.record.numbers[display.record.active] if way == PAIRS else display.number
        if way == "grammar" or (way in _UNLEARNED and display.knowledge.predictions_of(number) is None):
            display.show(way, fresh_samples(display.pool, display.record, number_to_choose(way, display.record.layout)))
            return
        self.prepare()
        choice = self._choice(way)
        if self.updating is None:
            self._progress("choosing models", 0, 1)
        done = partial(self._take_choice, choice, display.record.num_shown)
        self._choosing = self._learners.submit(Choose(display.factors, display.record.numbers, choice), done)

    def update(self) -> None:
        """Learn from all scores, then show other models.

        Raises:
            UsageError: If there are no scores, or an update is running.
        """
        if self._ticket:
            raise UsageError("an update is under way; wait for it, or cancel it.")
        if not self._display.record.num_labels:
            raise UsageError("there are no scores to learn from; score some models first.")
        self._display.message = None
        self.prepare()
        self._learn(self._choice(self._display.record.way))

    def cancel(self) -> None:
        """Cancel an update."""
        if self._ticket:
            self._learners.cancel(self._ticket)

    def prepare(self) -> None:
        """Start counting features, and learning from existing scores, unless it was done."""
        if not self._is_prepared:
            self._is_prepared = True
            self._learners.submit(Prepare(), self._take_features, on_progress=self._progress)
            if self._is_resumed:
                self._learn(None)

    def learn_behind(self) -> None:
        """Learn from new scores if there are enough, without new models: they stay, and nobody waits."""
        record, knowledge = self._display.record, self._display.knowledge
        is_free = self._is_prepared and knowledge.features is not None and self.updating is None
        num_new = record.label_revision - max(knowledge.label_revision, self._behind_revision)
        if not is_free or self._is_behind or not record.num_labels or num_new < NUM_BEHIND:
            return
        self._is_behind, self._behind_revision = True, record.label_revision
        self._submit(self._update_of(None))

    def close(self) -> None:
        """End the process."""
        self._learners.close()

    def _learn(self, choice: ModelChoice | None) -> None:
        self._progress("waiting", 0, 1)
        ticket = self._submit(self._update_of(choice), self._progress)
        if choice is not None:
            self._ticket = ticket

    def _update_of(self, choice: ModelChoice | None) -> Update:
        record, features = self._display.record, self._display.knowledge.features
        version = 0 if features is None else features.version
        return Update(self._display.factors, record.numbers, choice, version, record.wide)

    def _submit(self, update: Update, on_progress: Report | None = None) -> int:
        record = self._display.record
        done = partial(self._take_update, update, (record.num_shown, record.label_revision))
        return self._learners.submit(update, done, on_progress=on_progress)

    def _take_update(self, update: Update, revision: tuple[int, int], outcome: TaskOutcome) -> None:
        choice, display = update.choice, self._display
        is_behind, self._is_behind = choice is None and self._is_behind, False
        if choice is not None:
            self._ticket = 0
        if is_behind:
            display.notify()
        else:
            self._progress_ended()
        if outcome.value is None:
            display.message = outcome.error or "The update was cancelled; predictions are as they were."
            return
        learned = outcome.value
        if learned.wide != display.pool.pool.wide:
            display.pool = ModelPool(display.store.about.seed, display.store.about.size, learned.wide)
        display.knowledge.take(learned, revision[1], update.numbers)
        # The wider pool may have been widened by this update.
        self._learners.recall = replace(update, choice=None, wide=learned.wide)
        widened = (WIDER_POOL,) if choice is not None and learned.wide and not display.record.wide else ()
        display.message = " ".join((*learned.left_out, *widened)) or (display.message if is_behind else None)
        if choice is not None:
            # Recorded before models of a wider pool are shown, so that a killed session has it.
            labels = sum(map(len, display.factors.values()))
            display.note("learned", {"labels": labels, "js": learned.js} | ({"wide": True} if learned.wide else {}))
        if choice is not None and learned.chosen is not None:
            if revision == (display.record.num_shown, display.record.label_revision):
                display.show(choice.way, learned.chosen)
            else:
                display.message = " ".join((UNCHANGED_MODELS, *widened))

    def _take_features(self, outcome: TaskOutcome) -> None:
        self._display.knowledge.features = outcome.value
        self._progress_ended()
        if outcome.error:
            self._display.message = outcome.error

    def _take_choice(self, choice: ModelChoice, num_shown: int, outcome: TaskOutcome) -> None:
        self._choosing = 0
        self._progress_ended()
        if outcome.value is None:
            self._display.message = outcome.error or None
        elif self._display.record.num_shown == num_shown:
            self._display.show(choice.way, outcome.value)

    def _listed(self, way: str) -> list[str]:
        display = self._display
        predicted, num = display.knowledge.predictions_of(display.number), display.record.layout.models
        if way == "scored":
            return next_scored(display.record, display.factor, num)
        if predicted is None:
            raise UsageError(
                "nothing has been learned yet, so nothing is predicted to be liked; score some models first."
            )
        return liked_models(display.pool, display.record, predicted.mean, num, display.seed)

    def _progress(self, stage: str, done: int, total: int) -> None:
        self.updating = Progress(stage, done, total)
        self._announce(stage, done, total)

    def _progress_ended(self) -> None:
        self._display.notify()
        if not self._ticket:
            self.updating = None

    def _choice(self, way: str) -> ModelChoice:
        display = self._display
        # The product has no comparisons.
        factor = display.record.active if way == PAIRS else display.factor
        way = "default" if way in LISTS else way
        return ModelChoice(way, factor, number_to_choose(way, display.record.layout), display.seed)
