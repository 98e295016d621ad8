"""Learning of a session, and choice of models, in a worker process."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from itertools import compress

from grammarlab.errors import UsageError, shown
from grammarlab.pages.record.model_grids import PAIRS
from grammarlab.pages.scoring.display import SessionDisplay
from grammarlab.pages.scoring.knowledge import ModelPool
from grammarlab.pages.scoring.next_models import (
    LISTS,
    WAYS,
    NextModels,
    fresh_samples,
    liked_models,
    next_scored,
    number_to_choose,
)
from grammarlab.pages.workers.tasks import Choose, LearnedUpdate, ModelChoice, Prepare, Progress, Update
from grammarlab.pages.workers.worker_pool import TaskOutcome, WorkerPool

UNCHANGED_MODELS = (
    "The predictions are updated. The models stay, since you continued meanwhile; New models shows those in line."
)
WIDER_POOL = "Liked models are rare, so from now on questions include many more unusual models."
NUM_BEHIND = 8
"""New scores from which on they are learned from while the person goes on."""
PAUSE_SECONDS = 3.0
"""Seconds without a new score after which fewer new ones are learned from as well."""
_UNLEARNED = ("default", "grammar", "density", "uncertainty", PAIRS)
"""Strategies that show samples of the grammar until something has been learned."""
_SAMPLED = ("grammar", PAIRS)
"""Those of them for which nothing else is chosen once there are no samples any more."""
_LINED = ("default", "uniform", "density", "uncertainty", PAIRS)
"""Strategies whose next models can be chosen before somebody wants them."""


_Show = Callable[[str, NextModels], None]
"""Shows models that a strategy chose."""


@dataclass(frozen=True, slots=True)
class _Line:
    """Models that were chosen behind the person, and are shown at once when new ones are wanted."""

    choice: ModelChoice
    models: tuple[str, ...]


class Learning:
    """Updates and choices of models, behind the person. All methods and callbacks are for one thread."""

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
        self._is_prepared = False
        self._ticket = self._choosing = 0
        self._behind = 0
        """Ticket of the fit, or of the choice of models, that nobody waits for; 0 for none."""
        self._line: _Line | None = None
        self._fit_labels = 0
        """Number of labels of the last update."""
        self._charted = 0
        """`LearnedUpdate.number` of the last update whose change is in the chart."""
        self._heard = -1, 0.0
        """`Record.label_revision` when new scores were looked for last, and when it became that, in seconds."""
        self._behind_revision = -1
        """`Record.label_revision` of the scores that were learned from last while the person went on."""

    def new_models(self, way: str) -> None:
        """Show other models, at once or after they have been chosen; of two requests the later one is used.

        Raises:
            UsageError: If the strategy is unknown.
        """
        if way not in WAYS:
            raise UsageError(f"way: expected one of {', '.join(WAYS)}, found {shown(way)}.")
        self._next_models(way, self._display.show)

    def more(self) -> None:
        """Show further models of the same strategy below those that are shown; they stay."""
        display = self._display
        if display.record.way == PAIRS or display.is_full:
            self.new_models(display.record.way)
        else:
            self._next_models(display.record.way, display.extend)

    def upcoming(self) -> list[str]:
        """Models that come next without a wait, in their order; none if they have to be chosen first."""
        display, way = self._display, self._display.record.way
        next_ones = None if way in LISTS else self._at_once(way)
        if next_ones is None:
            return []
        if way == PAIRS:
            return list(next_ones.models)
        return [model for grid in display.grids_of(way, next_ones) for model in grid.models]

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
        if self._behind_revision != self._display.record.label_revision:
            self._stop_behind()
        self._progress("waiting", 0, 1)
        self._ticket = self._submit(self._update_of(self._choice(self._display.record.way)), is_behind=False)

    def cancel(self) -> None:
        """Cancel an update."""
        if self._ticket:
            self._learners.cancel(self._ticket)
            # It may have begun behind the person, and is not begun again at once: the person did not want it now.
            self._stop_behind()
            self._behind_revision = self._display.record.label_revision
            if self._line is None:
                self._choose_behind(self._display.record.way)

    def prepare(self) -> None:
        """Start counting features, and learning from existing scores, unless it was done."""
        if not self._is_prepared:
            self._is_prepared = True
            self._learners.submit(Prepare(), self._take_features, on_progress=self._progress)
            if self._display.record.num_labels:
                self._fit_behind()

    def learn_behind(self) -> None:
        """Learn from new scores once there are enough, or the person pauses; nobody waits, and what is shown stays."""
        record, knowledge = self._display.record, self._display.knowledge
        now = time.monotonic()
        if self._heard[0] != record.label_revision:
            self._heard = record.label_revision, now
        is_free = self._is_prepared and knowledge.features is not None and not self._ticket and not self._behind
        num_new = record.label_revision - max(knowledge.label_revision, self._behind_revision)
        is_enough = num_new >= NUM_BEHIND or (num_new > 0 and now - self._heard[1] >= PAUSE_SECONDS)
        if is_free and record.num_labels and is_enough:
            self._fit_behind()

    def close(self) -> None:
        """End the process."""
        self._learners.close()

    def _next_models(self, way: str, show: _Show) -> None:
        self._display.message = None
        if self._choosing:
            self._learners.cancel(self._choosing)
        next_ones = self._at_once(way)
        if next_ones is not None:
            self._chart()
            show(way, next_ones)
            self._choose_behind(way)
            return
        self.prepare()
        self._stop_behind()
        choice = self._choice(way)
        if self.updating is None:
            self._progress("choosing models", 0, 1)
        done = partial(self._take_choice, show, choice, self._display.record.num_shown)
        self._choosing = self._submit_choice(choice, done)

    def _at_once(self, way: str) -> NextModels | None:
        """Models for a strategy that need not be chosen any more; None if there are none."""
        display = self._display
        if way in LISTS:
            return NextModels(self._listed(way))
        is_unlearned = self._is_unlearned(way)
        models = [] if is_unlearned else self._in_line(way)
        if way == "default" or is_unlearned:
            num = number_to_choose(way, display.record.layout) - len(models)
            samples = fresh_samples(display.pool, display.record, num, models) if num > 0 else ()
            if models or samples or way in _SAMPLED:
                return NextModels(models, samples)
        return NextModels(models) if models else None

    def _in_line(self, way: str) -> list[str]:
        """Models in line for a strategy that are still new."""
        choice, line = self._choice(way), self._line
        if line is None or (line.choice.way, line.choice.factor) != (choice.way, choice.factor):
            return []
        # After a change of the layout there may be fewer than the grids hold.
        return self._still_new(line) if way in ("default", PAIRS) or line.choice.num >= choice.num else []

    def _is_unlearned(self, way: str) -> bool:
        """Whether a strategy shows samples of the grammar."""
        display = self._display
        number = display.record.numbers[display.record.active] if way == PAIRS else display.number
        return way == "grammar" or (way in _UNLEARNED and display.knowledge.predictions_of(number) is None)

    def _still_new(self, line: _Line) -> list[str]:
        """Models in line that have not been scored or shown meanwhile; of pairs, those that are not shown as such.

        Liked and disliked ones leave a line together, so that its halves stay halves.
        """
        record = self._display.record
        if line.choice.way == PAIRS:
            shown = set(map(frozenset, zip(*(grid.models for grid in record.grids), strict=False)))
            pairs = zip(line.models[::2], line.models[1::2], strict=False)
            return [model for pair in pairs if record.way != PAIRS or frozenset(pair) not in shown for model in pair]
        now = {*record.shown_now, *record.labelled_models}
        if line.choice.way == "density":
            half = len(line.models) // 2
            is_new = [
                now.isdisjoint(both) for both in zip(line.models[:half], line.models[half : 2 * half], strict=True)
            ]
            return list(compress(line.models, 2 * is_new))
        return [model for model in line.models if model not in now]

    def _fit_behind(self) -> None:
        record = self._display.record
        self._behind_revision = record.label_revision
        self._behind = self._submit(self._update_of(self._choice(record.way)), is_behind=True)

    def _choose_behind(self, way: str) -> None:
        """Choose other models for the line, after those that were in it have been shown."""
        if self._line is not None and self._line.choice.way != way:
            # Else it would depend on how fast these are chosen whether those of another strategy come back.
            self._line = None
        if self._is_prepared and way in _LINED and not self._is_unlearned(way) and not self._behind:
            choice = self._choice(way)
            self._behind = self._submit_choice(choice, partial(self._take_line, choice))

    def _stop_behind(self) -> None:
        """End what nobody waits for, since somebody waits for something else; it begins again afterwards."""
        if self._behind:
            self._learners.cancel(self._behind)
            self._behind_revision = self._display.knowledge.label_revision

    def _chart(self) -> None:
        """Record the change by the last update, once models that it chose are shown."""
        display, record, learned = self._display, self._display.record, self._display.knowledge.learned
        if learned is None or self._charted == learned.number:
            return
        is_first, self._charted = not self._charted, learned.number
        if is_first and record.chart and record.chart[-1][0] == self._fit_labels and learned.wide == record.wide:
            # A session that goes on has learned the same again.
            return
        # Recorded before models of a wider pool are shown, so that a killed session has it.
        wide = {"wide": True} if learned.wide else {}
        display.note("learned", {"labels": self._fit_labels, "js": learned.js} | wide)

    def _update_of(self, choice: ModelChoice) -> Update:
        record, features = self._display.record, self._display.knowledge.features
        version = 0 if features is None else features.version
        return Update(self._display.factors, record.numbers, choice, version, record.wide, self._charted)

    def _submit(self, update: Update, *, is_behind: bool) -> int:
        record = self._display.record
        done = partial(self._take_update, update, (record.num_shown, record.label_revision), is_behind)
        return self._learners.submit(
            update, done, on_progress=self._progress_if_awaited if is_behind else self._progress
        )

    def _submit_choice(self, choice: ModelChoice, done: Callable[[TaskOutcome], None]) -> int:
        return self._learners.submit(Choose(self._display.factors, self._display.record.numbers, choice), done)

    def _take_update(self, update: Update, revision: tuple[int, int], is_behind: bool, outcome: TaskOutcome) -> None:
        display = self._display
        if is_behind:
            self._behind = 0
            display.notify()
        else:
            self._ticket = 0
            self._progress_ended()
        if outcome.value is None:
            if not (is_behind and outcome.cancelled):
                display.message = outcome.error or "The update was cancelled; predictions are as they were."
            return
        learned: LearnedUpdate = outcome.value
        before = display.knowledge.learned
        widened = (WIDER_POOL,) if learned.wide and not display.pool.pool.wide else ()
        if learned.wide != display.pool.pool.wide:
            display.pool = ModelPool(display.store.about.seed, display.store.about.size, learned.wide)
        display.knowledge.take(learned, revision[1], update.numbers)
        # The wider pool may have been widened by this update.
        self._learners.recall = replace(update, choice=None, wide=learned.wide)
        # What was said after an earlier fit is not said again, unless somebody waited for this one.
        old = before.left_out if is_behind and before else ()
        notes = (*(reason for reason in learned.left_out if reason not in old), *widened)
        display.message = " ".join(notes) or (display.message if is_behind else None)
        self._fit_labels = sum(map(len, update.factors.values()))
        if update.choice is None or learned.chosen is None:
            return
        self._line = _Line(update.choice, learned.chosen)
        if is_behind:
            if display.record.way == update.choice.way and len(self._still_new(self._line)) < len(learned.chosen):
                self._choose_behind(update.choice.way)
        else:
            self._chart()
            if revision == (display.record.num_shown, display.record.label_revision):
                display.show(update.choice.way, NextModels(learned.chosen))
                self._choose_behind(update.choice.way)
            else:
                display.message = " ".join((UNCHANGED_MODELS, *widened))

    def _take_features(self, outcome: TaskOutcome) -> None:
        self._display.knowledge.features = outcome.value
        self._progress_ended()
        if outcome.error:
            self._display.message = outcome.error

    def _take_choice(self, show: _Show, choice: ModelChoice, num_shown: int, outcome: TaskOutcome) -> None:
        self._choosing = 0
        self._progress_ended()
        if outcome.value is None:
            self._display.message = outcome.error or None
        elif self._display.record.num_shown == num_shown:
            self._chart()
            show(choice.way, NextModels(outcome.value))
            self._choose_behind(choice.way)

    def _take_line(self, choice: ModelChoice, outcome: TaskOutcome) -> None:
        self._behind = 0
        if outcome.value is not None:
            self._line = _Line(choice, outcome.value)
            self._display.notify()

    def _listed(self, way: str) -> list[str]:
        """Models of a list, as far as they fit."""
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

    def _progress_if_awaited(self, stage: str, done: int, total: int) -> None:
        """Progress of what is done behind a person, who may have begun to wait for it."""
        if self._ticket:
            self._progress(stage, done, total)

    def _progress_ended(self) -> None:
        self._display.notify()
        if not self._ticket:
            self.updating = None

    def _choice(self, way: str) -> ModelChoice:
        display = self._display
        # The product has no comparisons.
        factor = display.record.active if way == PAIRS else display.factor
        way = "default" if way in LISTS else way
        without = () if way == PAIRS else display.record.shown_now
        return ModelChoice(way, factor, number_to_choose(way, display.record.layout), display.seed, without)
