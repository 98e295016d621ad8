"""What a session keeps and shows, for one thread."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from grammarlab.errors import Finding, GrammarlabError, UsageError
from grammarlab.randomness import derived_seed
from grammarlab.scoring.grids import PAIRS, Body, ModelGrid
from grammarlab.scoring.record.events import Record
from grammarlab.scoring.record.store import Store
from grammarlab.scoring.shown.knowledge import Knowledge, ModelPool
from grammarlab.scoring.shown.populate import laid_out
from grammarlab.scoring.shown.sorting import Order, sorted_grids
from grammarlab.scoring.workers.tasks import Factors

MAX_WARNINGS = 20
"""Warnings that are told: a rule that puts names together may ask for any number of assets."""
_SEEDS = 3
"""Place below the seed of a session that choices of models have their seeds from."""


class SessionDesk:
    """The record of a session, what is known of its models, and what is to be told. All methods are for one thread."""

    def __init__(self, store: Store) -> None:
        """Begins with an open session file."""
        self.store = store
        about = store.about
        self.pool = ModelPool(about.seed, about.size, self.record.wide)
        self.knowledge = Knowledge()
        self.message: str | None = None
        self.warnings: dict[str, str] = {}
        """By what they say: the same with its place in the rules and what to try."""
        self.is_changed = False

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

    @property
    def factors(self) -> Factors:
        """What was said, by factor."""
        return {name: dict(scores) for name, scores in self.record.factors.items()}

    @property
    def seed(self) -> int:
        """For the next choice of models."""
        return derived_seed(self.store.about.seed, _SEEDS, self.record.num_shown)

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

    def sort(self, order: Order) -> None:
        """Sorts the models that are shown.

        Raises:
            UsageError: when it cannot be done; says why.
        """
        if self.record.way == PAIRS:
            raise UsageError("pairs are shown one after the other; choose another way to show models, and sort those.")
        self.arrange(sorted_grids(order, self.record, self.knowledge, self.pool, self.factor, self.seed))

    def show(self, way: str, models: Sequence[str]) -> None:
        """Shows other models, if there are any."""
        grids = laid_out(way, models, self.record.layout)
        if any(grid.models for grid in grids):
            self.arrange(grids, way)
        else:
            self.tell("There are no models to show in this way.")

    def arrange(self, grids: Sequence[ModelGrid], way: str = "") -> None:
        """Shows models in grids, chosen in some way; in that of before if none is given."""
        self.note("shown", {"way": way or self.record.way, "grids": [grid.as_json() for grid in grids]})

    def note(self, kind: str, body: Body) -> None:
        """Adds an event that keeps the message."""
        try:
            self.store.append(kind, body)
        except GrammarlabError as error:
            self.message = str(error)
        self.is_changed = True

    def tell(self, message: str | None) -> None:
        """Says something until the next event; None takes back what was said."""
        self.message = message
        self.is_changed = True

    def warn(self, findings: Sequence[Finding]) -> None:
        """Takes in warnings about what is shown; each is told once."""
        for finding in findings:
            if finding.message not in self.warnings and len(self.warnings) < MAX_WARNINGS:
                self.warnings[finding.message] = finding.render(())
                self.is_changed = True
