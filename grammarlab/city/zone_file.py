"""Files of zone densities: ``NAME.zones.json``, at most 100 kB.

```json
{"format": "grammarlab zones", "version": 1, "crs": "EPSG:32631", "origin": [448000, 5412000],
 "zones": ["office", "downtown"],
 "features": [{"name": "area", "unit": "m²", "mean": 5.5, "scale": 0.7, "log": true},
              {"name": "distance to a centre", "unit": "km", "mean": 0.8, "scale": 0.8, "centre": [0.41, 0.52]}],
 "intercept": [0.2, -0.2], "slopes": [[1.1, -1.1], [0.4, -0.4]],
 "kernel": {"kind": "matern 3/2", "length": 0.9}, "places": [[0.1, 0.2]], "weights": [[0.3, -0.3]],
 "answers": "64 hexadecimal digits"}
```

Lengths and places are in km, places from the origin; `grammarlab.city.zone_density` has the formula. A file may come
from a stranger: its size is bounded, and its values are checked before a density is made.
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from grammarlab.arrays import Floats
from grammarlab.city.zone_density import Feature, ZoneDensity
from grammarlab.errors import AssetError, shown
from grammarlab.files import read_bounded, write_text
from grammarlab.geometry.footprints.frame import Frame

SUFFIX = ".zones.json"
FORMAT = "grammarlab zones"
VERSION = 1
KERNEL = "matern 3/2"
MAX_BYTES = 100_000
"""Largest size of a file."""
_MOST_TEXT, _MOST_CRS = 256, 20_000
"""Most characters of a name, and of a coordinate system, which may be WKT."""
_MOST_ZONES, _MOST_FEATURES, _MOST_PLACES = 64, 256, 1024
_LARGEST = 1e9
"""Largest size of a number, for sums without overflow."""
_HASH = re.compile(r"[0-9a-f]{64}")


def save_zones(density: ZoneDensity, path: Path) -> None:
    """Write a density atomically.

    Raises:
        AssetError: If the file would be larger than `MAX_BYTES`.
        OSError: If it cannot be written.
    """
    text = zones_text(density)
    if len(text.encode()) > MAX_BYTES:
        raise AssetError(
            f"{path}: expected at most {MAX_BYTES:,} bytes, found {len(text.encode()):,}: learn fewer zones."
        )
    write_text(path, text)


def read_zones(path: Path) -> ZoneDensity:
    """Read a density.

    Raises:
        AssetError: If there is no such file, it is too large, or it is not such a file; the message names the value.
    """
    try:
        return parse_zones(read_bounded(path, MAX_BYTES))
    except OSError as error:
        raise AssetError(f"{path}: {error.strerror or error}; `grammarlab city learn` writes such a file.") from error
    except _ValueError as error:
        raise AssetError(f"{path}: {error}") from error


def zones_text(density: ZoneDensity) -> str:
    """The text of a file: JSON with a line per key."""
    values = {
        "format": FORMAT,
        "version": VERSION,
        "crs": density.frame.crs,
        "origin": list(density.frame.origin),
        "zones": list(density.zones),
        "features": [_feature_values(feature) for feature in density.features],
        "intercept": density.intercept.tolist(),
        "slopes": density.slope.tolist(),
        "kernel": {"kind": KERNEL, "length": density.length},
        "places": density.places.tolist(),
        "weights": density.weights.tolist(),
        "answers": density.answers,
    }
    lines = [f"{json.dumps(key)}: {json.dumps(value, ensure_ascii=False)}" for key, value in values.items()]
    return "{" + ",\n ".join(lines) + "}\n"


def parse_zones(content: bytes) -> ZoneDensity:
    """The density of a file.

    Raises:
        AssetError: If it is not such a file; the message names the value.
    """
    table = _Values(_json(content), "")
    if table.get("format") != FORMAT:
        raise _ValueError(f"format: expected {FORMAT!r}, found {shown(table.get('format'))}.")
    if table.get("version") != VERSION:
        raise _ValueError(f"version: expected {VERSION}, found {shown(table.get('version'))}: update grammarlab.")
    zones = tuple(table.texts("zones", _MOST_ZONES))
    if len(zones) < 2 or len(set(zones)) != len(zones) or "" in zones:
        raise _ValueError(f"zones: expected at least two different names, found {shown(', '.join(zones))}.")
    features = tuple(_feature(item) for item in table.tables("features", _MOST_FEATURES))
    places = table.matrix("places", None, 2)
    kernel = table.table("kernel")
    if kernel.get("kind") != KERNEL:
        raise _ValueError(f"kernel.kind: expected {KERNEL!r}, found {shown(kernel.get('kind'))}.")
    east, north = table.numbers("origin", 2)
    answers = table.text("answers")
    if not _HASH.fullmatch(answers):
        raise _ValueError(f"answers: expected 64 hexadecimal digits, found {shown(answers)}.")
    return ZoneDensity(
        zones=zones,
        frame=Frame(table.text("crs", _MOST_CRS), (east, north)),
        features=features,
        intercept=np.array(table.numbers("intercept", len(zones))),
        slope=table.matrix("slopes", len(features), len(zones)),
        places=places,
        weights=table.matrix("weights", len(places), len(zones)),
        length=kernel.positive("length"),
        answers=answers,
    )


def _feature_values(feature: Feature) -> dict[str, Any]:
    values: dict[str, Any] = {"name": feature.name, "unit": feature.unit, "mean": feature.mean, "scale": feature.scale}
    if feature.is_log:
        values["log"] = True
    if feature.centre is not None:
        values["centre"] = list(feature.centre)
    return values


def _feature(table: _Values) -> Feature:
    east_north = table.numbers("centre", 2) if "centre" in table.values else None
    is_log = table.values.get("log", False)
    if not isinstance(is_log, bool):
        raise _ValueError(f"{table.where}log: expected true or false, found {shown(is_log)}.")
    return Feature(
        name=table.text("name"),
        unit=table.text("unit"),
        mean=table.number("mean"),
        scale=table.positive("scale"),
        is_log=is_log,
        centre=None if east_north is None else (east_north[0], east_north[1]),
    )


class _ValueError(AssetError):
    """A value that is not as expected; the name of the file is added where it is caught."""


class _Values:
    """Checked values of an object."""

    def __init__(self, values: Any, where: str) -> None:
        if not isinstance(values, dict):
            raise _ValueError(f"{where[:-1] or 'file'}: expected an object, found {shown(values)}.")
        self.values: dict[str, Any] = values
        self.where = where

    def get(self, key: str) -> Any:
        if key not in self.values:
            raise _ValueError(f"{self.where}{key}: expected a value, found none.")
        return self.values[key]

    def text(self, key: str, most: int = _MOST_TEXT) -> str:
        return self._text(self.get(key), key, most)

    def texts(self, key: str, most: int) -> list[str]:
        return [self._text(item, f"{key}[{index}]", _MOST_TEXT) for index, item in enumerate(self._items(key, most))]

    def number(self, key: str) -> float:
        return self._number(self.get(key), key)

    def positive(self, key: str) -> float:
        number = self.number(key)
        if number < 1 / _LARGEST:
            raise _ValueError(f"{self.where}{key}: expected a number > 0, found {number:g}.")
        return number

    def numbers(self, key: str, count: int) -> list[float]:
        return self._row(self.get(key), key, count)

    def matrix(self, key: str, count: int | None, width: int) -> Floats:
        rows = self._items(key, _MOST_PLACES)
        if count is not None and len(rows) != count:
            raise _ValueError(f"{self.where}{key}: expected {count} rows, found {len(rows)}.")
        checked = [self._row(row, f"{key}[{index}]", width) for index, row in enumerate(rows)]
        return np.array(checked, np.float64).reshape(-1, width)

    def table(self, key: str) -> _Values:
        return _Values(self.get(key), f"{self.where}{key}.")

    def tables(self, key: str, most: int) -> list[_Values]:
        return [_Values(item, f"{self.where}{key}[{index}].") for index, item in enumerate(self._items(key, most))]

    def _items(self, key: str, most: int) -> Sequence[Any]:
        items = self.get(key)
        if not isinstance(items, list) or len(items) > most:
            raise _ValueError(f"{self.where}{key}: expected a list of at most {most}, found {shown(items)}.")
        return items

    def _row(self, value: Any, key: str, count: int) -> list[float]:
        if not isinstance(value, list) or len(value) != count:
            raise _ValueError(f"{self.where}{key}: expected {count} numbers, found {shown(value)}.")
        return [self._number(item, f"{key}[{index}]") for index, item in enumerate(value)]

    def _number(self, value: Any, key: str) -> float:
        # Integers of many digits are compared before they are made floats, which they may not fit.
        is_number = isinstance(value, int | float) and not isinstance(value, bool)
        if not is_number or not -_LARGEST <= value <= _LARGEST or math.isnan(value):
            raise _ValueError(f"{self.where}{key}: expected a number of at most {_LARGEST:g}, found {shown(value)}.")
        return float(value)

    def _text(self, value: Any, key: str, most: int) -> str:
        if not isinstance(value, str) or len(value) > most or not value.isprintable():
            raise _ValueError(f"{self.where}{key}: expected a line of at most {most} characters, found {shown(value)}.")
        return value


def _json(content: bytes) -> Any:
    try:
        return json.loads(content)
    except RecursionError as error:
        raise _ValueError("this JSON is nested too deep.") from error
    except ValueError as error:  # invalid text, encoding, or an integer of too many digits
        raise _ValueError(f"this is not valid JSON: {error}.") from error
