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
WANTED = {
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
"""Method of the targets `WANTED`."""


def by_person(results: Sequence[ScenarioResults]) -> str:
    """The section of a page: a table for each folder of scenarios."""
    asked = max(point.labels for item in results for record in item.records for point in record.curve.points)
    after = [labels for labels in CHECKPOINTS if labels < asked] + [asked]
    folders = dict.fromkeys(item.path.absolute().parent for item in results)
    head = ("person", "method", "scenario", "original", *(f"after {labels}" for labels in after), "worst seed")
    seeds = max(len(records) for item in results for records in item.by_method().values())
    about = (
        "## By person\n\n"
        "Divergence in nats from what the person means after so many scores, worst cases first: medians over "
        f"{seeds} {'seeds' if seeds > 1 else 'seed'}, and the worst seed at the end. *exact* says what the scenario "
        "likes; *stars* rounds to 0, 25, 50, 75 and 100, and means that; *sd10* adds normal noise of 10 points; of the "
        "scores of *blunders5*, 5 % are random. *All* is the median over scenarios, *wanted* what the default method "
        "is to reach there, for scenarios that nobody has seen.\n"
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
            rows += [(person, method, "*wanted*", "", *_wanted(person, after), "")] if method == METHOD else []
        worst_first = sorted(own, key=lambda name: -np.median(own[name][:, -1]))
        rows += [(person, method, name, *_numbers(own[name])) for name in worst_first]
    return rows


def _numbers(js: NDArray[np.float64]) -> Iterable[str]:
    """Numbers from divergences [seeds, checkpoints]: the median over seeds, and the worst of the last column."""
    return (f"{number:.4f}" for number in (*np.median(js, axis=0), js[:, -1].max()))


def _wanted(person: str, after: Sequence[int]) -> list[str]:
    wanted: Mapping[int, float] = dict(zip(CHECKPOINTS, WANTED[person], strict=True))
    return [f"{wanted[labels]:.4f}" if labels in wanted else "" for labels in after]
