"""Pictures of an evaluation, liked models of each scenario (appendix A of the paper) among them, and their Markdown."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from grammarlab.evaluation.curves import summarize
from grammarlab.evaluation.preparation import Source
from grammarlab.features.expression import Expression
from grammarlab.features.model_score import Score
from grammarlab.files import atomic_file
from grammarlab.runs.evaluate.curve_store import CurveRecord
from grammarlab.runs.evaluate.figures import PlannedFigure
from grammarlab.runs.evaluate.plots import (
    TILE_AREA,
    NeededLabels,
    ScenarioResults,
    Series,
    draw_curves,
    draw_grids,
    draw_needed,
    needed_labels,
    save_picture,
    tiles_of,
)
from grammarlab.runs.evaluate.samples import BeforeAfter
from grammarlab.runs.sample.contact_sheet import PAPER, draw_page, lay_out
from grammarlab.runs.sample.sources import load_source
from grammarlab.runs.work.executors import AbstractExecutor
from grammarlab.runs.work.results import Progress
from grammarlab.tables import markdown_table

OTHERS = "others"
"""Name of the models without a case."""
BANDS = (80.0, 60.0, 40.0, 20.0, 0.0)
"""Lower bounds of the groups of a continuous score."""
COLUMNS = 8
"""Number of models of one group."""
ABOUT_SAMPLES = """\
## Pictures

