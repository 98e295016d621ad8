"""Curves of many tasks: computed on several cores, each stored when it is finished."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TypeAlias

from grammarlab.evaluation.curves import Curve
from grammarlab.runs.disk.results import Progress, made
from grammarlab.runs.evaluate.disk.store import CurveRecord, curves_in
from grammarlab.runs.evaluate.task import CurveTask
from grammarlab.runs.work.executors import SERIAL, AbstractExecutor

Store: TypeAlias = dict[str, dict[int, CurveRecord]]
"""Curves by key, and then by their largest number of labels."""


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
    total = len({task.place for task in tasks})
    there = total - len(missing)

    def tell(what: str, done: int, _missing: int) -> None:
        on_progress(what, there + done, total)

    for record in made(curves, work, {task.place: task for task in missing}, executor, "curves", tell).values():
        _add(store, record)
    found = [_usable(task, store) for task in tasks]
    return tuple(
        replace(record, method=task.method.name)
        for task, record in zip(tasks, found, strict=True)
        if record is not None
    )


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


def _add(store: Store, record: CurveRecord) -> None:
    store.setdefault(record.key, {})[record.max_labels] = record


def _usable(task: CurveTask, store: Store) -> CurveRecord | None:
    """The task's curve, if it or a longer one that begins with it is stored."""
    for max_labels, record in sorted(store.get(task.key, {}).items()):
        # If the last round of the shorter curve is shortened, the longer one does not begin with it.
        if max_labels == task.max_labels or (max_labels > task.max_labels and task.max_labels % task.method.batch == 0):
            return replace(record, max_labels=task.max_labels, curve=record.curve.until(task.max_labels))
    return None
