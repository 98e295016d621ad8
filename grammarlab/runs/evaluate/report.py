"""Tables of learning curves: Parquet for programs, Markdown for people, with the paper's results and the targets."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from numpy.typing import NDArray

from grammarlab.evaluation.curves import LEARNED_JS, Summary, summarize
from grammarlab.evaluation.scenario import SUFFIX, Scenario, ScenarioGoal
from grammarlab.files import atomic_file, write_text
from grammarlab.runs.evaluate.curve_store import CurveRecord
from grammarlab.runs.evaluate.pictures import Section, markdown
from grammarlab.runs.evaluate.plots import ScenarioResults
from grammarlab.tables import markdown_table

CHECKPOINTS = (64, 128, 256)
"""Numbers of scores after which persons are compared, in addition to all scores."""
TARGETS = {
    "exact": (0.03, 0.005, 0.001),
    "stars": (0.05, 0.012, 0.01),
    "sd5": (0.04, 0.01, 0.003),
    "sd10": (0.06, 0.02, 0.006),
    "sd20": (0.1, 0.06, 0.02),
    "blunders5": (0.07, 0.015, 0.002),
    "blunders10": (0.08, 0.02, 0.005),
}
"""Targets by consistent person: medians over scenarios, in nats, of the default method at each of `CHECKPOINTS`."""
TABLE = "results.parquet"
PAGE = "results.md"
_METHOD = "default"
"""Method of the targets `TARGETS`."""


def write_table(path: Path, records: Sequence[CurveRecord]) -> None:
    """Write all rounds of all curves as Parquet, one row per round.

    Columns: scenario, person, method, seed, labels, js and js_original (nats), correlation, liked.
    """
    rows = [(record, point) for record in records for point in record.curve.points]
    columns = {
        "scenario": pa.array([r.scenario for r, _ in rows], pa.string()),
        "person": pa.array([r.person for r, _ in rows], pa.string()),
        "method": pa.array([r.method for r, _ in rows], pa.string()),
        "seed": pa.array([r.seed for r, _ in rows], pa.uint64()),
        "labels": pa.array([p.labels for _, p in rows], pa.int64()),
        "js": pa.array([p.js for _, p in rows], pa.float64()),
        "correlation": pa.array([p.correlation for _, p in rows], pa.float64()),
        "liked": pa.array([p.liked for _, p in rows], pa.int64()),
        "js_original": pa.array([r.js_original for r, _ in rows], pa.float64()),
    }
    with atomic_file(path) as part, part.open("wb") as stream:
        pq.write_table(pa.table(columns), stream)


def write_page(
    path: Path,
    results: Sequence[ScenarioResults],
    pictures: Sequence[Section],
    command: str,
    sections: Sequence[str] = (),
    answer: Section | None = None,
) -> None:
    """Write everything as one Markdown page.

    Args:
        path: path of the page; pictures are linked relative to it.
        results: results in the order of the page.
        pictures: sections below all tables, in order.
        command: the command that writes the page.
        sections: Markdown to put below the tables.
        answer: section above all tables.
    """
    parts = [
        "# Results\n",
        *([markdown(answer, path.parent)] if answer else []),
        f"Written by `{command}`. Run the command again instead of editing this page.\n",
        _original_table(results),
        _by_person(results),
        _labels_table(results),
        *sections,
        *(markdown(section, path.parent) for section in pictures),
    ]
    write_text(path, "\n".join(parts))


def _original_table(results: Sequence[ScenarioResults]) -> str:
    rows = [
        (
            item.scenario.name,
            item.scenario.title,
            f"{item.js_original:.3f}",
            _number(item.scenario.paper.original, ".3f"),
            _difference(item.js_original, item.scenario.paper.original),
        )
        for item in _firsts(results)
    ]
    return (
        "## The tasks\n\n"
        "*original*: the Jensen-Shannon divergence in nats between the target density and the original grammar; "
        "*paper*: the same in the paper.\n\n"
        + markdown_table(("scenario", "liked models", "original", "paper", "difference"), rows)
    )


def _number(value: float | None, form: str = "g") -> str:
    return "" if value is None else format(value, form)


def _difference(value: float, reference: float | None) -> str:
    return "" if reference is None else f"{100 * (value / reference - 1):+.0f} %"


def _firsts(results: Sequence[ScenarioResults]) -> list[ScenarioResults]:
    """The results of each scenario for the first person."""
    firsts: dict[str, ScenarioResults] = {}
    for item in results:
        firsts.setdefault(item.scenario.name, item)
    return list(firsts.values())


def _by_person(results: Sequence[ScenarioResults]) -> str:
    """The section of a page: a table for each folder of scenarios."""
    max_labels = max(point.labels for item in results for record in item.records for point in record.curve.points)
    after = [labels for labels in CHECKPOINTS if labels < max_labels] + [max_labels]
    folders = dict.fromkeys(item.path.absolute().parent for item in results)
    head = ("person", "method", "scenario", "original", *(f"after {labels}" for labels in after), "worst seed")
    seeds = max(len(records) for item in results for records in item.by_method().values())
    about = (
        "## By person\n\n"
        "Divergence in nats from the person's target density, after 64, 128, … scores; the worst scenarios come "
        f"first. The numbers are medians over {seeds} {'seeds' if seeds > 1 else 'seed'}; the last column is the worst "
        "seed. *exact* gives the scores of the scenario; *stars* rounds them to 0, 25, 50, 75 and 100, and its target "
        "density is that of the rounded scores; *sd10* adds normal noise of 10 points; 5 % of the scores of "
        "*blunders5* are random. *all* is the median over scenarios. *target* is the goal for this median with the "
        "default method, on scenarios that were not used to tune it.\n"
    )
    parts = [about]
    for folder in folders:
        folder_results = [item for item in results if item.path.absolute().parent == folder]
        num_shown, num_scenarios = (
            len({item.scenario.name for item in folder_results}),
            len(list(folder.glob(f"*{SUFFIX}"))),
        )
        parts.append(f"### Scenarios of `{folder.name}`: {num_shown} of {num_scenarios}\n")
        parts.append(markdown_table(head, _rows(folder_results, after)))
    return "\n".join(parts)


def _rows(results: Sequence[ScenarioResults], after: Sequence[int]) -> list[tuple[str, ...]]:
    cases: dict[tuple[str, str], dict[str, NDArray[np.float64]]] = {}
    for item in results:
        for method, records in item.by_method().items():
            js = [[record.curve.js_at(labels, record.js_original) for labels in (0, *after)] for record in records]
            cases.setdefault((item.person, method), {})[item.scenario.name] = np.array(js)
    rows = []
    for (person, method), by_scenario in cases.items():
        if len(by_scenario) > 1:
            rows.append((person, method, "*all*", *_numbers(np.concatenate(list(by_scenario.values())))))
            rows += [(person, method, "*target*", "", *_targets(person, after), "")] if method == _METHOD else []
        worst_first = sorted(by_scenario, key=lambda name: -np.median(by_scenario[name][:, -1]))
        rows += [(person, method, name, *_numbers(by_scenario[name])) for name in worst_first]
    return rows


def _numbers(js: NDArray[np.float64]) -> Iterable[str]:
    """Numbers from divergences [seeds, checkpoints]: the median over seeds, and the worst of the last column."""
    return (f"{number:.4f}" for number in (*np.median(js, axis=0), js[:, -1].max()))


def _targets(person: str, after: Sequence[int]) -> list[str]:
    targets: Mapping[int, float] = dict(zip(CHECKPOINTS, TARGETS.get(person, ()), strict=False))
    return [f"{targets[labels]:.4f}" if labels in targets else "" for labels in after]


def _labels_table(results: Sequence[ScenarioResults]) -> str:
    rows, notes = [], []
    for item in results:
        target = item.scenario.target
        for method, records in item.by_method().items():
            curves = item.counted(records)
            first = summarize([curve.labels_to(target.js) for curve in curves])
            stays = summarize([curve.labels_until_below(target.js) for curve in curves])
            last = [record.curve.points[-1] for record in records]
            rows.append(
                (
                    item.scenario.name,
                    item.person,
                    method,
                    _summary(first),
                    _summary(stays),
                    _target(target, target.labels),
                    _target(target, target.aim),
                    _paper_labels(item.scenario, method),
                    f"{np.median([point.js for point in last]):.4f}",
                    f"{np.median([point.correlation for point in last]):.3f}",
                    f"{max(point.labels for point in last)}",
                )
            )
            if target.since == "first liked":
                notes.append(_first_liked(item, method, records))
    head = ("scenario", "person", "method", "first", "stays", "target", "aim", "paper")
    head += ("last JS", "correlation", "labels asked")
    return (
        "## Labels\n\n"
        f"Number of labels until the divergence is at most {LEARNED_JS:g} nats, or at most the scenario's own target: "
        "median over seeds (lowest–highest; seeds that reach it/all seeds). *first* counts to the first round that "
        "reaches this limit, *stays* to the round from which all rounds keep it. *target*, *aim* and *paper* are "
        "numbers of labels. *last JS* and *correlation* are medians after all labels.\n\n"
        + markdown_table(head, rows)
        + "".join(f"\n{note}\n" for note in notes)
    )


def _summary(summary: Summary) -> str:
    if not summary.reached:
        return f"never (0/{summary.runs})"
    median = "–" if summary.median is None else f"{summary.median:g}"
    highest = "never" if summary.highest is None else f"{summary.highest}"
    return f"**{median}** ({summary.lowest}–{highest}; {summary.reached}/{summary.runs})"


def _target(target: ScenarioGoal, labels: int | None) -> str:
    later = labels is not None and target.since == "first liked"
    return _number(labels) + " from the first liked model on" * later


def _paper_labels(scenario: Scenario, method: str) -> str:
    if method.startswith("kde"):
        return _number(scenario.paper.kde_labels)
    return _number(scenario.paper.labels)


def _first_liked(item: ScenarioResults, method: str, records: Sequence[CurveRecord]) -> str:
    """A note on a row that does not count all labels."""
    before = summarize([record.curve.labels_before_first_liked() for record in records])
    return (
        f"{item.name}, {method}: *first* and *stays* count from the first liked model on, with all labels of the "
        f"round that showed it. Before that round, {_summary(before)} labels had been given."
    )
