"""Divergence for each person, worst cases first, with the targets."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from grammarlab.evaluation.scenario import SUFFIX
from grammarlab.runs.evaluate.reporting.scenario_results import ScenarioResults
from grammarlab.runs.markdown import table

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
"""By person: target for the median over scenarios, in nats, of the default method at each of `CHECKPOINTS`."""
METHOD = "default"
"""Method of the targets `TARGETS`."""


def by_person(results: Sequence[ScenarioResults]) -> str:
    """The section of a page: a table for each folder of scenarios."""
    asked = max(point.labels for item in results for record in item.records for point in record.curve.points)
    after = [labels for labels in CHECKPOINTS if labels < asked] + [asked]
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
        own = [item for item in results if item.path.absolute().parent == folder]
        shown, there = len({item.scenario.name for item in own}), len(list(folder.glob(f"*{SUFFIX}")))
        parts.append(f"### Scenarios of `{folder.name}`: {shown} of {there}\n")
        parts.append(table(head, _rows(own, after)))
    return "\n".join(parts)


def _rows(results: Sequence[ScenarioResults], after: Sequence[int]) -> list[tuple[str, ...]]:
    cases: dict[tuple[str, str], dict[str, NDArray[np.float64]]] = {}
    for item in results:
        for method, records in item.by_method().items():
            js = [[record.curve.js_at(labels, record.js_original) for labels in (0, *after)] for record in records]
            cases.setdefault((item.person, method), {})[item.scenario.name] = np.array(js)
    rows = []
    for (person, method), own in cases.items():
        if len(own) > 1:
            rows.append((person, method, "*all*", *_numbers(np.concatenate(list(own.values())))))
            rows += [(person, method, "*target*", "", *_targets(person, after), "")] if method == METHOD else []
        worst_first = sorted(own, key=lambda name: -np.median(own[name][:, -1]))
        rows += [(person, method, name, *_numbers(own[name])) for name in worst_first]
    return rows


def _numbers(js: NDArray[np.float64]) -> Iterable[str]:
    """Numbers from divergences [seeds, checkpoints]: the median over seeds, and the worst of the last column."""
    return (f"{number:.4f}" for number in (*np.median(js, axis=0), js[:, -1].max()))


def _targets(person: str, after: Sequence[int]) -> list[str]:
    targets: Mapping[int, float] = dict(zip(CHECKPOINTS, TARGETS[person], strict=True))
    return [f"{targets[labels]:.4f}" if labels in targets else "" for labels in after]
