"""Learning curves of scenarios, methods and seeds, and a folder with tables and pictures of them.

A folder of results has ``curves/`` (every curve as soon as it is finished), ``results.parquet`` (one row per round),
``results.md``, ``plots/`` and, on request, ``grids/`` with ``samples/``, ``density/`` and ``grammars/``; and
``cache/``, which may be deleted at any time.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from grammarlab.evaluation.methods import Method
from grammarlab.evaluation.respondents import EXACT, Respondent
from grammarlab.extras import require
from grammarlab.runs.evaluate import curve_store, paper_table, persons, samples
from grammarlab.runs.evaluate.curve_tasks import CurveTask, make_curve, run_tasks
from grammarlab.runs.evaluate.figures import PlannedFigure
from grammarlab.runs.evaluate.paper_table import DensityRow, density_rows, density_tables
from grammarlab.runs.evaluate.persons import Person, PersonRow, person_rows, person_table
from grammarlab.runs.evaluate.pictures import (
    ABOUT_SAMPLES,
    copied_beside,
    draw_answer,
    draw_figure,
    draw_results,
    draw_samples,
    with_samples,
)
from grammarlab.runs.evaluate.plots import ScenarioResults
from grammarlab.runs.evaluate.report import PAGE, TABLE, write_page, write_table
from grammarlab.runs.evaluate.request import EvaluationRequest
from grammarlab.runs.evaluate.samples import draw_models
from grammarlab.runs.sample.sources import load_source
from grammarlab.runs.work.executors import SERIAL, AbstractExecutor
from grammarlab.runs.work.results import Progress
from grammarlab.runs.work.run_folder import only_run_in

PLOTS, GRIDS, CACHE = "plots", "grids", "cache"
"""Folders in the folder of results."""
_INNER = (PLOTS, GRIDS, *(module.STORE for module in (curve_store, samples, paper_table, persons)))
"""Folders that a run fills or clears, so that none of them may be a link to another place."""


@dataclass(frozen=True, slots=True)
class EvaluationResult:
    """Measurements of an evaluation."""

    scenarios: tuple[ScenarioResults, ...]
    """Results in the order of the request; for each scenario, all persons."""
    table: Path
    page: Path
    densities: tuple[DensityRow, ...] = ()
    """Measurements of methods that make a density."""
    grammars: tuple[PersonRow, ...] = ()
    """Grammars made from the scores of persons."""


def evaluate_run(
    request: EvaluationRequest,
    folder: Path,
    *,
    report: Path | None = None,
    cache: Path | None = None,
    executor: AbstractExecutor = SERIAL,
    fresh: bool = False,
    command: str = "grammarlab evaluate",
    on_progress: Progress = lambda _what, _done, _total: None,
) -> EvaluationResult:
    """Compute all curves of a request, then tables and pictures of them.

    An interrupted run keeps every finished curve, and the next run continues from there.

    Args:
        request: the request.
        folder: folder for the results; created if missing.
        report: another path for the page; its pictures go into a folder of the same name next to it.
        cache: folder for counted features; ``cache`` in the folder of results when left out.
        executor: computes everything; no number depends on it.
        fresh: remove the curves in the folder first.
        command: command line for the page.
        on_progress: called after finished steps.

    Raises:
        GrammarlabError: If a scenario, its grammar or the folder cannot be used.
    """
    require("matplotlib")  # before hours of work, not after
    with only_run_in(folder, _INNER):
        executor = executor.in_folder(folder)
        return _evaluate(request, folder, report, cache or folder / CACHE, executor, fresh, command, on_progress)


def _evaluate(
    request: EvaluationRequest,
    folder: Path,
    report: Path | None,
    cache: Path,
    executor: AbstractExecutor,
    fresh: bool,
    command: str,
    on_progress: Progress,
) -> EvaluationResult:
    """See `evaluate_run`; no other run writes into the folder."""
    executor = executor.with_environment(_compiler_cache(cache))
    plain = {
        (path, person): _tasks(path, request.methods_of(path), person, request.seeds, request.labels_of(path), cache)
        for path in request.scenarios
        for person in request.persons
    }
    planned = {figure.name: _figure_tasks(figure, request.seeds, cache) for figure in request.figures}
    tasks = [task for part in plain.values() for task in part]
    tasks += [task for part in planned.values() for line in part for task in line]
    records = run_tasks(make_curve, tasks, folder, executor=executor, fresh=fresh, on_progress=on_progress)
    by_task = dict(zip(tasks, records, strict=True))
    results = tuple(
        ScenarioResults(load_source(path).scenario, tuple(by_task[task] for task in part), path)
        for (path, _), part in plain.items()
    )
    write_table(folder / TABLE, list(by_task.values()))
    curves, answer = draw_results(results, folder / PLOTS), draw_answer(results, folder / PLOTS)
    if request.grids:
        firsts = {path: plain[path, request.persons[0]][0] for path in request.scenarios}
        models = draw_models(list(firsts.values()), folder, executor=executor, fresh=fresh, on_progress=on_progress)
        drawn = draw_samples(dict(zip(firsts, models, strict=True)), folder / GRIDS, executor, on_progress)
        for item, (path, person) in zip(results, plain, strict=True):
            if person == request.persons[0]:
                curves[item.name] = with_samples(curves[item.name], by_task[firsts[path]], drawn[path])
    pictures = list(curves.values())
    for figure in request.figures:
        lines = [tuple(by_task[task] for task in line) for line in planned[figure.name]]
        pictures.append(draw_figure(figure, lines, folder / PLOTS))
    scenarios = [load_source(path).scenario for path in request.scenarios]
    densities: tuple[DensityRow, ...] = ()
    if request.density:
        with_results = [path for path in request.scenarios if load_source(path).scenario.paper.original is not None]
        measured = with_results or request.scenarios
        densities = density_rows(measured, folder, executor=executor, fresh=fresh, on_progress=on_progress)
    people = _persons(request, cache)
    grammars = person_rows(people, folder, executor=executor, fresh=fresh, on_progress=on_progress) if people else ()
    sections = [density_tables(densities, scenarios)] if densities else []
    sections += [person_table(grammars, scenarios)] if grammars else []
    sections += [ABOUT_SAMPLES] if request.grids else []
    for page in (folder / PAGE, *([report] if report else [])):
        is_main = page == folder / PAGE
        copies = pictures if is_main else [copied_beside(picture, page) for picture in pictures]
        write_page(page, results, copies, command, sections, answer if is_main else copied_beside(answer, page))
    return EvaluationResult(results, folder / TABLE, folder / PAGE, densities, grammars)


def _compiler_cache(cache: Path) -> dict[str, str]:
    """Environment of JAX's compilation cache, so that compiled code is reused."""
    values = {
        "JAX_COMPILATION_CACHE_DIR": str(cache.absolute() / "jax"),
        "JAX_PERSISTENT_CACHE_MIN_COMPILE_TIME_SECS": "0",
    }
    return {name: os.environ.get(name, value) for name, value in values.items()}


def _persons(request: EvaluationRequest, cache: Path) -> list[Person]:
    """The persons whose scores become grammars."""
    return [
        Person(path, seed, labels, cache, respondent)
        for path in request.scenarios
        if (labels := request.grammar_labels_of(load_source(path).scenario.name)) is not None
        for respondent in request.persons
        for seed in range(request.seeds)
    ]


def _tasks(
    path: Path, methods: Sequence[Method], person: Respondent, seeds: int, max_labels: int, cache: Path
) -> list[CurveTask]:
    key = load_source(path).key
    return [
        CurveTask(
            scenario=path, source_key=key, method=method, seed=seed, max_labels=max_labels, cache=cache, person=person
        )
        for method in methods
        for seed in range(seeds)
    ]


def _figure_tasks(figure: PlannedFigure, seeds: int, cache: Path) -> list[list[CurveTask]]:
    return [_tasks(curve.scenario, (curve.method,), EXACT, seeds, figure.max_labels, cache) for curve in figure.curves]
