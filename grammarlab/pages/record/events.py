"""Events of a session, and the state computed from them.

Events are never changed. Undo and redo are events that revert and repeat scores, comparisons, imports and changes
of factors, the latest first. All other events concern the shown models and cannot be undone.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from grammarlab.errors import UsageError, shown
from grammarlab.pages.record.judgements import (
    Judgement,
    Scores,
    Subject,
    checked_entry,
    checked_judgement,
    checked_pair,
    compared,
    models_of,
)
from grammarlab.pages.record.model_grids import (
    MAX_MODELS,
    MAX_NAME,
    Body,
    GridLayout,
    ModelGrid,
    check_layout,
    check_shown,
    checked_models,
    checked_name,
)
from grammarlab.preference.labels import COMPARISONS, OVERALL

MAX_FACTORS = 24
"""Largest number of factors of a session."""
VIEWS = ("active", "product")


@dataclass(frozen=True, slots=True)
class Event:
    """One event."""

    number: int
    """1, 2, 3 …: the revision of the session after it."""
    time: float
    """Seconds since 1970, for people to read only."""
    kind: str
    body: Body


@dataclass(frozen=True, slots=True)
class _Scored:
    """A step that can be undone: labels for one factor."""

    factor: str
    before: Mapping[Subject, Judgement | None]
    after: Mapping[Subject, Judgement | None]


@dataclass(frozen=True, slots=True)
class _Refactored:
    """A step that can be undone: a change of factors, or a replacement of their scores."""

    before: dict[str, Scores]
    after: dict[str, Scores]
    numbers_before: dict[str, int]
    numbers_after: dict[str, int]
    active_before: str
    active_after: str


@dataclass
class Record:
    """State computed from the events so far."""

    revision: int = 0
    """Number of the last event."""
    factors: dict[str, Scores] = field(default_factory=lambda: {OVERALL: {}})
    """Labels by factor; at least one factor."""
    numbers: dict[str, int] = field(default_factory=lambda: {OVERALL: 1})
    """Number of each factor, independent of its name: 1, 2, 3 … in the order of creation."""
    num_created: int = 1
    """Number of factors ever created."""
    active: str = OVERALL
    view: str = "active"
    layout: GridLayout = field(default_factory=GridLayout)
    grids: tuple[ModelGrid, ...] = ()
    way: str = "default"
    """Strategy of the shown models."""
    num_shown: int = 0
    """Number of times that models were chosen or sorted."""
    shown_models: dict[str, None] = field(default_factory=dict)
    """All models ever shown, in order."""
    chart: list[tuple[int, float]] = field(default_factory=list)
    """Number of labels, and change of the density in nats, at each update."""
    wide: bool = False
    """Whether the pool has been widened for rare models; undo does not change it."""
    done: list[_Scored | _Refactored] = field(default_factory=list)
    undone: list[_Scored | _Refactored] = field(default_factory=list)
    keys: set[str] = field(default_factory=set)
    """Keys that windows gave their scores, so that a repeated request counts once."""
    label_revision: int = 0
    """Counter that changes whenever scores or factors may have changed."""

    @property
    def num_labels(self) -> int:
        """Scores and comparisons of all factors."""
        return sum(map(len, self.factors.values()))

    @property
    def shown_now(self) -> tuple[str, ...]:
        """The different models of the grids, in order."""
        return tuple(dict.fromkeys(model for grid in self.grids for model in grid.models))

    @property
    def labelled_models(self) -> dict[str, None]:
        """The models with labels."""
        return models_of(subject for scores in self.factors.values() for subject in scores)

    def name_of(self, factor: object) -> object:
        """The name of a factor from its number; other values unchanged.

        Raises:
            UsageError: If there is no factor of that number.
        """
        if isinstance(factor, bool) or not isinstance(factor, int):
            return factor
        for name, number in self.numbers.items():
            if number == factor:
                return name
        raise UsageError("the factor that this was meant for has been deleted; Undo brings it and its scores back.")

    def check(self, kind: str, body: Body) -> None:
        """Check that an event is possible now.

        Raises:
            UsageError: If it is not; it names the expected and the found value.
        """
        if kind not in _KINDS:
            raise UsageError(f"unknown event {shown(kind)}; expected one of {', '.join(_KINDS)}.")
        if not isinstance(body, dict):
            raise UsageError(f"expected an object, found {shown(body)}.")
        _KINDS[kind][0](self, body)

    def apply(self, event: Event) -> None:
        """Add an event.

        Raises:
            UsageError: If it is not possible now; then nothing changes.
        """
        self.check(event.kind, event.body)
        _KINDS[event.kind][1](self, event.body)
        self.revision = event.number

    def _do(self, step: _Scored | _Refactored) -> None:
        self._move(step, forward=True)
        self.done.append(step)
        self.undone.clear()

    def _move(self, step: _Scored | _Refactored, *, forward: bool) -> None:
        self.label_revision += 1
        if isinstance(step, _Refactored):
            self.factors = step.after if forward else step.before
            self.numbers = step.numbers_after if forward else step.numbers_before
            here, there = (step.active_after, step.active_before)[:: 1 if forward else -1]
            if self.active == there or self.active not in self.factors:
                self.active = here
            if len(self.factors) == 1:
                self.view = "active"
            return
        scores = self.factors[step.factor]
        for subject, judgement in (step.after if forward else step.before).items():
            if judgement is None:
                scores.pop(subject, None)
            else:
                scores[subject] = judgement

    def _label(self, body: Body, judgements: Mapping[Subject, Judgement | None]) -> None:
        if key := body.get("key"):
            self.keys.add(key)
        scores = self.factors[body["factor"]]
        self._do(_Scored(body["factor"], {subject: scores.get(subject) for subject in judgements}, judgements))

    def _refactor(self, after: dict[str, Scores], active: str, renamed: Mapping[str, str] | None = None) -> None:
        """Other factors; those of new names are new, but for those that were renamed, given by new and old name."""
        before, numbers = self.numbers, {}
        for name in after:
            old = (renamed or {}).get(name, name)
            if old not in before:
                self.num_created += 1
            numbers[name] = before.get(old, self.num_created)
        self._do(_Refactored(self.factors, after, before, numbers, self.active, active))


def _check_factor(record: Record, value: object) -> None:
    if not isinstance(value, str) or value not in record.factors:
        raise UsageError(f"no factor {shown(value)}; expected one of {', '.join(record.factors)}.")


def _check_key(record: Record, body: Body) -> None:
    key = body.get("key", "")
    if not isinstance(key, str) or len(key) > MAX_NAME or (key and key in record.keys):
        raise UsageError(f"key: expected a new text of at most {MAX_NAME} characters, found {shown(key)}.")


def _check_score(record: Record, body: Body) -> None:
    _check_factor(record, body.get("factor"))
    if not checked_models(body.get("models")):
        raise UsageError("models: expected at least one; select what to score.")
    _score_of(body)
    _check_key(record, body)


def _score_of(body: Body) -> Judgement | None:
    return None if body.get("score") is None else checked_judgement(body["score"], body.get("kind", "score"))


def _score(record: Record, body: Body) -> None:
    record._label(body, dict.fromkeys(body["models"], _score_of(body)))


def _check_compare(record: Record, body: Body) -> None:
    _check_factor(record, body.get("factor"))
    checked_pair(body.get("models"))
    if body.get("kind") not in (*COMPARISONS, None):
        expected = f"{', '.join(COMPARISONS)}, or null for none"
        raise UsageError(f"kind: expected {expected}, found {shown(body.get('kind'))}.")
    _check_key(record, body)


def _compare(record: Record, body: Body) -> None:
    subject, judgement = compared(body["models"], body.get("kind") or "tie")
    record._label(body, {subject: judgement if body.get("kind") else None})


def _check_import(record: Record, body: Body) -> None:
    scores = body.get("scores")
    if not isinstance(scores, dict) or not scores:
        raise UsageError(f"scores: expected scores by factor, found {shown(scores)}.")
    for name, values in scores.items():
        checked_name(name)
        if not isinstance(values, dict) or len(values) > MAX_MODELS:
            raise UsageError(
                f"scores of {shown(name)}: expected a score for each of at most {MAX_MODELS:,} models, found "
                f"{shown(values)}."
            )
        for subject, value in values.items():
            checked_entry(subject, value)
    if len({*record.factors, *scores}) > MAX_FACTORS:
        raise UsageError(f"there would be more than {MAX_FACTORS} factors.")


def _import(record: Record, body: Body) -> None:
    after = dict(record.factors)
    for name, values in body["scores"].items():
        after[name] = after.get(name, {}) | dict(checked_entry(subject, value) for subject, value in values.items())
    record._refactor(after, record.active)


def _check_new_name(record: Record, value: object) -> None:
    name = checked_name(value)
    if name in record.factors:
        raise UsageError(f"there is a factor called {name!r} already; choose another name.")


def _check_create(record: Record, body: Body) -> None:
    _check_new_name(record, body.get("name"))
    if len(record.factors) >= MAX_FACTORS:
        raise UsageError(f"there are {MAX_FACTORS} factors already; delete one first.")


def _create(record: Record, body: Body) -> None:
    record._refactor({**record.factors, body["name"]: {}}, body["name"])


def _check_rename(record: Record, body: Body) -> None:
    _check_factor(record, body.get("name"))
    _check_new_name(record, body.get("to"))


def _rename(record: Record, body: Body) -> None:
    name, to = body["name"], body["to"]
    active = to if record.active == name else record.active
    renamed = {to if factor == name else factor: scores for factor, scores in record.factors.items()}
    record._refactor(renamed, active, {to: name})


def _check_delete(record: Record, body: Body) -> None:
    _check_factor(record, body.get("name"))
    if len(record.factors) == 1:
        raise UsageError("expected another factor to remain; create one before you delete the last.")


def _delete(record: Record, body: Body) -> None:
    remaining = {name: scores for name, scores in record.factors.items() if name != body["name"]}
    record._refactor(remaining, record.active if record.active in remaining else next(iter(remaining)))


def _check_undo(record: Record, _body: Body) -> None:
    if not record.done:
        raise UsageError("there is nothing to undo.")


def _undo(record: Record, _body: Body) -> None:
    step = record.done.pop()
    record._move(step, forward=False)
    record.undone.append(step)


def _check_redo(record: Record, _body: Body) -> None:
    if not record.undone:
        raise UsageError("there is nothing to redo.")


def _redo(record: Record, _body: Body) -> None:
    step = record.undone.pop()
    record._move(step, forward=True)
    record.done.append(step)


def _check_activate(record: Record, body: Body) -> None:
    _check_factor(record, body.get("name"))


def _activate(record: Record, body: Body) -> None:
    record.active = body["name"]


def _check_view(_record: Record, body: Body) -> None:
    if body.get("kind") not in VIEWS:
        raise UsageError(f"kind: expected {' or '.join(VIEWS)}, found {shown(body.get('kind'))}.")


def _view(record: Record, body: Body) -> None:
    record.view = body["kind"]


def _layout(record: Record, body: Body) -> None:
    record.layout = GridLayout(body["grids"], body["rows"], body["columns"])


def _show(record: Record, body: Body) -> None:
    record.grids = tuple(ModelGrid(grid["title"], tuple(grid["models"])) for grid in body["grids"])
    record.way = body["way"]
    record.num_shown += 1
    record.shown_models |= dict.fromkeys(record.shown_now)


def _check_learned(_record: Record, body: Body) -> None:
    labels, js, wide = body.get("labels"), body.get("js"), body.get("wide", False)
    if isinstance(labels, bool) or not isinstance(labels, int) or not 0 <= labels < 1 << 31:
        raise UsageError(f"labels: expected a count, found {shown(labels)}.")
    if isinstance(js, bool) or not isinstance(js, int | float) or not 0 <= js <= math.log(2.0):
        raise UsageError(f"js: expected a divergence from 0 to ln 2, found {shown(js)}.")
    if not isinstance(wide, bool):
        raise UsageError(f"wide: expected true or false, found {shown(wide)}.")


def _learn(record: Record, body: Body) -> None:
    record.chart.append((body["labels"], float(body["js"])))
    record.wide |= body.get("wide", False)


_KINDS: dict[str, tuple[Callable[[Record, Body], None], Callable[[Record, Body], None]]] = {
    "score": (_check_score, _score),
    "compare": (_check_compare, _compare),
    "import": (_check_import, _import),
    "factor_create": (_check_create, _create),
    "factor_rename": (_check_rename, _rename),
    "factor_delete": (_check_delete, _delete),
    "undo": (_check_undo, _undo),
    "redo": (_check_redo, _redo),
    "factor_activate": (_check_activate, _activate),
    "view": (_check_view, _view),
    "layout": (lambda _, body: check_layout(body), _layout),
    "shown": (lambda _, body: check_shown(body), _show),
    "learned": (_check_learned, _learn),
}
"""Check and effect of each kind of event."""
