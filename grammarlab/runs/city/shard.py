"""Shards of a city: squares that are built in one task, in which only changed quads are derived again."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property
from hashlib import sha256
from itertools import pairwise
from pathlib import Path

import numpy as np

from grammarlab.about import __version__
from grammarlab.export.cityjson import Level
from grammarlab.export.model_files import whole_file
from grammarlab.export.tiles.branch_file import read_tree
from grammarlab.export.tiles.earth_placement import EarthPlacement
from grammarlab.export.tiles.explicit_tileset import SHARD_TILESET, shard_folder
from grammarlab.export.tiles.tile_branch import TileWriter
from grammarlab.export.tiles.tile_grid import TileCell, morton
from grammarlab.export.tiles.tile_shard import branch_path, has_files, shard_keys, write_quad, write_shard
from grammarlab.export.tiles.tile_tree import TileNode
from grammarlab.files import file_hash, remove_parts
from grammarlab.runs.city.quad import (
    QUADS,
    Quad,
    QuadRecord,
    lines_path,
    quad_key,
    read_quad,
    record_name,
)
from grammarlab.runs.city.quad_buildings import QuadBuildings, SitesOfShard, quad_buildings
from grammarlab.runs.city.record_file import read_record, write_record

FOLDER = "shards"
"""Folder with one folder for each shard."""
RECORD = "record.json"
_CODEC = "zstd"
_AT_ONCE = 1 << 20
"""Bytes of lines that are read together."""


@dataclass(frozen=True, eq=False, kw_only=True)
class ShardTask:
    """Buildings of one shard. A worker gets it whole."""

    folder: Path
    """Folder of the city."""
    cell: TileCell
    placement: EarthPlacement
    source: SitesOfShard
    """The sites without those of parks, and their rules."""
    cityjson: tuple[Level, ...] = ()
    """Levels of detail of the lines of CityJSON; no lines are written if there are none."""

    def __str__(self) -> str:
        return f"shard {self.cell.x}, {self.cell.y} with {len(self.source.sites)} parcels"

    @property
    def home(self) -> Path:
        """Folder of the shard."""
        return self.folder / shard_folder(self.cell)

    @cached_property
    def quads(self) -> tuple[Quad, ...]:
        """The quads of the sites, in Morton order."""
        source, grid = self.source, self.source.grid
        cells = grid.leaves(source.sites.corner) >> (grid.leaf_level - grid.quad_level)
        starts = np.flatnonzero(np.diff(morton(cells), prepend=-1)).tolist()
        return tuple(
            Quad(TileCell(grid.quad_level, *cells[first].tolist()), first, last, self._key(first, last))
            for first, last in pairwise([*starts, len(cells)])
        )

    def key(self) -> str:
        """SHA-256 of all that decides about the files of the shard."""
        return sha256(repr([quad.key for quad in self.quads]).encode()).hexdigest()

    def _key(self, first: int, last: int) -> str:
        source = self.source
        sites = source.sites.take(np.arange(first, last))
        rules = [(zone, source.zones[zone].zone, source.zones[zone].hash) for zone in np.unique(sites.zone).tolist()]
        return quad_key(
            [__version__, self.cell, source.grid, self.placement, self.cityjson, rules], sites, source.ids[first:last]
        )


@dataclass(frozen=True, kw_only=True)
class ShardRecord:
    """A finished shard."""

    key: str
    tree: str
    """Key of its tree of tiles (`shard_keys`); empty without tiles."""
    tileset: str
    """SHA-256 of its tileset; empty without tiles."""
    num_tiles: int
    num_bytes: int
    most_draws: int
    """Largest number of draws of a tile."""
    failures: dict[str, str]
    """Messages by ids of the parcels whose buildings could not be derived."""
    reports: dict[str, dict[str, float]]
    """Sums of reported values by ids of parcels, then by key."""
    missing_assets: tuple[str, ...]
    """Paths of missing meshes."""


def kept_shard(task: ShardTask) -> ShardRecord | None:
    """The record of a shard that was built before from the same sites and rules; None if a file of it is missing."""
    record = read_record(task.home, RECORD, ShardRecord)
    if record is None or record.key != task.key():
        return None
    if record.tree:
        node = read_tree(branch_path(task.folder, task.source.grid, task.cell), record.tree)
        if node is None or not has_files(task.folder, node) or _hash(task.home / SHARD_TILESET) != record.tileset:
            return None
    if task.cityjson and any(_kept_quad(task, quad) is None for quad in task.quads):
        return None
    return record


def build_shard(task: ShardTask) -> ShardRecord:
    """Derive the buildings of the quads of a shard that are not kept, and write its tiles; its record comes last."""
    (task.home / RECORD).unlink(missing_ok=True)
    writer = TileWriter(task.folder, task.source.grid, task.placement, task.cell)
    records = {quad.cell: record for quad in task.quads if (record := _kept_quad(task, quad)) is not None}
    missing = [quad for quad in task.quads if quad.cell not in records]
    for buildings in quad_buildings(task.source, missing):
        records[buildings.quad.cell] = _built_quad(task, writer, buildings)
    quads = {quad.cell: quad.key for quad in task.quads if records[quad.cell].has_tiles}
    keys = shard_keys(task.source.grid, task.cell, quads)
    _drop_stale(task, keys)
    node = write_shard(writer, task.cell, quads) if quads else None
    if node is None:
        (task.home / SHARD_TILESET).unlink(missing_ok=True)
    record = _record(task, node, keys.get(task.cell, ""), [records[quad.cell] for quad in task.quads])
    write_record(task.home, RECORD, record)
    return record


def lines_of(task: ShardTask) -> Iterator[bytes]:
    """Lines of CityJSON of a finished shard, in pieces."""
    import pyarrow as pa  # noqa: PLC0415  # takes long to import

    for quad in task.quads:
        with pa.input_stream(str(lines_path(task.home, quad.cell)), compression=_CODEC) as stream:
            while piece := stream.read(_AT_ONCE):
                yield piece


def _kept_quad(task: ShardTask, quad: Quad) -> QuadRecord | None:
    """The record of a quad that was built before from the same sites and rules; None if a file of it is missing."""
    record = read_quad(task.home, quad)
    if record is None:
        return None
    if record.has_tiles:
        node = read_tree(branch_path(task.folder, task.source.grid, quad.cell), quad.key)
        if node is None or not has_files(task.folder, node):
            return None
    return record if not record.lines or _hash(lines_path(task.home, quad.cell)) == record.lines else None


def _built_quad(task: ShardTask, writer: TileWriter, buildings: QuadBuildings) -> QuadRecord:
    """Write the files of a quad; its record comes last."""
    quad = buildings.quad
    (task.home / record_name(quad.cell)).unlink(missing_ok=True)
    leaves = buildings.leaves()
    if leaves:
        write_quad(writer, quad.cell, quad.key, leaves)
    record = QuadRecord(
        key=quad.key,
        has_tiles=bool(leaves),
        lines=_write_lines(lines_path(task.home, quad.cell), buildings.lines(task.cityjson)) if task.cityjson else "",
        failures=buildings.failures(),
        reports=buildings.reports(),
        missing_assets=buildings.missing_assets(),
    )
    write_record(task.home, record_name(quad.cell), record)
    return record


def _write_lines(path: Path, lines: Iterable[bytes]) -> str:
    """Write lines compressed, one at a time in memory; SHA-256 of the file."""
    import pyarrow as pa  # noqa: PLC0415  # takes long to import

    with whole_file(path) as output, pa.CompressedOutputStream(pa.PythonFile(output.stream, "w"), _CODEC) as stream:
        for line in lines:
            stream.write(line)
    return file_hash(path)


def _record(task: ShardTask, node: TileNode | None, tree: str, quads: list[QuadRecord]) -> ShardRecord:
    files = list(node.files()) if node else []
    return ShardRecord(
        key=task.key(),
        tree=tree,
        tileset=_hash(task.home / SHARD_TILESET) if node else "",
        num_tiles=len(files),
        num_bytes=sum(file.num_bytes for file in files),
        most_draws=max((file.draws for file in files), default=0),
        failures={name: message for quad in quads for name, message in quad.failures.items()},
        reports={name: report for quad in quads for name, report in quad.reports.items()},
        missing_assets=tuple(sorted({path for quad in quads for path in quad.missing_assets})),
    )


def _drop_stale(task: ShardTask, keys: Mapping[TileCell, str]) -> None:
    """Remove files of quads and branches that the shard no longer has, and what killed builds left unfinished."""
    grid, home = task.source.grid, task.home
    current = {home / record_name(quad.cell) for quad in task.quads}
    current |= {lines_path(home, quad.cell) for quad in task.quads if task.cityjson}
    current |= {branch_path(task.folder, grid, cell) for cell in keys}
    for folder in (home / QUADS, branch_path(task.folder, grid, task.cell).parent):
        if folder.is_dir():
            remove_parts(folder)
            for path in folder.iterdir():
                if path not in current and path.suffix in {".json", ".zst", ".branch"}:
                    path.unlink()
    remove_parts(home)


def _hash(path: Path) -> str:
    """SHA-256 of a file; empty if it cannot be read."""
    with suppress(OSError):
        return file_hash(path)
    return ""
