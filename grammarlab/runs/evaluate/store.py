"""Finished curves on disk, one JSON line each: written whole, so that a run can be interrupted anywhere and resumed."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeAlias

from grammarlab.evaluation.curves import Curve, Point
from grammarlab.runs.evaluate import json_lines

STORE = "curves.jsonl"
"""Name of the file in the folder of a run."""


@dataclass(frozen=True, slots=True)
class CurveRecord:
    """One finished curve."""

    key: str
    """SHA-256 of everything that decides the curve but the number of labels."""
    scenario: str
    method: str
    seed: int
    max_labels: int
    """What the curve was made for; it may end before where the pool is used up."""
    js_original: float
    """Divergence in nats before anything is learned."""
    curve: Curve


def append(folder: Path, record: CurveRecord) -> None:
    """Add a curve; after this returns it survives a crash of the machine."""
    values = {
        "key": record.key,
        "scenario": record.scenario,
        "method": record.method,
        "seed": record.seed,
        "max_labels": record.max_labels,
        "js_original": record.js_original,
        "curve": [list(point) for point in record.curve.points],
    }
    json_lines.append(folder / STORE, values)


Store: TypeAlias = dict[str, dict[int, CurveRecord]]
"""Curves by key, and then by the number of labels they were made for."""


def read(folder: Path) -> Store:
    """The curves of a folder, none when it holds no store.

    What a writer that was killed left of a last line is cut off.

    Raises:
        GrammarlabError: the store is not one of ours, or is too large.
    """
    records: Store = {}
    for record in json_lines.read(folder / STORE, _parse, "a curve"):
        add(records, record)
    return records


def add(store: Store, record: CurveRecord) -> None:
    """Put a curve where it belongs."""
    store.setdefault(record.key, {})[record.max_labels] = record


def clear(folder: Path) -> None:
    """Forget the curves of a folder."""
    (folder / STORE).unlink(missing_ok=True)


def _parse(values: Any) -> CurveRecord:
    points = tuple(
        Point(int(labels), _finite(js), _finite(corr), int(liked)) for labels, js, corr, liked in values["curve"]
    )
    return CurveRecord(
        str(values["key"]),
        str(values["scenario"]),
        str(values["method"]),
        int(values["seed"]),
        int(values["max_labels"]),
        _finite(values["js_original"]),
        Curve(points),
    )


def _finite(value: float) -> float:
    if not math.isfinite(value):
        raise ValueError(value)
    return float(value)
