"""Quads of a shard: squares of 256 m that are kept while their sites and rules stay the same, each with a record."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np

from grammarlab.city.sites import Sites
from grammarlab.export.tiles.tile_grid import TileCell
from grammarlab.runs.city.record_file import read_record

QUADS = "quads"
"""Folder of the records of quads below the folder of a shard."""


@dataclass(frozen=True, slots=True)
class Quad:
    """Sites of one quad."""

    cell: TileCell
    first: int
    """First row of its sites in those of the shard."""
    last: int
    """Row after the last one."""
    key: str
    """SHA-256 of all that decides about its buildings and tiles."""

    def __len__(self) -> int:
        return self.last - self.first


@dataclass(frozen=True, kw_only=True)
class QuadRecord:
    """A finished quad."""

    key: str
    has_tiles: bool
    """False if nothing could be built, or the rules make nothing."""
    lines: str
    """SHA-256 of the file of its lines of CityJSON; empty without."""
    failures: dict[str, str]
    """Messages by ids of the parcels whose buildings could not be derived."""
    reports: dict[str, dict[str, float]]
    """Sums of reported values by ids of parcels, then by key."""
    missing_assets: tuple[str, ...]
    """Paths of missing meshes, ascending."""


def quad_key(general: Sequence[Any], sites: Sites, ids: Sequence[str]) -> str:
    """Key of a quad.

    Args:
        general: what else decides about the tiles, with a complete `repr`.
        sites: [S] its sites.
        ids: [S] ids of their parcels.
    """
    digest = sha256(repr(general).encode("utf-8", "surrogatepass"))
    columns = (sites.zone, sites.seed, sites.model, sites.reroll, sites.corner, sites.plinth)
    columns = (*columns, sites.footprints.points, sites.footprints.offsets, sites.footprints.street_width)
    for column in columns:
        digest.update(b"" if column is None else np.ascontiguousarray(column).tobytes())
    for name, column in sorted(sites.attributes.items()):
        if column.is_given.any():
            given = zip(column.values.tolist(), column.is_given.tolist(), strict=True)
            digest.update(repr((name, [value if is_given else None for value, is_given in given])).encode())
    digest.update(repr((list(ids), sites.start_rule.tolist())).encode("utf-8", "surrogatepass"))
    return digest.hexdigest()


def lines_path(home: Path, cell: TileCell) -> Path:
    """File of the lines of CityJSON of a quad in the folder of its shard, compressed by zstd."""
    return home / QUADS / f"{cell.x}_{cell.y}.jsonl.zst"


def read_quad(home: Path, quad: Quad) -> QuadRecord | None:
    """The record of a quad; None if it is missing, damaged, or has another key."""
    record = read_record(home, record_name(quad.cell), QuadRecord)
    return record if record is not None and record.key == quad.key else None


def record_name(cell: TileCell) -> str:
    """Path of the record of a quad below the folder of its shard."""
    return f"{QUADS}/{cell.x}_{cell.y}.json"
