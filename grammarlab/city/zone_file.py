"""Files of zone densities: ``NAME.zones.json``, at most 100 kB.

```json
{"format": "grammarlab zones", "version": 1, "crs": "EPSG:32631", "origin": [448000, 5412000],
 "zones": ["office", "downtown"],
 "features": [{"name": "area", "unit": "m²", "mean": 5.5, "scale": 0.7, "log": true},
              {"name": "distance to a centre", "unit": "km", "mean": 0.8, "scale": 0.8, "centre": [0.41, 0.52]}],
 "intercept": [0.2, -0.2], "slopes": [[1.1, -1.1], [0.4, -0.4]],
 "kernel": {"kind": "matern 3/2", "length": 0.9, "scale": 1.5}, "places": [[0.1, 0.2]], "weights": [[0.3, -0.3]],
 "counts": [[1, 0]], "offsets": [[0.2, -0.2]], "answers": "64 hexadecimal digits"}
```

Lengths and places are in km, places from the origin; `grammarlab.city.zone_density` has the formula. A file may come
from a stranger: its size is bounded, and its values are checked before a density is made.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np

from grammarlab.city.json_values import MOST_CRS, JsonValueError, JsonValues, lines_of_json, values_of_json
from grammarlab.city.zone_density import MAX_WEIGHTS, Feature, ZoneDensity
from grammarlab.errors import AssetError, shown
from grammarlab.files import read_bounded, write_text
from grammarlab.geometry.footprints.frame import Frame

SUFFIX = ".zones.json"
FORMAT = "grammarlab zones"
VERSION = 2
KERNEL = "matern 3/2"
MAX_BYTES = 100_000
"""Largest size of a file."""
_MOST_ZONES, _MOST_FEATURES = 64, 256
_MOST_ANSWERS, _MOST_SCALE = 1e6, 100.0
"""Most answers of a place, and the largest scale: with more, draws would be numbers without digits."""
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
    except JsonValueError as error:
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
        "kernel": {"kind": KERNEL, "length": density.length, "scale": density.scale},
        "places": density.places.tolist(),
        "weights": density.weights.tolist(),
        "counts": density.counts.tolist(),
        "offsets": density.offsets.tolist(),
        "answers": density.answers,
    }
    return lines_of_json(values)


def parse_zones(content: bytes) -> ZoneDensity:
    """The density of a file.

    Raises:
        AssetError: If it is not such a file; the message names the value.
    """
    table = values_of_json(content, FORMAT, VERSION)
    zones = tuple(table.texts("zones", _MOST_ZONES))
    if len(zones) < 2 or len(set(zones)) != len(zones) or "" in zones:
        raise JsonValueError(f"zones: expected at least two different names, found {shown(', '.join(zones))}.")
    intercept = np.array(table.numbers("intercept", len(zones)))
    features = tuple(_feature(item) for item in table.tables("features", _MOST_FEATURES))
    places = table.matrix("places", None, 2)
    if len(places) * len(zones) > MAX_WEIGHTS:
        raise JsonValueError(f"places: expected at most {MAX_WEIGHTS // len(zones)}, found {len(places)}.")
    weights = table.matrix("weights", len(places), len(zones))
    counts = table.matrix("counts", len(places), len(zones))
    outside = counts[(counts < 0.0) | (counts > _MOST_ANSWERS)]
    if len(outside):
        raise JsonValueError(f"counts: expected numbers from 0 to {_MOST_ANSWERS:g}, found {outside[0]:g}.")
    kernel = table.table("kernel")
    if kernel.get("kind") != KERNEL:
        raise JsonValueError(f"kernel.kind: expected {KERNEL!r}, found {shown(kernel.get('kind'))}.")
    east, north = table.numbers("origin", 2)
    answers = table.text("answers")
    if not _HASH.fullmatch(answers):
        raise JsonValueError(f"answers: expected 64 hexadecimal digits, found {shown(answers)}.")
    return ZoneDensity(
        zones=zones,
        frame=Frame(table.text("crs", MOST_CRS), (east, north)),
        features=features,
        intercept=intercept,
        slope=table.matrix("slopes", len(features), len(zones)),
        places=places,
        weights=weights,
        length=kernel.positive("length"),
        scale=kernel.amount("scale", _MOST_SCALE),
        counts=counts,
        offsets=table.matrix("offsets", len(places), len(zones)),
        answers=answers,
    )


def _feature_values(feature: Feature) -> dict[str, Any]:
    values: dict[str, Any] = {"name": feature.name, "unit": feature.unit, "mean": feature.mean, "scale": feature.scale}
    if feature.is_log:
        values["log"] = True
    if feature.centre is not None:
        values["centre"] = list(feature.centre)
    return values


def _feature(table: JsonValues) -> Feature:
    east_north = table.numbers("centre", 2) if "centre" in table.values else None
    is_log = table.values.get("log", False)
    if not isinstance(is_log, bool):
        raise JsonValueError(f"{table.where}log: expected true or false, found {shown(is_log)}.")
    return Feature(
        name=table.text("name"),
        unit=table.text("unit"),
        mean=table.number("mean"),
        scale=table.positive("scale"),
        is_log=is_log,
        centre=None if east_north is None else (east_north[0], east_north[1]),
    )
