"""Summaries of the reports of each model by key, as in CityEngine."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np

from grammarlab.derivation.forest import Forest

Summary: TypeAlias = dict[str, float | int | None]
"""``count``, and ``sum``, ``mean``, ``min`` and ``max``: None if reported values are not finite numbers."""


def summarize_reports(forest: Forest) -> list[dict[str, Summary]]:
    """Summaries of the values of each key of each model, keys in alphabetical order."""
    found: list[dict[str, Summary]] = [{} for _ in range(forest.num_models)]
    reports = forest.reports
    model = forest.nodes.model[reports.node].astype(np.int64)
    order = np.lexsort((reports.key, model))
    groups, starts = np.unique((model * max(len(reports.keys), 1) + reports.key)[order], return_index=True)
    for group, values in zip(groups.tolist(), np.split(reports.value[order], starts[1:]), strict=False):
        key = reports.keys[group % len(reports.keys)]
        found[group // len(reports.keys)][key] = _summary(values)
    return found


def _summary(values: np.ndarray) -> Summary:
    count, total = len(values), float(values.sum())
    if not np.isfinite(total):
        return {"count": count, "sum": None, "mean": None, "min": None, "max": None}
    return {
        "count": count,
        "sum": total,
        "mean": total / count,
        "min": float(values.min()),
        "max": float(values.max()),
    }
