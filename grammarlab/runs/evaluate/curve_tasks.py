"""Tasks of learning curves: computed in several processes, each curve stored when it is finished."""

from __future__ import annotations

import platform
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import TypeAlias

from grammarlab.about import __version__
from grammarlab.errors import UsageError
from grammarlab.evaluation import protocol
from grammarlab.evaluation.curves import Curve
from grammarlab.evaluation.methods import Method
from grammarlab.evaluation.preparation import Material, prepare
from grammarlab.evaluation.respondents import EXACT, Respondent
from grammarlab.learning.round import State
from grammarlab.learning.settings import Settings
from grammarlab.runs.evaluate.curve_store import CurveRecord, curves_in, digest
from grammarlab.runs.sample.sources import load_source
from grammarlab.runs.work.executors import SERIAL, AbstractExecutor
from grammarlab.runs.work.results import Progress, computed
from grammarlab.runs.work.workers import report, reporting_for

CURVES = "curves"
"""Name of the curves in the progress of a run."""
Store: TypeAlias = dict[str, dict[int, CurveRecord]]
"""Curves by key, and then by their largest number of labels."""


@dataclass(frozen=True, slots=True)
class CurveTask:
    """One curve to make."""

    scenario: Path
    """The scenario file."""
    source_key: str
    """`Source.key` of the scenario and its grammar."""
    method: Method
    seed: int
    """0 <= seed < 2**64."""
    max_labels: int
    """Largest number of labels, >= 1."""
    cache: Path
    """Folder for compiled code, shared with other curves and runs."""
    person: Respondent = EXACT
    """Error model of the scores."""

    @property
    def settings(self) -> Settings:
        """Settings of the method for the scenario."""
        return self.method.settings(load_source(self.scenario).scenario.features)

    @property
    def key(self) -> str:
        """Key of the curve: SHA-256 of all its inputs except `max_labels`."""
        return digest([__version__, self.source_key, self.method.as_json(), self.seed, asdict(self.person)])

    @property
    def curve_name(self) -> str:
        """Name of the curve among all curves: its key and number of labels."""
        return f"{self.key}-{self.max_labels}"

    def __str__(self) -> str:
        return (
            f"the curve of {self.scenario.stem}, method {self.method.name}, person {self.person.name}, seed {self.seed}"
        )


def make_curve(task: CurveTask) -> CurveRecord:
    """The curve of a task."""
    material, _, curve = run_protocol(task)
    name = load_source(task.scenario).scenario.name
    return CurveRecord(
        key=task.key,
        scenario=name,
        method=task.method.name,
        seed=task.seed,
        max_labels=task.max_labels,
        js_original=material.js_original,
        curve=curve,
        person=task.person.name,
    )


def run_protocol(
    task: CurveTask, on_round: Callable[[Material, State], None] = lambda _material, _state: None
) -> tuple[Material, State, Curve]:
    """The simulated person of a task, after all rounds.

    Args:
        task: the task.
        on_round: called with the material and the state after every round.
    """
    with reporting_for(_whose(task)):
        material = _load_material(task.scenario, task.source_key, task.settings, task.seed)
        material = material if task.method.factored else material.as_one_factor()
        material = material.answered_by(task.person, task.seed)
        part = f"models of {load_source(task.scenario).scenario.name}"
        material.study.tables(report=lambda _part, done, total: report(part, done, total))
    state, curve = protocol.run(
        material, task.method.batch, task.seed, task.max_labels, lambda state: on_round(material, state)
    )
    return material, state, curve


def _whose(task: CurveTask) -> str:
    """Whose models a task makes: several curves of a scenario may be made at once."""
    person = "" if task.person == EXACT else f", person {task.person.name}"
    return f"{task.method.name}{person}, seed {task.seed}"


def run_tasks(
    work: Callable[[CurveTask], CurveRecord],
    tasks: Sequence[CurveTask],
    folder: Path,
    *,
    executor: AbstractExecutor = SERIAL,
    fresh: bool = False,
    on_progress: Progress = lambda _what, _done, _total: None,
) -> tuple[CurveRecord, ...]:
    """Curves of all tasks, in their order; curves missing in the folder are computed.

    Args:
        work: makes one curve (`make_curve`); other processes must be able to import it.
        tasks: the tasks; equal ones are computed once.
        folder: folder of finished curves (`store`); created if missing.
        executor: computes the curves, which do not depend on it.
        fresh: remove the curves in the folder first.
        on_progress: called after every finished curve.

    Raises:
        GrammarlabError: If a scenario, its grammar or the folder cannot be used.
    """
    folder.mkdir(parents=True, exist_ok=True)
    curves = curves_in(folder, fresh=fresh)
    store: Store = {}
    for record in curves.all().values():
        _add(store, record)
    missing = _missing(tasks, store)
    total = len({task.curve_name for task in tasks})
    num_stored = total - len(missing)

    def tell(what: str, done: int, parts: int) -> None:
        on_progress(what, *((num_stored + done, total) if what == CURVES else (done, parts)))

    by_name = {task.curve_name: task for task in missing}
    for record in computed(curves, work, by_name, executor, CURVES, tell).values():
        _add(store, record)
    finished = [_usable(task, store) for task in tasks]
    return tuple(
        replace(record, method=task.method.name)
        for task, record in zip(tasks, finished, strict=True)
        if record is not None
    )


@lru_cache(maxsize=2)
def _load_material(scenario: Path, source_key: str, settings: Settings, seed: int) -> Material:
    """Material of the curves of a scenario and a seed; their tasks are consecutive, so few are cached.

    Raises:
        UsageError: If the files of the scenario have another key than the task.
    """
    source = load_source(scenario)
    if source.key != source_key:
        raise UsageError(
            f"{scenario}: the scenario or its grammar has changed since the run began, or machine "
            f"{platform.node()!r} has others by the same path. Start again with files that all machines share."
        )
    return prepare(source.for_person(seed), settings, report)


def _add(store: Store, record: CurveRecord) -> None:
    store.setdefault(record.key, {})[record.max_labels] = record


def _missing(tasks: Sequence[CurveTask], store: Store) -> list[CurveTask]:
    """The curves to compute: each once, longer ones first, since they include shorter ones; scenario by scenario."""
    planned = {key: dict(curves) for key, curves in store.items()}
    missing = []
    for task in sorted(tasks, key=lambda task: -task.max_labels):
        if _usable(task, planned) is None:
            missing.append(task)
            placeholder = CurveRecord(
                key=task.key,
                scenario="",
                method="",
                seed=task.seed,
                max_labels=task.max_labels,
                js_original=0.0,
                curve=Curve(()),
                person=task.person.name,
            )
            _add(planned, placeholder)
    return sorted(missing, key=lambda task: (task.scenario, task.seed, task.method.families))


def _usable(task: CurveTask, store: Store) -> CurveRecord | None:
    """The task's curve, if it or a longer one that begins with it is stored."""
    for max_labels, record in sorted(store.get(task.key, {}).items()):
        # If the last round of the shorter curve is shortened, the longer one does not begin with it.
        if max_labels == task.max_labels or (max_labels > task.max_labels and task.max_labels % task.method.batch == 0):
            return replace(record, max_labels=task.max_labels, curve=record.curve.until(task.max_labels))
    return None
