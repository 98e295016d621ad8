"""Scoring rounds: everything that a session can do, for one thread."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

from grammarlab.errors import Finding, GrammarlabError, UsageError
from grammarlab.learning.designs.addresses import shown
from grammarlab.randomness import derived_seed
from grammarlab.runs.scoring.grids import PAIRS, Body, Grid
from grammarlab.runs.scoring.record.events import Record
from grammarlab.runs.scoring.record.store import Store
from grammarlab.runs.scoring.shown.knowledge import Knowledge, ModelPool
from grammarlab.runs.scoring.shown.populate import WAYS, fresh_samples, laid_out, number_to_choose
from grammarlab.runs.scoring.shown.sorting import Order, sorted_grids
from grammarlab.runs.scoring.workers.tasks import (
    Choice,
    Choose,
    DrawSheet,
    Factors,
    FindPart,
    LearnedFile,
    LearnGrammar,
    MakeGlb,
    Prepare,
    Progress,
    ReadLabels,
    Update,
    WriteLabels,
)
from grammarlab.runs.scoring.workers.thumbnails import Thumbnails
from grammarlab.runs.scoring.workers.worker_pool import Crew, Outcome
from grammarlab.runs.serving.windows import Answer, Message, Refuse

Result = Callable[[Any], tuple[Message, Sequence[bytes]]]
"""What an answer says of a value, with its buffers."""

_HERE = "grammarlab.runs.scoring.workers"
MAX_WARNINGS = 20
"""Warnings that are told: a rule that puts names together may ask for any number of assets."""
STAYED = "Predictions are new; the models stay, since you went on meanwhile. Populate for others."
WIDENED = "What you like is rare, so from now on it is looked for among many more unusual models."
_LAST = 5
"""How far pictures go before what takes long anyway."""
_SEEDS = 3
"""Place below the seed of a session that choices of models have their seeds from."""
_UNLEARNED = ("default", "grammar", "density", "uncertainty", PAIRS)
"""Ways that mean samples of the grammar as long as nothing has been learned."""


class Rounds:
    """A session at work. All methods are for one thread, on which callbacks run, too."""

    def __init__(
        self,
        path: Path,
        store: Store,
        assets: Path,
        artists: Crew,
        tell: Callable[[Message], None],
    ) -> None:
        """Begins to work on an open session.

        Args:
            path: the session file.
            store: the same, open.
            assets: folder of meshes and images.
            artists: what draws.
            tell: sends a message to all windows.
        """
        self.path, self.store = path, store
        about = store.about
        self.pool = ModelPool(about.seed, about.size, self.record.wide)
        self.knowledge = Knowledge()
        self.message: str | None = None
        self.warnings: dict[str, str] = {}
        """By what they say: the same with its place in the rules and what to try."""
        self.updating: Progress | None = None
        self.is_changed = False
        self._tell = tell
        place, deliver = (about.suffix, about.grammar, about.title, str(assets)), artists.deliver
        self._artists = artists
        models = about.seed, about.size, self.record.wide
        self._learners = Crew(f"{_HERE}.learner:learner", (*place, *models), 1, deliver, _LAST)
        self._makers = Crew(f"{_HERE}.maker:maker", (*place, str(path), about.seed, about.size), 1, deliver, _LAST)
        self.thumbnails = Thumbnails(self._artists, self._warn)
        self._is_prepared, self._is_resumed = False, bool(self.record.num_labels)
        self._ticket = self._choosing = 0
        if not self.record.grids:
            self._show("default", fresh_samples(self.pool, self.record, self.record.layout.models))

    @property
    def record(self) -> Record:
        """What was done so far."""
        return self.store.record

    @property
    def factor(self) -> str:
        """What is looked at: the active factor, or the product, whose name is empty."""
        return "" if self.record.view == "product" else self.record.active

    @property
    def number(self) -> int:
        """The number of that factor; 0 for the product."""
        return self.record.numbers[self.factor] if self.factor else 0

    def do(self, kind: str, body: Body | Callable[[Record], Body]) -> int:
        """Adds an event, and gives its number; see `Store.append`.

        Raises:
            UsageError: when it cannot happen now.
            AssetError: when it cannot be written.
        """
        self.message = None
        self.is_changed = True
        return self.store.append(kind, body).number

    def say(self, kind: str, said: Body, factor: object, key: str) -> int:
        """Scores models or compares them, and gives the number of the event.

        Args:
            kind: of the event, ``score`` or ``compare``.
            said: the rest of its body.
            factor: name or number of the factor that it is about; empty for the active one.
            key: a name for this act; if it is known, nothing is done again.

        Raises:
            UsageError: when it cannot be done, such as without a factor while the product is looked at.
        """
        if key and key in self.record.keys:
            return self.record.revision

        def body(record: Record) -> Body:
            if factor == "" and record.view == "product":
                raise UsageError(
                    "the product of all factors is shown, which has no scores of its own; choose a factor."
                )
            given = record.active if factor == "" else record.name_of(factor)
            return {"factor": given, **said} | ({"key": key} if key else {})

        return self.do(kind, body)

    def poll(self) -> None:
        """Takes in what other processes did."""
        self.is_changed |= self.store.poll()

    def close(self) -> None:
        """Ends everything."""
        for crew in (self._learners, self._makers):
            crew.close()
        self.store.close()

    def layout(self, layout: Body) -> None:
        """Changes the size of the grids, and fills them; pairs are not shown in grids, and stay.

        Raises:
            UsageError: when it is out of range.
        """
        before = self.record.layout
        self.do("layout", layout)
        after = self.record.layout
        if self.record.way == PAIRS:
            return
        if after.grids == before.grids and after.rows * after.columns <= before.rows * before.columns:
            size = after.rows * after.columns
            self._arrange([Grid(grid.title, grid.models[:size]) for grid in self.record.grids])
        else:
            self.populate(self.record.way)

    def populate(self, way: str) -> None:
        """Shows other models, at once or when they have been chosen; of two wishes the later one counts.

        Raises:
            UsageError: for an unknown way.
        """
        if way not in WAYS:
            raise UsageError(f"way: expected one of {', '.join(WAYS)}, found {shown(way)}.")
        self.message = None
        if self._choosing:
            self._learners.cancel(self._choosing)
        number = self.record.numbers[self.record.active] if way == PAIRS else self.number
        if way == "grammar" or (way in _UNLEARNED and self.knowledge.of(number) is None):
            self._show(way, fresh_samples(self.pool, self.record, number_to_choose(way, self.record.layout)))
            return
        self.prepare()
        choice = self._choice(way)
        if self.updating is None:
            self._progress("choosing models", 0, 1)
        done = partial(self._chosen, choice, self.record.num_shown)
        self._choosing = self._learners.submit(Choose(self._factors(), self.record.numbers, choice), done)

    def sort(self, order: Order) -> None:
        """Sorts the models that are shown.

        Raises:
            UsageError: when it cannot be done; says why.
        """
        if self.record.way == PAIRS:
            raise UsageError("pairs are shown one after the other; choose another way to show models, and sort those.")
        seed = derived_seed(self.store.about.seed, _SEEDS, self.record.num_shown)
        self._arrange(sorted_grids(order, self.record, self.knowledge, self.pool, self.factor, seed))

    def update(self) -> None:
        """Learns from all scores, then shows other models.

        Raises:
            UsageError: when there is nothing to learn from, or it is being done.
        """
        if self._ticket:
            raise UsageError("an update is under way; wait for it, or cancel it.")
        if not self.record.num_labels:
            raise UsageError("there are no scores to learn from; score some models first.")
        self.message = None
        self.prepare()
        self._learn(self._choice(self.record.way))

    def cancel(self) -> None:
        """Leaves an update unfinished."""
        if self._ticket:
            self._learners.cancel(self._ticket)

    def prepare(self) -> None:
        """Begins to count features, and to learn from the scores that there are, unless it was done."""
        if not self._is_prepared:
            self._is_prepared = True
            self._learners.submit(Prepare(), self._prepared, on_progress=self._progress)
            if self._is_resumed:
                self._learn(None)

    def prepare_if_free(self) -> None:
        """The same, once the first pictures are there."""
        if self.thumbnails.shows_something and not self.thumbnails.is_hurried:
            self.prepare()

    def ask_artist(self, task: MakeGlb | FindPart, result: Result, answer: Answer, refuse: Refuse) -> None:
        """Has a task about one model done before all pictures."""
        self._artists.submit(task, partial(_answered, answer, refuse, result), first=True)

    def export(self, suffix: str, answer: Answer, refuse: Refuse) -> None:
        """Makes all scores a label file."""
        file = f"{self.path.stem}{suffix}"
        done = partial(_answered, answer, refuse, lambda content: ({"file": file}, [content]))
        self._makers.submit(WriteLabels(self._factors(), suffix), done)

    def read(self, content: bytes, suffix: str, answer: Answer, refuse: Refuse) -> None:
        """Adds the scores of a label file; all of them can be undone at once."""

        def add(outcome: Outcome) -> None:
            try:
                if outcome.value is None:
                    raise UsageError(outcome.error)
                entries = {
                    name: {subject: said.as_json() for subject, said in scores.items()}
                    for name, scores in outcome.value.items()
                }
                self.do("import", {"scores": entries})
                answer({"added": sum(map(len, outcome.value.values()))}, ())
            except GrammarlabError as error:
                refuse(str(error))

        self._makers.submit(ReadLabels(content, suffix), add)

    def learn_grammar(self, answer: Answer, refuse: Refuse) -> None:
        """Learns a grammar from all scores, into a file beside the session."""

        def result(found: LearnedFile) -> tuple[Message, Sequence[bytes]]:
            numbers = {"js": found.js, "rules_before": found.rules_before, "rules_after": found.rules_after}
            return {"file": found.file, "text": found.text, "notes": list(found.findings), **numbers}, ()

        done = partial(_answered, answer, refuse, result)
        self._makers.submit(
            LearnGrammar(self._factors(), self.record.wide), done, on_progress=partial(self._announce, "learn")
        )

    def sheet(self, num: int, answer: Answer, refuse: Refuse) -> None:
        """Draws samples of the learned grammar."""
        file = f"{self.path.stem}-learned.png"
        done = partial(_answered, answer, refuse, lambda content: ({"file": file}, [content]))
        task = DrawSheet(num, self.store.about.seed)
        self._makers.submit(task, done, on_progress=partial(self._announce, "sheet"))

    def _warn(self, findings: Sequence[Finding]) -> None:
        """Takes in warnings about what is shown; each is told once."""
        for finding in findings:
            if finding.message not in self.warnings and len(self.warnings) < MAX_WARNINGS:
                self.warnings[finding.message] = finding.render(())
                self.is_changed = True

    def _learn(self, choice: Choice | None) -> None:
        factors, revision = self._factors(), (self.record.num_shown, self.record.judgements)
        features = self.knowledge.features
        known = 0 if features is None else features.version
        self._progress("waiting", 0, 1)
        numbers = self.record.numbers
        update = Update(factors, numbers, choice, known, self.record.wide)
        done = partial(self._learned, update, revision)
        ticket = self._learners.submit(update, done, on_progress=self._progress)
        if choice is not None:
            self._ticket = ticket

    def _learned(self, update: Update, revision: tuple[int, int], outcome: Outcome) -> None:
        choice = update.choice
        if choice is not None:
            self._ticket = 0
        self._progress_ended()
        if outcome.value is None:
            self.message = outcome.error or "The update was cancelled; predictions are as they were."
            return
        found = outcome.value
        if found.wide != self.pool.pool.wide:
            self.pool = ModelPool(self.store.about.seed, self.store.about.size, found.wide)
        self.knowledge.take(found, revision[1], update.numbers)
        # The wider pool may have been widened by this update.
        self._learners.recall = replace(update, choice=None, wide=found.wide)
        widened = (WIDENED,) if choice is not None and found.wide and not self.record.wide else ()
        self.message = " ".join((*found.left_out, *widened)) or None
        if choice is not None:
            # Before models of a wider pool are shown, so that a session that is killed in between knows of it.
            labels = sum(map(len, self._factors().values()))
            self._note("learned", {"labels": labels, "js": found.js} | ({"wide": True} if found.wide else {}))
        if choice is not None and found.chosen is not None:
            if revision == (self.record.num_shown, self.record.judgements):
                self._show(choice.way, found.chosen)
            else:
                self.message = " ".join((STAYED, *widened))

    def _prepared(self, outcome: Outcome) -> None:
        self.knowledge.features = outcome.value
        self._progress_ended()
        if outcome.error:
            self.message = outcome.error

    def _chosen(self, choice: Choice, num_shown: int, outcome: Outcome) -> None:
        self._choosing = 0
        self._progress_ended()
        if outcome.value is None:
            self.message = outcome.error or None
        elif self.record.num_shown == num_shown:
            self._show(choice.way, outcome.value)

    def _progress(self, stage: str, done: int, total: int) -> None:
        self.updating = Progress(stage, done, total)
        self._announce("update", stage, done, total)

    def _announce(self, what: str, stage: str, done: int, total: int) -> None:
        self._tell({"event": "progress", "of": what, "stage": stage, "done": done, "total": total})

    def _progress_ended(self) -> None:
        self.is_changed = True
        if not self._ticket:
            self.updating = None

    def _choice(self, way: str) -> Choice:
        seed = derived_seed(self.store.about.seed, _SEEDS, self.record.num_shown)
        # The product has no comparisons of its own.
        factor = self.record.active if way == PAIRS else self.factor
        return Choice(way, factor, number_to_choose(way, self.record.layout), seed)

    def _factors(self) -> Factors:
        return {name: dict(scores) for name, scores in self.record.factors.items()}

    def _show(self, way: str, models: Sequence[str]) -> None:
        grids = laid_out(way, models, self.record.layout)
        if not any(grid.models for grid in grids):
            self.message = "There are no models to show in this way."
            self.is_changed = True
            return
        self._arrange(grids, way)

    def _arrange(self, grids: Sequence[Grid], way: str = "") -> None:
        self._note("shown", {"way": way or self.record.way, "grids": [grid.as_json() for grid in grids]})

    def _note(self, kind: str, body: Body) -> None:
        """Adds an event that keeps the message."""
        try:
            self.store.append(kind, body)
        except GrammarlabError as error:
            self.message = str(error)
        self.is_changed = True


def _answered(
    answer: Answer,
    refuse: Refuse,
    result: Result,
    outcome: Outcome,
) -> None:
    if outcome.value is None:
        refuse(outcome.error or "cancelled.")
    else:
        answer(*result(outcome.value))
