"""All pictures of an evaluation."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

from grammarlab.runs.disk.results import Progress
from grammarlab.runs.evaluate.disk.store import CurveRecord
from grammarlab.runs.evaluate.figures import PlannedFigure
from grammarlab.runs.evaluate.reporting.grids import draw_grids
from grammarlab.runs.evaluate.reporting.pages import draw_examples
from grammarlab.runs.evaluate.reporting.plots import Series, draw_curves
from grammarlab.runs.evaluate.reporting.scenario_results import ScenarioResults
from grammarlab.runs.evaluate.reporting.sections import ReportPicture, Section
from grammarlab.runs.evaluate.samples import BeforeAfter
from grammarlab.runs.work.executors import AbstractExecutor

ABOUT_SAMPLES = """\
## Pictures

For each scenario: divergence against labels, the median over seeds and a band from the 10 % to the 90 % quantile;
models of the labelled set for each score, as in appendix A of the paper; samples of the density before learning and
after all labels of one simulated person, each above its true score, as in appendix B.
"""
"""Text of a page before pictures of samples."""


def draw_results(results: Sequence[ScenarioResults], folder: Path) -> dict[str, Section]:
    """Draw the curves of each scenario.

    Args:
        results: results of some scenarios and persons.
        folder: folder for the pictures.

    Returns:
        By `ScenarioResults.name`, with one line per method; with only one method, one picture for all persons, with a
        line for each, under the name of the first.
    """
    one_method = len({record.method for item in results for record in item.records}) == 1
    shown: dict[str, list[ScenarioResults]] = {}
    for item in results:
        shown.setdefault(item.scenario.name if one_method else item.name, []).append(item)
    return {items[0].name: _draw_scenario(items, folder) for items in shown.values()}


def _draw_scenario(items: Sequence[ScenarioResults], folder: Path) -> Section:
    """Draw the curves of one scenario: of all methods or all persons."""
    first = items[0]
    target, title = first.scenario.target, f"{first.name if len(items) == 1 else first.scenario.name}: "
    title += first.scenario.title
    series = [
        Series(
            method if len(items) == 1 else item.person,
            tuple(replace(r, curve=c) for r, c in zip(records, item.counted(records), strict=True)),
        )
        for item in items
        for method, records in item.by_method().items()
    ]
    labels = "labels from the first liked model on" if target.since == "first liked" else "labels"
    png, *_ = draw_curves(folder / first.name, title, series, close=target.js, labels=labels)
    return Section(title, ((ReportPicture(png, title),),))


def draw_figure(figure: PlannedFigure, lines: Sequence[tuple[CurveRecord, ...]], folder: Path) -> Section:
    """Draw an experiment.

    Args:
        figure: the experiment.
        lines: the runs of each of its curves.
        folder: folder for the picture.
    """
    series = [Series(curve.label, records) for curve, records in zip(figure.curves, lines, strict=True)]
    png, *_ = draw_curves(folder / f"figure-{figure.name}", figure.title, series)
    title = f"Figure {figure.name}: {figure.title}"
    return Section(title, ((ReportPicture(png, title),),), figure.paper and f"Paper: {figure.paper}")


@dataclass(frozen=True, slots=True)
class SamplePictures:
    """Pictures of liked models of a scenario, and of samples before and after learning."""

    scenario: Path
    examples: Path
    """Models with their true scores."""
    grids: dict[int, dict[str, Path]]
    """By number of models along each side, and then by stage: ``before`` and ``after``."""


def draw_samples(
    samples: Mapping[Path, BeforeAfter], folder: Path, executor: AbstractExecutor, on_progress: Progress
) -> dict[Path, SamplePictures]:
    """Draw liked models of scenarios, and samples before and after learning.

    Args:
        samples: samples by scenario file.
        folder: folder for the pictures; created if missing.
        executor: draws the pictures, which do not depend on it.
        on_progress: called after every finished scenario.

    Returns:
        The pictures, by scenario file.
    """
    found: dict[Path, SamplePictures] = {}
    on_progress("grids", 0, len(samples))

    def finish(_index: int, pictures: SamplePictures) -> None:
        found[pictures.scenario] = pictures
        on_progress("grids", len(found), len(samples))

    executor.run(partial(_draw_samples, folder, executor.share(len(samples))), samples.items(), finish)
    return found


def _draw_samples(folder: Path, executor: AbstractExecutor, item: tuple[Path, BeforeAfter]) -> SamplePictures:
    scenario, samples = item
    examples = draw_examples(scenario, folder, executor)
    return SamplePictures(scenario, examples, draw_grids(scenario, samples, folder, executor))


def with_samples(section: Section, record: CurveRecord, pictures: SamplePictures) -> Section:
    """The part of a scenario, with samples below its curves.

    Args:
        section: the curves.
        record: the curve of the samples.
        pictures: pictures of the samples.
    """
    smallest, *larger = sorted(pictures.grids)
    titles = {
        "before": "samples before learning",
        "after": f"samples after {record.curve.points[-1].labels} labels ({record.method}, seed {record.seed})",
    }
    examples = ReportPicture(pictures.examples, f"{record.scenario}: models and their scores")
    grid = tuple(ReportPicture(file, titles[stage]) for stage, file in pictures.grids[smallest].items())
    linked = tuple(
        ReportPicture(file, f"{size}x{size} samples {stage}")
        for size in larger
        for stage, file in pictures.grids[size].items()
    )
    return replace(section, rows=(*section.rows, (examples,), grid), linked=linked)
