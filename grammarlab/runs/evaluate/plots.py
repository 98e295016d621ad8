"""Plots of the curves of a scenario, and grids of samples before and after learning (appendix B of the paper)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from textwrap import fill
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from grammarlab.evaluation.curves import LEARNED_JS, Curve
from grammarlab.evaluation.preparation import Source
from grammarlab.evaluation.respondents import EXACT
from grammarlab.evaluation.scenario import Scenario
from grammarlab.extras import named_extras
from grammarlab.files import atomic_file
from grammarlab.runs.evaluate.curve_store import CurveRecord
from grammarlab.runs.evaluate.samples import BeforeAfter
from grammarlab.runs.sample.contact_sheet import Tiles, draw_page, draw_tiles, lay_out
from grammarlab.runs.sample.sources import load_source
from grammarlab.runs.work.executors import AbstractExecutor
from grammarlab.scene import triangles

if TYPE_CHECKING:
    from matplotlib.figure import Figure

TILE_AREA = 144 * 144
"""Number of pixels of the picture of one model."""
SIZES = {4: TILE_AREA, 10: TILE_AREA // 5}
"""Number of models along each side of a grid, and of pixels of the picture of each."""
FLOOR = 1e-4
"""Lowest drawn divergence, in nats, since the axis is logarithmic; lower ones are drawn here."""
_QUALITY = 70
"""JPEG quality, 1 to 95, such that the pictures of all scenarios fit in a repository."""
# Okabe and Ito's palette, the strongest first; each line also has its own dash pattern.
_COLORS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000", "#F0E442")
_DASHES = ("-", "--", "-.", ":")
_BAND = (0.1, 0.9)
"""Quantiles over the runs at the ends of the band around a median."""
_SUFFIXES = (".png", ".svg")
_TITLE_WIDTH = 68
"""Largest number of characters of a line above a picture."""


@dataclass(frozen=True, slots=True)
class ScenarioResults:
    """The curves of one scenario and one error model."""

    scenario: Scenario
    records: tuple[CurveRecord, ...]
    """At least one; grouped by method, in the order of the request."""
    path: Path
    """The scenario file."""

    @property
    def js_original(self) -> float:
        """Divergence before learning, in nats: the median over seeds."""
        return float(np.median([record.js_original for record in self.records]))

    @property
    def person(self) -> str:
        """Error model of the scores: a name of `RESPONDENTS`."""
        return self.records[0].person

    @property
    def name(self) -> str:
        """Name of the results among all: that of the scenario for exact persons, otherwise such as ``F1.sd10``."""
        return self.scenario.name if self.person == EXACT.name else f"{self.scenario.name}.{self.person}"

    def by_method(self) -> dict[str, tuple[CurveRecord, ...]]:
        """The curves of each method, one per seed."""
        names = dict.fromkeys(record.method for record in self.records)
        return {name: tuple(record for record in self.records if record.method == name) for name in names}

    def counted(self, records: Sequence[CurveRecord]) -> list[Curve]:
        """Curves of the scenario, with labels counted from the start that its target defines."""
        later = self.scenario.target.since == "first liked"
        return [record.curve.since_first_liked() if later else record.curve for record in records]


@dataclass(frozen=True, slots=True)
class Series:
    """One line with its band."""

    label: str
    records: tuple[CurveRecord, ...]
    """The runs, one per seed; at least one."""


@dataclass(frozen=True, slots=True)
class NeededLabels:
    """The labels that the runs of a person and method needed, at least one run."""

    stays: tuple[int | None, ...]
    """From which number of labels on each run stays learned; None for a run that is not at its end."""
    ends: tuple[int, ...]
    """All labels of each run."""


def draw_grids(
    scenario: Path, samples: BeforeAfter, folder: Path, executor: AbstractExecutor
) -> dict[int, dict[str, Path]]:
    """Draw samples of the labelled set with their true scores.

    Args:
        scenario: the scenario file.
        samples: the samples; a small grid shows the first ones.
        folder: folder for the pictures; created if missing.
        executor: draws the pictures, which do not depend on it.

    Returns:
        ``F1-before-4x4.jpg`` and ``F1-after-4x4.jpg``, and the same with 10x10: by size, and then by stage.
    """
    source = load_source(scenario).for_person(samples.seed)
    name = source.scenario.name
    folder.mkdir(parents=True, exist_ok=True)
    stages = {
        "before": (samples.before, (f"{name} before learning", f"JS {samples.before.js:.3f}")),
        "after": (samples.after, (f"{name} after {samples.labels} labels", f"JS {samples.after.js:.4f}")),
    }
    files: dict[int, dict[str, Path]] = {size: {} for size in SIZES}
    for size, area in SIZES.items():
        num = size * size
        # Drawn together, so that pictures side by side have one shape.
        tiles = tiles_of(source, samples.before.models[:num] + samples.after.models[:num], area, executor)
        for index, (stage, (sample, heading)) in enumerate(stages.items()):
            captions = [(f"{score:.3g}", "") for score in sample.scores[:num]]
            page = lay_out(num, size, tiles.width, tiles.height)
            picture = draw_page(page, tiles.pictures[index * num : (index + 1) * num], captions, heading)
            files[size][stage] = folder / f"{name}-{stage}-{size}x{size}.jpg"
            save_picture(picture, files[size][stage])
    return files


def tiles_of(source: Source, models: Sequence[int], area: int, executor: AbstractExecutor) -> Tiles:
    """Pictures of labelled models, each rebuilt from its address; each fills its picture.

    Args:
        source: the scenario with its design space.
        models: indices in the labelled set; repeats are drawn once.
        area: approximate number of pixels of each picture.
        executor: draws the pictures, which do not depend on it.
    """
    different = sorted(set(models))
    batch = triangles(
        source.space.realize([source.labelled_address._replace(model=model) for model in different]).scene
    )
    tiles = draw_tiles([batch.model(index) for index in range(len(different))], area, executor)
    return replace(tiles, pictures=tuple(tiles.pictures[different.index(model)] for model in models))


def save_picture(picture: NDArray[np.uint8], path: Path) -> None:
    """Write pixels [height, width, 3] as JPEG, atomically."""
    with atomic_file(path) as part:
        Image.fromarray(picture).save(part, "JPEG", quality=_QUALITY, optimize=True, progressive=True)


def draw_curves(
    path: Path, title: str, series: Sequence[Series], *, close: float = LEARNED_JS, labels: str = "labels"
) -> tuple[Path, ...]:
    """Draw divergence against labels: the median over runs and a band between two quantiles.

    Args:
        path: path without a suffix; its folder is created if missing.
        title: text above the picture.
        series: at least one.
        close: target divergence, drawn as a horizontal line.
        labels: text below the axis of labels.

    Returns:
        The files, one for each of `_SUFFIXES`.

    Raises:
        UsageError: If matplotlib is not installed.
    """
    figure = _figure()
    axes = figure.subplots()
    for index, line in enumerate(series):
        counts, (low, median, high) = quantiles(line.records)
        color = _COLORS[index % len(_COLORS)]
        axes.plot(counts, median, _DASHES[index % len(_DASHES)], color=color, label=line.label, linewidth=1.8)
        axes.fill_between(counts, low, high, color=color, alpha=0.15, linewidth=0)
    axes.axhline(close, color="#777777", linewidth=0.8)
    axes.set_yscale("log")
    axes.set_ylim(FLOOR / 1.5, np.log(2))
    axes.set_xlim(left=0)
    axes.set_xlabel(labels)
    axes.set_ylabel("Jensen-Shannon divergence (nats)")
    axes.set_title(fill(title, _TITLE_WIDTH), fontsize=11)
    axes.spines[["top", "right"]].set_visible(False)
    axes.legend(frameon=False, fontsize=9)
    return _save(figure, path)


def draw_needed(path: Path, lines: Mapping[str, NeededLabels]) -> tuple[Path, ...]:
    """Draw how many runs have learned their preference for good by the number of labels.

    Args:
        path: path without a suffix; its folder is created if missing.
        lines: the runs of each line, which ends with its longest run.

    Returns:
        The files, one for each of `_SUFFIXES`.

    Raises:
        UsageError: If matplotlib is not installed.
    """
    figure = _figure()
    axes = figure.subplots()
    for index, (name, line) in enumerate(lines.items()):
        axes.step(
            *learned_shares(line),
            where="post",
            label=name,
            color=_COLORS[index % len(_COLORS)],
            linestyle=_DASHES[index % len(_DASHES)],
            linewidth=1.8,
        )
    axes.set_xlim(0, max(1, *(end for line in lines.values() for end in line.ends)))
    axes.set_ylim(0, 105)
    axes.set_xlabel("scores")
    axes.set_ylabel("% of runs that are learned")
    axes.spines[["top", "right"]].set_visible(False)
    axes.legend(frameon=False, fontsize=9, loc="lower right")
    return _save(figure, path)


def needed_labels(results: Sequence[ScenarioResults]) -> dict[str, NeededLabels]:
    """The runs of each person, or of each person and method if there are several methods.

    Each run counts to the divergence, and from the start, that the target of its scenario defines.
    """
    one_method = len({record.method for item in results for record in item.records}) == 1
    runs: dict[str, list[tuple[int | None, int]]] = {}
    for item in results:
        for method, records in item.by_method().items():
            name = item.person if one_method else f"{item.person}, {method}"
            runs.setdefault(name, []).extend(
                (curve.labels_until_below(item.scenario.target.js), curve.points[-1].labels if curve.points else 0)
                for curve in item.counted(records)
            )
    return {
        name: NeededLabels(tuple(stays for stays, _ in line), tuple(end for _, end in line))
        for name, line in runs.items()
    }


def learned_shares(line: NeededLabels) -> tuple[list[int], list[float]]:
    """Numbers of labels, from 0 to the end of the longest run, and the percentage of runs that are learned by then."""
    reached = sorted(count for count in line.stays if count is not None)
    shares = [100.0 * num / len(line.stays) for num in range(len(reached) + 1)]
    return [0, *reached, max(line.ends)], [*shares, shares[-1]]


def quantiles(records: Sequence[CurveRecord]) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """The labels at which any run has a round, from 0, and the low quantile, median and high quantile over the runs.

    A run counts up to its last round.

    Returns:
        Labels [k] and divergences [3, k] in nats, at least `FLOOR`.
    """
    labels = sorted({0, *(point.labels for record in records for point in record.curve.points)})
    values = np.array([[record.curve.js_at(count, record.js_original) for count in labels] for record in records])
    lasts = [record.curve.points[-1].labels if record.curve.points else 0 for record in records]
    values[np.array(labels) > np.array(lasts)[:, None]] = np.nan
    low, high = _BAND
    return np.array(labels), np.maximum(np.nanquantile(values, [low, 0.5, high], axis=0), FLOOR)


def _figure() -> Figure:
    with named_extras():
        from matplotlib.figure import Figure  # noqa: PLC0415 - an extra, and slow to load
    return Figure(figsize=(6.4, 4.2), dpi=140, layout="constrained")


def _save(figure: Figure, path: Path) -> tuple[Path, ...]:
    from matplotlib import rc_context  # noqa: PLC0415

    path.parent.mkdir(parents=True, exist_ok=True)
    files = tuple(path.with_name(path.name + suffix) for suffix in _SUFFIXES)
    for file in files:
        metadata: dict[str, Any] = {"Date": None} if file.suffix == ".svg" else {"Software": None}
        # Without salt and date, equal pictures are equal files.
        with atomic_file(file) as part, rc_context({"svg.hashsalt": "grammarlab"}):
            figure.savefig(part, metadata=metadata)
    return files
