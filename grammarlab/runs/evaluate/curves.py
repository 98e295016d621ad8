"""The curves of many tasks: on several cores, each kept as soon as it is finished."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

from grammarlab.evaluation.curves import Curve
from grammarlab.runs.evaluate import store as disk
from grammarlab.runs.evaluate.store import CurveRecord, Store
from grammarlab.runs.evaluate.task import Task
from grammarlab.runs.sample import Progress
from grammarlab.runs.workers import map_unordered


def run_tasks(
    work: Callable[[Task], CurveRecord],
    tasks: Sequence[Task],
    folder: Path,
    *,
    jobs: int = 1,
    fresh: bool = False,
    on_progress: Progress = lambda _what, _done, _total: None,
) -> tuple[CurveRecord, ...]:
    """The curves of all tasks, in their order; makes those that the folder does not hold yet.

    Args:
        work: makes one curve (`make_curve`); other processes must be able to import it.
        tasks: what to make; equal ones are made once.
        folder: where finished curves are kept (`store`); made when missing.
        jobs: processes; the curves do not depend on it.
        fresh: forget what the folder holds.
        on_progress: told about every finished curve.

    Raises:
        GrammarlabError: as a scenario, its grammar or the folder give reason to.
    """
    folder.mkdir(parents=True, exist_ok=True)
    if fresh:
        disk.clear(folder)
    store = disk.read(folder)
    missing = _missing(tasks, store)
    total = len({(task.key, task.max_labels) for task in tasks})
    done = total - len(missing)
    on_progress("curves", done, total)
    for record in map_unordered(work, missing, min(jobs, max(1, len(missing)))):
        disk.append(folder, record)
        disk.add(store, record)
        done += 1
        on_progress("curves", done, total)
    found = [_usable(task, store) for task in tasks]
    return tuple(
        replace(record, method=task.method.name)
        for task, record in zip(tasks, found, strict=True)
        if record is not None
    )


def _missing(tasks: Sequence[Task], store: Store) -> list[Task]:
    """The curves to make: each once, longer ones first, since they may serve for shorter ones; scenario by scenario."""
    planned = {key: dict(curves) for key, curves in store.items()}
    missing = []
    for task in sorted(tasks, key=lambda task: -task.max_labels):
        if _usable(task, planned) is None:
            missing.append(task)
            placeholder = CurveRecord(task.key, "", "", task.seed, task.max_labels, 0.0, Curve(()))
            disk.add(planned, placeholder)
    return sorted(missing, key=lambda task: (task.scenario, task.method.families))


def _usable(task: Task, store: Store) -> CurveRecord | None:
    """The task's curve when it, or a longer one that begins with it, is there."""
    for max_labels, record in sorted(store.get(task.key, {}).items()):
        # Where the last round of the shorter curve is cut, the longer one does not begin with it.
        if max_labels == task.max_labels or (max_labels > task.max_labels and task.max_labels % task.method.batch == 0):
            return replace(record, max_labels=task.max_labels, curve=record.curve.until(task.max_labels))
    return None
