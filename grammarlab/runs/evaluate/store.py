"""Finished curves on disk, one JSON line each: written whole, so that a run can be interrupted anywhere and resumed."""

from __future__ import annotations

import json
import math
import os
from dataclasses import dataclass
from pathlib import Path
from typing import TypeAlias

from grammarlab.errors import GrammarlabError
from grammarlab.evaluation.curves import Curve, Point

STORE = "curves.jsonl"
"""Name of the file in the folder of a run."""
MAX_BYTES = 1 << 28


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
    line = json.dumps(values, allow_nan=False) + "\n"
    with (folder / STORE).open("ab") as file:
        file.write(line.encode())
        file.flush()
        os.fsync(file.fileno())


Store: TypeAlias = dict[str, dict[int, CurveRecord]]
"""Curves by key, and then by the number of labels they were made for."""


def read(folder: Path) -> Store:
    """The curves of a folder, none when it holds no store.

    What a writer that was killed left of a last line is cut off.

    Raises:
        GrammarlabError: the store is not one of ours, or is larger than `MAX_BYTES`.
    """
    path = folder / STORE
    if not path.is_file():
        return {}
    if path.stat().st_size > MAX_BYTES:
        raise GrammarlabError(f"{path} is larger than {MAX_BYTES:,} bytes. Start again with --fresh.")
    content = path.read_bytes()
    whole = content.rfind(b"\n") + 1
    if whole < len(content):
        with path.open("r+b") as file:
            file.truncate(whole)
    records: Store = {}
    for number, line in enumerate(content[:whole].splitlines(), 1):
        record = _parse(line, path, number)
        add(records, record)
    return records


def add(store: Store, record: CurveRecord) -> None:
    """Put a curve where it belongs."""
    store.setdefault(record.key, {})[record.max_labels] = record


def clear(folder: Path) -> None:
    """Forget the curves of a folder."""
    (folder / STORE).unlink(missing_ok=True)


def _parse(line: bytes, path: Path, number: int) -> CurveRecord:
    try:
        values = json.loads(line)
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
    except (ValueError, KeyError, TypeError, OverflowError, RecursionError) as error:
        raise GrammarlabError(
            f"{path}:{number}: expected a curve as grammarlab writes it, found {line[:60]!r}. "
            "Start again with --fresh, or write into another folder."
        ) from error


def _finite(value: float) -> float:
    if not math.isfinite(value):
        raise ValueError(value)
    return float(value)