For each scenario: divergence against labels, the median over seeds and a band from the 10 % to the 90 % quantile;
models of the labelled set for each score, as in appendix A of the paper; samples of the density before learning and
after all labels of one simulated person, each above its true score, as in appendix B.
"""
"""Text of a page before pictures of samples."""


@dataclass(frozen=True, slots=True)
class LikedModels:
    """Models with equal scores for the same reason."""

    score: float
    """0 to 100; the lower bound of a band."""
    means: str
    """The reason in words."""
    models: tuple[int, ...]
    """The first ones of the labelled set; none if it has none."""


@dataclass(frozen=True, slots=True)
class ReportPicture:
    """A picture for a page."""

    file: Path
    title: str
    """Title; printed above the picture if it has neighbours."""


@dataclass(frozen=True, slots=True)
class Section:
    """A heading and pictures below it."""

    title: str
    rows: tuple[tuple[ReportPicture, ...], ...]
    """Pictures side by side, row by row."""
    remark: str = ""
    """Text below the pictures."""
    linked: tuple[ReportPicture, ...] = ()
    """Pictures that are too large for the page."""


@dataclass(frozen=True, slots=True)
class SamplePictures:
    """Pictures of liked models of a scenario, and of samples before and after learning."""

    scenario: Path
    examples: Path
    """Models with their true scores."""
    grids: dict[int, dict[str, Path]]
    """Pictures by number of models along each side, and then by stage: ``before`` and ``after``."""


def markdown(section: Section, folder: Path) -> str:
    """A part of a page in a folder."""
    parts = [f"## {section.title}", *(_row(row, folder) for row in section.rows)]
    links = [f"[{picture.title}]({_link(picture, folder)})" for picture in section.linked]
    below = " ".join(filter(None, [section.remark, f"Larger: {', '.join(links)}." if links else ""]))
    return "\n\n".join([*parts, *filter(None, [below])]) + "\n"


def copied_beside(section: Section, page: Path) -> Section:
    """The part with copies of its pictures, in a folder next to a page, with the name of the page."""
    rows = tuple(tuple(_copied(picture, page.with_suffix("")) for picture in row) for row in section.rows)
    return replace(
        section, rows=rows, linked=tuple(_copied(picture, page.with_suffix("")) for picture in section.linked)
    )


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
    groups: dict[str, list[ScenarioResults]] = {}
    for item in results:
        groups.setdefault(item.scenario.name if one_method else item.name, []).append(item)
    return {items[0].name: _draw_scenario(items, folder) for items in groups.values()}


def draw_answer(results: Sequence[ScenarioResults], folder: Path) -> Section:
    """How many scores are needed: a chart, and a sentence for each person and method.

    Args:
        results: results of some scenarios and persons.
        folder: folder for the picture.
    """
    lines = needed_labels(results)
    png, *_ = draw_needed(folder / "needed", lines)
    return Section(
        "How many scores do I need?",
        ((ReportPicture(png, "Learned runs by the number of scores"),),),
        "\n".join([_about_needed(results), "", *(_answer(name, line) for name, line in lines.items())]),
    )


def _about_needed(results: Sequence[ScenarioResults]) -> str:
    targets = [item.scenario.target for item in results]
    limits = sorted({target.js for target in targets})
    limit = f"{limits[0]:g} nats" if len(limits) == 1 else f"its scenario's {limits[0]:g} to {limits[-1]:g} nats"
    later = sorted({item.scenario.name for item in results if item.scenario.target.since == "first liked"})
    about = f"A run has learned its preference once the learned density stays at most {limit} from that preference's."
    if not later:
        return about
    return f"{about} Scores count from the first liked model on for {', '.join(f'`{name}`' for name in later)}."


def _answer(name: str, line: NeededLabels) -> str:
    summary = summarize(list(line.stays))
    least, most = min(line.ends), max(line.ends)
    half = f"more than {least}" if summary.median is None else f"{summary.median:g}"
    need = "score is needed" if half == "1" else "scores are needed"
    of_runs = f"half of {summary.runs} runs" if summary.runs > 1 else "its only run"
    learned = "1 is" if summary.reached == 1 else f"{summary.reached or 'none'} are"
    after = f"{most}" if least == most else f"{least} to {most}"
    return f"- `{name}`: {half} {need} for {of_runs}; {learned} learned after {after}."


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
    drawn: dict[Path, SamplePictures] = {}
    on_progress("grids", 0, len(samples))

    def finish(_index: int, pictures: SamplePictures) -> None:
        drawn[pictures.scenario] = pictures
        on_progress("grids", len(drawn), len(samples))

    executor.run(partial(_draw_samples, folder, executor.share(len(samples))), samples.items(), finish)
    return drawn


def draw_examples(scenario: Path, folder: Path, executor: AbstractExecutor) -> Path:
    """Draw models of the labelled set for every case of a preference: a row per case, with its score and its meaning.

    Args:
        scenario: the scenario file.
        folder: folder for the picture; created if missing.
        executor: draws the picture, which does not depend on it.

    Returns:
        ``F1-scores.jpg``.

    Raises:
        GrammarlabError: If the scenario or its grammar has an error.
    """
    source = load_source(scenario)
    groups = [group for group in models_for_scores(source, COLUMNS) if group.models]
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / f"{source.scenario.name}-scores.jpg"
    save_picture(_draw_groups(source, groups, executor), path)
    return path


def models_for_scores(source: Source, num: int) -> tuple[LikedModels, ...]:
    """Models of the labelled set for every case of a scenario, the cases in their order and the others last.

    A product of factors has one group per score, an expression one per band of scores.

    Args:
        source: the scenario with its design space.
        num: largest number of models per group.

    Raises:
        UsageError: If the preference does not fit the design space.
        DerivationError: If a rule cannot be applied.
    """
    scenario, space = source.scenario, source.space
    scenario.check(space)
    labels, group_of = _grouping(source)
    members: list[list[int]] = [[] for _ in labels]
    first = 0
    for designs in space.sample(source.labelled_address.flat, scenario.num_models, scenario.seed):
        groups = group_of(designs)
        for group, models in enumerate(members):
            new = np.flatnonzero(groups == group)[: num - len(models)]
            models.extend((first + new).tolist())
        first += len(groups)
        if all(len(models) == num for models in members):
            break
    return tuple(
        LikedModels(score, means, tuple(models)) for (score, means), models in zip(labels, members, strict=True)
    )


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


def _row(pictures: tuple[ReportPicture, ...], folder: Path) -> str:
    images = [f"![{picture.title}]({_link(picture, folder)})" for picture in pictures]
    if len(images) == 1:
        return images[0]
    return markdown_table([picture.title for picture in pictures], [images]).rstrip("\n")


def _link(picture: ReportPicture, folder: Path) -> str:
    return Path(os.path.relpath(picture.file, folder)).as_posix()


def _copied(picture: ReportPicture, folder: Path) -> ReportPicture:
    folder.mkdir(parents=True, exist_ok=True)
    with atomic_file(folder / picture.file.name) as part:
        part.write_bytes(picture.file.read_bytes())
    return replace(picture, file=folder / picture.file.name)


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


def _draw_samples(folder: Path, executor: AbstractExecutor, item: tuple[Path, BeforeAfter]) -> SamplePictures:
    scenario, samples = item
    examples = draw_examples(scenario, folder, executor)
    return SamplePictures(scenario, examples, draw_grids(scenario, samples, folder, executor))


def _grouping(source: Source) -> tuple[list[tuple[float, str]], Callable[[Any], NDArray[np.intp]]]:
    """Score and meaning of the groups, and a function to the groups [n] of a batch of designs."""
    score, space = source.scenario.score, source.space
    if score.cases:
        decides = _deciding_case(score)
        labels = [*((case.value, case.means) for case in score.cases), (0.0, OTHERS)]
        return labels, lambda designs: decides.evaluate(space.values([designs], decides.features)).astype(np.intp)
    factors = [factor.score for factor in source.scenario.factors]
    if all(factor.levels for factor in factors):
        shares = product(*([level / 100 for level in factor.levels] for factor in factors))
        lowest = sorted({round(100 * float(np.prod(share)), 9) for share in shares}, reverse=True)
        labels = [(level, "") for level in lowest]
    else:
        lowest = list(BANDS)
        labels = [(low, f"{low:g} to {high:g}") for low, high in zip(BANDS, (100.0, *BANDS[:-1]), strict=True)]
    # Rounding may leave a score a little below its level.
    bounds = np.array(lowest[::-1]) - 1e-6

    def group_of(designs: Any) -> NDArray[np.intp]:
        values = score.evaluate(space.values([designs], score.features))
        return len(bounds) - np.searchsorted(bounds, values, side="right")

    return labels, group_of


def _deciding_case(score: Score) -> Expression:
    """Index of the case, from 0, that holds for a model; their number if none does."""
    names = {f"case_{i}": case.when for i, case in enumerate(score.cases)}
    pairs = ", ".join(f"{name}, {i}" for i, name in enumerate(names))
    return Expression.parse(f"choose({pairs}, {len(names)})", names)


def _draw_groups(source: Source, groups: list[LikedModels], executor: AbstractExecutor) -> np.ndarray:
    tiles = tiles_of(source, [model for group in groups for model in group.models], TILE_AREA, executor)
    drawn = iter(tiles.pictures)
    blank = np.full((tiles.height, tiles.width, 3), PAPER, np.uint8)
    cells, captions = [], []
    for group in groups:
        empty = COLUMNS - len(group.models)
        cells += [*(next(drawn) for _ in group.models), *[blank] * empty]
        # Once per row, which has room for it: below one picture a long meaning would be cut.
        captions += [(f"{group.score:g}   {group.means}", "")] + [("", "")] * (COLUMNS - 1)
    heading = (f"{source.scenario.name}: models and their scores", source.scenario.title)
    return draw_page(lay_out(len(cells), COLUMNS, tiles.width, tiles.height), cells, captions, heading)
