"""All pictures of an evaluation."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from grammarlab.runs.atomic import atomic_file
from grammarlab.runs.evaluate.figures import PlannedFigure
from grammarlab.runs.evaluate.grids import draw_grids
from grammarlab.runs.evaluate.pages import draw_examples
from grammarlab.runs.evaluate.plots import Series, draw_curves
from grammarlab.runs.evaluate.report import Picture, ScenarioResults
from grammarlab.runs.evaluate.store import CurveRecord
from grammarlab.runs.evaluate.task import Task, load_source
from grammarlab.runs.sample import Progress


def draw_results(results: Sequence[ScenarioResults], folder: Path) -> list[Picture]:
    """Draw the curves of each scenario, a line a method."""
    pictures = []
    for item in results:
        series = [Series(method, records) for method, records in item.by_method().items()]
        title = f"{item.scenario.name}: {item.scenario.title}"
        png, *_ = draw_curves(folder / item.scenario.name, title, series)
        pictures.append(Picture(png, title))
    return pictures


def draw_figure(figure: PlannedFigure, lines: Sequence[tuple[CurveRecord, ...]], folder: Path) -> Picture:
    """Draw an experiment.

    Args:
        figure: what it shows.
        lines: the runs of each of its curves.
        folder: for the picture.
    """
    series = [Series(curve.label, records) for curve, records in zip(figure.curves, lines, strict=True)]
    png, *_ = draw_curves(folder / f"figure-{figure.name}", figure.title, series)
    return Picture(png, f"Figure {figure.name}: {figure.title}", figure.paper and f"Paper: {figure.paper}")


def draw_samples(tasks: Sequence[Task], folder: Path, jobs: int, on_progress: Progress) -> list[Picture]:
    """Draw what each scenario likes, and samples before and after the curves of some tasks, one a scenario."""
    pictures = []
    on_progress("grids", 0, len(tasks))
    for done, task in enumerate(tasks, 1):
        name = load_source(task.scenario).scenario.name
        examples = draw_examples(task.scenario, folder, jobs)
        pictures.append(Picture(examples, f"{name}: models and their scores"))
        grids = draw_grids(task, folder, jobs)
        for size, files in grids.items():
            for stage, file in files.items():
                title = f"{name}: {size}x{size} samples {stage}"
                pictures.append(Picture(file, title, small=size == min(grids)))
        on_progress("grids", done, len(tasks))
    return pictures


def copied_beside(picture: Picture, page: Path) -> Picture:
    """The picture as a copy in a folder beside a page, of the page's name."""
    folder = page.with_suffix("")
    folder.mkdir(parents=True, exist_ok=True)
    with atomic_file(folder / picture.file.name) as part:
        part.write_bytes(picture.file.read_bytes())
    return replace(picture, file=folder / picture.file.name)
