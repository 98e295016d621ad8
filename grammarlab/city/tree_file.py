"""Files of tree intensities: ``NAME.trees.json``, at most 100 kB.

```json
{"format": "grammarlab trees", "version": 1, "crs": "EPSG:32631", "origin": [448000, 5412000],
 "species": ["oak", "lime.toml"], "intercept": [2.7, 1.4], "kernel": {"kind": "matern 3/2", "lengths": [0.4, 0.8]},
 "places": [[0.1, 0.2]], "weights": [[0.3, -0.3]], "trees": "64 hexadecimal digits"}
```

Lengths and places are in km, places from the origin; `grammarlab.city.tree_intensity` has the formula. A species is the
name of a shipped one, or a file (.toml) relative to the folder of this file. A file may come from a stranger: its size
is bounded, and its values are checked before an intensity is made.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from grammarlab.city.json_values import MOST_CRS, JsonValueError, JsonValues, lines_of_json, values_of_json
from grammarlab.city.tree_intensity import TreeIntensity
from grammarlab.city.tree_names import MAX_SPECIES
from grammarlab.errors import AssetError, shown
from grammarlab.files import read_bounded, write_text
from grammarlab.geometry.footprints.frame import Frame

FORMAT = "grammarlab trees"
VERSION = 1
KERNEL = "matern 3/2"
MAX_BYTES = 100_000
"""Largest size of a file."""
_HASH = re.compile(r"[0-9a-f]{64}")


def save_trees(intensity: TreeIntensity, path: Path) -> None:
    """Write an intensity atomically.

    Raises:
        OSError: If it cannot be written.
    """
    write_text(path, trees_text(intensity))


def read_trees(path: Path) -> str:
    """The text of a file, checked.

    Raises:
        AssetError: If there is no such file, it is too large, or it is not such a file; the message names the value.
    """
    try:
        content = read_bounded(path, MAX_BYTES)
        parse_trees(content)
    except OSError as error:
        advice = "`grammarlab city learn --trees` writes such a file"
        raise AssetError(f"{path}: {error.strerror or error}; {advice}.") from error
    except JsonValueError as error:
        raise AssetError(f"{path}: {error}") from error
    return content.decode("utf-8")


def trees_text(intensity: TreeIntensity) -> str:
    """The text of a file: JSON with a line per key."""
    values = {
        "format": FORMAT,
        "version": VERSION,
        "crs": intensity.frame.crs,
        "origin": list(intensity.frame.origin),
        "species": list(intensity.species),
        "intercept": intensity.intercept.tolist(),
        "kernel": {"kind": KERNEL, "lengths": intensity.length.tolist()},
        "places": intensity.places.tolist(),
        "weights": intensity.weights.tolist(),
        "trees": intensity.trees,
    }
    return lines_of_json(values)


def parse_trees(content: bytes) -> TreeIntensity:
    """The intensity of a file.

    Raises:
        JsonValueError: If it is not such a file; the message names the value.
    """
    table = values_of_json(content, FORMAT, VERSION)
    species = _species(table)
    kernel = table.table("kernel")
    if kernel.get("kind") != KERNEL:
        raise JsonValueError(f"kernel.kind: expected {KERNEL!r}, found {shown(kernel.get('kind'))}.")
    length = np.array(kernel.numbers("lengths", len(species)))
    if not (length > 0.0).all():
        raise JsonValueError(f"kernel.lengths: expected numbers > 0, found {length.min():g}.")
    places = table.matrix("places", None, 2)
    east, north = table.numbers("origin", 2)
    trees = table.text("trees")
    if not _HASH.fullmatch(trees):
        raise JsonValueError(f"trees: expected 64 hexadecimal digits, found {shown(trees)}.")
    return TreeIntensity(
        species=species,
        frame=Frame(table.text("crs", MOST_CRS), (east, north)),
        intercept=np.array(table.numbers("intercept", len(species))),
        places=places,
        weights=table.matrix("weights", len(places), len(species)),
        length=length,
        trees=trees,
    )


def _species(table: JsonValues) -> tuple[str, ...]:
    species = tuple(table.texts("species", MAX_SPECIES))
    if not species or len(set(species)) != len(species) or "" in species:
        raise JsonValueError(f"species: expected different names, found {shown(', '.join(species))}.")
    return species
