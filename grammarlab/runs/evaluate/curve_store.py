"""Finished curves and other measurements on disk."""

from __future__ import annotations

import hashlib
import json
import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from grammarlab.evaluation.curves import Curve, Point
from grammarlab.evaluation.respondents import EXACT
from grammarlab.runs.work.results import Kind, Results, adopt_lines, json_kind

STORE = "curves"
"""Folder of the curves in the folder of a run; with the suffix .jsonl, the file of earlier versions."""
_MEASUREMENT: Kind[dict[str, Any]] = json_kind(dict, dict)


@dataclass(frozen=True, slots=True)
class CurveRecord:
    """One finished curve."""

    key: str
    """SHA-256 of all inputs of the curve except the number of labels."""
    scenario: str
    method: str
    seed: int
    max_labels: int
    """Requested number of labels; the curve is shorter if the pool is used up."""
    js_original: float
    """Divergence before learning, in nats."""
    curve: Curve
    person: str = EXACT.name
    """Error model of the scores: a name of `RESPONDENTS`."""

    @property
    def curve_name(self) -> str:
        """Name of the curve among all curves: its key and number of labels."""
        return f"{self.key}-{self.max_labels}"


def measurements_in(folder: Path, name: str, *, fresh: bool = False) -> Results[dict[str, Any]]:
    """The measurements of a folder, JSON objects by key.

    Args:
        folder: folder of a run.
        name: name of the folder in it; with the suffix .jsonl, of the file of earlier versions.
        fresh: remove stored measurements first.
    """
    results, earlier = Results(folder / name, _MEASUREMENT), (folder / name).with_suffix(".jsonl")
    if fresh:
        results.clear()
        earlier.unlink(missing_ok=True)
    adopt_lines(results, earlier, lambda entry: (str(entry["key"]), dict(entry["values"])))
    return results


def digest(values: object) -> str:
    """SHA-256 of JSON values, as a key."""
    return hashlib.sha256(json.dumps(values, sort_keys=True).encode()).hexdigest()


def curves_in(folder: Path, *, fresh: bool = False) -> Results[CurveRecord]:
    """The curves of a folder, by their places.

    Args:
        folder: folder of a run.
        fresh: remove stored curves first.
    """
    curves, earlier = Results(folder / STORE, _KIND), (folder / STORE).with_suffix(".jsonl")
    if fresh:
        curves.clear()
        earlier.unlink(missing_ok=True)
    adopt_lines(curves, earlier, _earlier)
    return curves


def _as_json(record: CurveRecord) -> dict[str, Any]:
    return {
        "key": record.key,
        "scenario": record.scenario,
        "method": record.method,
        "person": record.person,
        "seed": record.seed,
        "max_labels": record.max_labels,
        "js_original": record.js_original,
        "curve": [list(point) for point in record.curve.points],
    }


def _parse(values: Any) -> CurveRecord:
    points = tuple(
        Point(int(labels), _finite(js), _finite(corr), int(liked)) for labels, js, corr, liked in values["curve"]
    )
    return CurveRecord(
        key=str(values["key"]),
        scenario=str(values["scenario"]),
        method=str(values["method"]),
        seed=int(values["seed"]),
        max_labels=int(values["max_labels"]),
        js_original=_finite(values["js_original"]),
        curve=Curve(points),
        person=str(values.get("person", EXACT.name)),
    )


_KIND = json_kind(_as_json, _parse)


def _finite(value: float) -> float:
    if not math.isfinite(value):
        raise ValueError(value)
    return float(value)


def _earlier(entry: Any) -> tuple[str, CurveRecord]:
    record = _parse(entry)
    return record.curve_name, record
