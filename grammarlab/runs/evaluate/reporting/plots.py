"""Pictures of learning curves, PNG and SVG, in colours that colour-blind people can distinguish."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from textwrap import fill
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from grammarlab.evaluation.curves import CLOSE
from grammarlab.extras import named_extras
from grammarlab.files import atomic_file
from grammarlab.runs.evaluate.disk.store import CurveRecord

if TYPE_CHECKING:
    from matplotlib.figure import Figure

# Okabe and Ito's palette, the strongest first; each line also has its own dash pattern.
COLORS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000", "#F0E442")
DASHES = ("-", "--", "-.", ":")
FLOOR = 1e-4
"""Lowest drawn divergence, in nats, since the axis is logarithmic; lower ones are drawn here."""
BAND = (0.1, 0.9)
"""Quantiles over the runs at the ends of the band around a median."""
SUFFIXES = (".png", ".svg")
TITLE_WIDTH = 68
"""Largest number of characters of a line above a picture."""


@dataclass(frozen=True, slots=True)
class Series:
    """One line with its band."""

    label: str
    records: tuple[CurveRecord, ...]
    """The runs, one per seed; at least one."""


def draw_curves(
    path: Path, title: str, series: Sequence[Series], *, close: float = CLOSE, labels: str = "labels"
) -> tuple[Path, ...]:
    """Draw divergence against labels: the median over runs and a band between two quantiles.

    Args:
        path: path without a suffix; its folder is created if missing.
        title: text above the picture.
        series: at least one.
        close: target divergence, drawn as a horizontal line.
        labels: text below the axis of labels.

    Returns:
        The files, one for each of `SUFFIXES`.

    Raises:
        UsageError: If matplotlib is not installed.
    """
    figure = _figure()
    axes = figure.subplots()
    for index, line in enumerate(series):
        counts, (low, median, high) = quantiles(line.records)
        color = COLORS[index % len(COLORS)]
        axes.plot(counts, median, DASHES[index % len(DASHES)], color=color, label=line.label, linewidth=1.8)
        axes.fill_between(counts, low, high, color=color, alpha=0.15, linewidth=0)
    axes.axhline(close, color="#777777", linewidth=0.8)
    axes.set_yscale("log")
    axes.set_ylim(FLOOR / 1.5, np.log(2))
    axes.set_xlim(left=0)
    axes.set_xlabel(labels)
    axes.set_ylabel("Jensen-Shannon divergence (nats)")
    axes.set_title(fill(title, TITLE_WIDTH), fontsize=11)
    axes.spines[["top", "right"]].set_visible(False)
    axes.legend(frameon=False, fontsize=9)
    return _save(figure, path)


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
    low, high = BAND
    return np.array(labels), np.maximum(np.nanquantile(values, [low, 0.5, high], axis=0), FLOOR)


def _figure() -> Figure:
    with named_extras():
        from matplotlib.figure import Figure  # noqa: PLC0415 - an extra, and slow to load
    return Figure(figsize=(6.4, 4.2), dpi=140, layout="constrained")


def _save(figure: Figure, path: Path) -> tuple[Path, ...]:
    from matplotlib import rc_context  # noqa: PLC0415

    path.parent.mkdir(parents=True, exist_ok=True)
    files = tuple(path.with_name(path.name + suffix) for suffix in SUFFIXES)
    for file in files:
        metadata: dict[str, Any] = {"Date": None} if file.suffix == ".svg" else {"Software": None}
        # Without salt and date, equal pictures are equal files.
        with atomic_file(file) as part, rc_context({"svg.hashsalt": "grammarlab"}):
            figure.savefig(part, metadata=metadata)
    return files
