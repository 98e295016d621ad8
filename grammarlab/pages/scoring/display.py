"""State and display of a session, for one thread."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from grammarlab.errors import Finding, GrammarlabError, UsageError
from grammarlab.pages.record.events import Record
from grammarlab.pages.record.model_grids import MAX_GRID, PAIRS, Body, ModelGrid
from grammarlab.pages.record.store import Store
from grammarlab.pages.scoring.knowledge import Knowledge, ModelPool
from grammarlab.pages.scoring.next_models import NextModels, extended, laid_out, liked_models, mixed
from grammarlab.pages.scoring.sorting import Order, sorted_grids
from grammarlab.pages.workers.tasks import Factors
from grammarlab.randomness import derived_seed

MAX_WARNINGS = 20
"""Largest number of warnings, since rules may request any number of assets."""
_CHOICE_LANE = 3
"""Lane of the seed of a session for the seeds of choices of models."""


class SessionDisplay:
    """Record of a session, knowledge about its models, and messages. All methods are for one thread."""

    def __init__(self, store: Store, notify: Callable[[], None], phrase: Callable[[str], str] = str) -> None:
        """Start with an open session file.

        Args:
            store: the open session file.
            notify: called after each change.
            phrase: says warnings and messages in the words of those who read the page.
        """
        self.store, self.notify, self._phrase = store, notify, phrase
        about = store.about
        self.pool = ModelPool(about.seed, about.size, self.record.wide)
        self.knowledge = Knowledge()
        self.message: str | None = None
        self.warnings: dict[str, str] = {}
        """Warnings by text, each with its place in the rules and a hint."""

    @property
    def record(self) -> Record:
        """Record so far."""
        return self.store.record

    @property
    def factor(self) -> str:
        """The active factor, or the product, whose name is empty."""
        return "" if self.record.view == "product" else self.record.active

    @property
    def number(self) -> int:
        """The number of that factor; 0 for the product."""
        return self.record.numbers[self.factor] if self.factor else 0

    @property
    def factors(self) -> Factors:
        """Labels by factor."""
        return {name: dict(scores) for name, scores in self.record.factors.items()}

    @property
    def seed(self) -> int:
        """Seed for the next choice of models."""
        return derived_seed(self.store.about.seed, _CHOICE_LANE, self.record.num_shown)

    def do(self, kind: str, body: Body | Callable[[Record], Body]) -> int:
        """Add an event, and return its number; see `Store.append`.

        Raises:
            UsageError: If it is not possible now.
            AssetError: If it cannot be written.
        """
        self.message = None
        self.notify()
        return self.store.append(kind, body).number

    def label(self, kind: str, label: Body, factor: object, key: str) -> int:
        """Score or compare models, and return the number of the event.

        Args:
            kind: kind of the event, ``score`` or ``compare``.
            label: the other values of its body.
            factor: name or number of its factor; empty for the active one.
            key: unique name of this request; a repeated one has no effect.

        Raises:
            UsageError: If it is not possible, such as without a factor while the product is shown.
        """
        if key and key in self.record.keys:
            return self.record.revision

        def body(record: Record) -> Body:
            if factor == "" and record.view == "product":
                raise UsageError(
                    "the product of all factors is shown, which has no scores of its own; choose a factor."
                )
            name = record.active if factor == "" else record.name_of(factor)
            return {"factor": name, **label} | ({"key": key} if key else {})

        return self.do(kind, body)

    def poll(self) -> None:
        """Read events of other processes; an error becomes the message."""
        try:
            if self.store.poll():
                self.notify()
        except GrammarlabError as error:
            if self.message != str(error):
                self.tell(str(error))

    def sort(self, order: Order) -> None:
        """Sort the shown models.

        Raises:
            UsageError: If it is not possible, with the reason.
        """
        if self.record.way == PAIRS:
            raise UsageError("pairs are shown one after the other; choose another way to show models, and sort those.")
        self.arrange(sorted_grids(order, self.record, self.knowledge, self.pool, self.factor, self.seed))

    @property
    def is_full(self) -> bool:
        """Whether no more models fit below those that are shown."""
        most, layout = max((len(grid.models) for grid in self.record.grids), default=0), self.record.layout
        return most + layout.rows * layout.columns > MAX_GRID

    def show(self, way: str, following: NextModels) -> None:
        """Show other models, if there are any."""
        self._show(way, self.grids_of(way, following), "There are no models to show in this way.")

    def extend(self, way: str, following: NextModels) -> None:
        """Show further models below those that are shown, if there are any."""
        shown = self.record.grids
        grids = extended(shown, self.grids_of(way, following, self.record.shown_now))
        self._show(way, grids if grids != list(shown) else (), "These are all models of this kind.")

    def grids_of(self, way: str, following: NextModels, without: Sequence[str] = ()) -> list[ModelGrid]:
        """Grids of the next models, and of those that are predicted to be liked if both are shown.

        Args:
            way: strategy of the next models.
            following: the next models.
            without: models that are not shown as liked ones.
        """
        layout, predicted = self.record.layout, self.knowledge.predictions_of(self.number)
        liked: list[str] = []
        if way == "default" and predicted is not None:
            liked = liked_models(self.pool, self.record, predicted.mean, layout.models // 2, self.seed, without)
        if liked:
            return mixed(liked, following, layout)
        return laid_out(way, following.models, layout)

    def _show(self, way: str, grids: Sequence[ModelGrid], otherwise: str) -> None:
        if any(grid.models for grid in grids):
            self.arrange(grids, way)
        else:
            self.tell(otherwise)

    def arrange(self, grids: Sequence[ModelGrid], way: str = "") -> None:
        """Show models in grids, chosen by a strategy; by default the previous one."""
        self.note("shown", {"way": way or self.record.way, "grids": [grid.as_json() for grid in grids]})

    def note(self, kind: str, body: Body) -> None:
        """Add an event without clearing the message."""
        try:
            self.store.append(kind, body)
        except GrammarlabError as error:
            self.message = str(error)
        self.notify()

    def tell(self, message: str | None) -> None:
        """Show a message until the next event; None clears it."""
        self.message = message
        self.notify()

    @property
    def said(self) -> str | None:
        """The message, in the words of those who read the page."""
        return None if self.message is None else self._phrase(self.message)

    def warn(self, findings: Sequence[Finding]) -> None:
        """Add warnings about shown models; each is shown once."""
        for finding in findings:
            if finding.message not in self.warnings and len(self.warnings) < MAX_WARNINGS:
                self.warnings[finding.message] = self._phrase(finding.render(()))
                self.notify()
