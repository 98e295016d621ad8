"""Shards of a city: squares whose buildings are derived and written in one task, with a record when all is written."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Sequence
from contextlib import ExitStack
from dataclasses import asdict, dataclass
from hashlib import sha256
from itertools import chain
from pathlib import Path
from typing import IO, Any

import numpy as np
import pyarrow as pa
import shapely
from numpy.typing import NDArray

from grammarlab.about import __version__
from grammarlab.arrays import Floats, Ints
from grammarlab.city.parcels import Outlines
from grammarlab.city.sites import Sites
from grammarlab.errors import AssetError
from grammarlab.export.cityjson import CityBuilding, building_line
from grammarlab.export.model_files import whole_file
from grammarlab.export.tiles.earth_placement import EarthPlacement
from grammarlab.export.tiles.tile_grid import TileCell, TileGrid, morton
from grammarlab.export.tiles.tile_models import TileModels
from grammarlab.export.tiles.tile_shard import ShardSummary, write_shard
from grammarlab.files import file_below, read_bounded, write_text
from grammarlab.runs.city.zone_rules import MadeBuildings, ZoneRules, make_buildings
from grammarlab.scene.instances import Scene
from grammarlab.scene.joined import joined, of_models

FOLDER = "shards"
"""Folder with one folder for each shard."""
RECORD = "record.json"
CITYJSON = "buildings.jsonl"
"""Lines of CityJSON of a shard."""
_MAX_BYTES = 1 << 26
"""Largest size of a record in bytes."""
_BUILDINGS_AT_ONCE = 128
"""Buildings that are derived together: enough for columns to be fast, few enough for their memory."""


@dataclass(frozen=True, eq=False, kw_only=True)
class ShardTask:
    """Buildings of one shard. A worker gets it whole."""

    folder: Path
    """Folder of the city."""
    cell: TileCell
    grid: TileGrid
    placement: EarthPlacement
    zones: tuple[ZoneRules, ...]
    """Rules of the zones of the plan, by number."""
    sites: Sites
    """[S] sites in Morton order of their leaves, then by id; those of parks are left out."""
    ids: NDArray[np.object_]
    """[S] ids of their parcels."""
    lots: Outlines
    """[S] their footprints as polygons in metres of the frame, for CityJSON."""
    cityjson: bool = False
    """Whether lines of CityJSON are written as well."""

    def __str__(self) -> str:
        return f"shard {self.cell.x}, {self.cell.y} with {len(self.sites)} parcels"

    @property
    def home(self) -> Path:
        """Folder of the shard."""
        return shard_folder(self.folder, self.cell)

    def key(self) -> str:
        """SHA-256 of all that decides about the files of the shard."""
        sites = self.sites
        parts: list[Any] = [__version__, self.cell, self.grid, self.placement, self.cityjson]
        used = np.unique(sites.zone).tolist()
        parts += [(zone, self.zones[zone].zone, self.zones[zone].hash) for zone in used]
        digest = sha256(repr(parts).encode("utf-8", "surrogatepass"))
        columns = (sites.zone, sites.seed, sites.model, sites.reroll, sites.corner, sites.plinth)
        columns = (*columns, sites.footprints.points, sites.footprints.offsets, sites.footprints.street_width)
        for column in columns:
            digest.update(b"" if column is None else np.ascontiguousarray(column).tobytes())
        for name, column in sorted(sites.attributes.items()):
            digest.update(repr((name, column.values.tolist(), column.is_given.tolist())).encode())
        digest.update(repr((self.ids.tolist(), sites.start_rule.tolist())).encode("utf-8", "surrogatepass"))
        return digest.hexdigest()


@dataclass(frozen=True, kw_only=True)
class ShardRecord:
    """A finished shard."""

    key: str
    num_tiles: int
    num_bytes: int
    most_draws: int
    """Largest number of draws of a tile."""
    failures: dict[str, str]
    """Messages by ids of the parcels whose buildings could not be derived."""
    reports: dict[str, dict[str, float]]
    """Sums of reported values by ids of parcels, then by key."""
    missing_assets: tuple[str, ...] = ()
    """Paths of missing meshes."""


def shard_folder(folder: Path, cell: TileCell) -> Path:
    """Folder of a shard in the folder of a city."""
    return folder / FOLDER / f"{cell.x}_{cell.y}"


def read_record(folder: Path, cell: TileCell) -> ShardRecord | None:
    """The record of a shard; None if it is missing or damaged."""
    path = file_below(folder, f"{FOLDER}/{cell.x}_{cell.y}/{RECORD}")
    try:
        values = json.loads(read_bounded(path, _MAX_BYTES)) if path else {}
        return ShardRecord(**{**values, "missing_assets": tuple(values["missing_assets"])})
    except (AssetError, OSError, ValueError, TypeError, KeyError, AttributeError, RecursionError):
        return None


def build_shard(task: ShardTask) -> ShardRecord:
    """Derive the buildings of a shard and write its tiles; its record comes last."""
    (task.home / RECORD).unlink(missing_ok=True)
    with ExitStack() as stack:
        # One building has up to megabytes of lines, so they do not wait in memory.
        lines = stack.enter_context(whole_file(task.home / CITYJSON)).stream if task.cityjson else None
        builder = _Builder(task, lines)
        leaves = builder.leaves()
        first = next(leaves, None)
        # Nothing can be built, or the rules make nothing.
        summary = None if first is None else _written(task, chain([first], leaves))
    record = ShardRecord(
        key=task.key(),
        num_tiles=summary.num_tiles if summary else 0,
        num_bytes=summary.num_bytes if summary else 0,
        most_draws=summary.most_draws if summary else 0,
        failures=builder.failures,
        reports=builder.reports,
        missing_assets=tuple(sorted(builder.missing_assets)),
    )
    write_text(task.home / RECORD, json.dumps(asdict(record), ensure_ascii=False) + "\n")
    return record


def _written(task: ShardTask, leaves: Iterable[tuple[TileCell, TileModels]]) -> ShardSummary:
    return write_shard(task.folder, task.grid, task.placement, task.cell, leaves)


class _Builder:
    """Derives the buildings of a shard, leaf by leaf, and collects what is known of them."""

    def __init__(self, task: ShardTask, lines: IO[bytes] | None) -> None:
        self._task = task
        self._ids: list[str] = task.ids.tolist()
        self.failures: dict[str, str] = {}
        self.reports: dict[str, dict[str, float]] = {}
        self.missing_assets: set[str] = set()
        self._lines = lines

    def leaves(self) -> Iterator[tuple[TileCell, TileModels]]:
        """Leaves with their buildings, in Morton order."""
        cells = self._task.grid.leaves(self._task.sites.corner)
        code = morton(cells)
        starts = np.flatnonzero(np.diff(code, prepend=-1)).tolist()
        ends = [*starts[1:], len(code)]
        group: list[tuple[int, int]] = []
        for start, end in zip(starts, ends, strict=True):
            group.append((start, end))
            if end - group[0][0] >= _BUILDINGS_AT_ONCE or end == len(code):
                yield from self._group(group, cells)
                group = []

    def _group(self, spans: Sequence[tuple[int, int]], cells: Ints) -> Iterator[tuple[TileCell, TileModels]]:
        """Some leaves, derived together zone by zone."""
        first, last = spans[0][0], spans[-1][1]
        rows = np.arange(first, last)
        made = [
            (rows[here], make_buildings(self._task.zones[zone], self._task.sites.take(rows[here])))
            for zone in np.unique(self._task.sites.zone[rows]).tolist()
            for here in [np.flatnonzero(self._task.sites.zone[rows] == zone)]
        ]
        for zone_rows, buildings in made:
            self._note(zone_rows, buildings)
        for start, end in spans:
            cell = TileCell(self._task.grid.leaf_level, *cells[start].tolist())
            tile = self._tile(cell, start, end, made)
            if tile is not None:
                yield cell, tile

    def _tile(
        self, cell: TileCell, start: int, end: int, made: Sequence[tuple[Ints, MadeBuildings]]
    ) -> TileModels | None:
        """The buildings of one leaf, by zone and then in the order of the sites; None if there are none."""
        scenes, rows = list[Scene](), list[Ints]()
        for zone_rows, buildings in made:
            sites = zone_rows[buildings.row]
            here = np.flatnonzero((sites >= start) & (sites < end))
            if len(here) and buildings.scene is not None:
                scenes.append(of_models(buildings.scene, here))
                rows.append(sites[here])
                if self._lines is not None:
                    self._lines.writelines(self._cityjson(buildings, here, sites[here]))
        if not scenes:
            return None
        scene, row = joined(scenes), np.concatenate(rows)
        offset = self._task.sites.corner[row] + scene.origins - self._task.grid.origin(cell)
        return TileModels(scene, offset, self._properties(row, scene))

    def _properties(self, rows: Ints, scene: Scene) -> pa.Table:
        sites, zones = self._task.sites, self._task.zones
        return pa.table(
            {
                "id": pa.array([self._ids[row] for row in rows.tolist()], pa.string()),
                "zone": pa.array([zones[zone].zone for zone in sites.zone[rows].tolist()], pa.string()),
                "seed": pa.array(map(str, sites.seed[rows].tolist()), pa.string()),
                "model": pa.array(map(str, sites.model[rows].tolist()), pa.string()),
                "reroll": pa.array(sites.reroll[rows], pa.int32()),
                "height": pa.array(heights_of(scene).astype(np.float32), pa.float32()),
            }
        )

    def _note(self, rows: Ints, buildings: MadeBuildings) -> None:
        ids = self._ids
        for row, message in buildings.failures.items():
            self.failures[ids[rows[row]]] = message
        for row, report in zip(buildings.row.tolist(), buildings.reports, strict=True):
            if report:
                self.reports[ids[rows[row]]] = dict(report)
        self.missing_assets.update(missing.path for missing in buildings.missing_assets)

    def _cityjson(self, buildings: MadeBuildings, models: Ints, rows: Ints) -> Iterator[bytes]:
        """Lines of CityJSON of some buildings."""
        sites, scene = self._task.sites, buildings.scene
        if scene is None:
            return
        ends = np.searchsorted(scene.model, np.arange(scene.num_models + 1))
        lots: list[shapely.Polygon] = self._task.lots.tolist()
        for model, row in zip(models.tolist(), rows.tolist(), strict=True):
            alone = of_models(scene, np.array([model]))
            corner = sites.corner[row] + alone.origins[0]
            building = CityBuilding(
                id=self._ids[row],
                footprint=lots[row],
                ground=float(corner[1]),
                scene=alone,
                corner=corner,
                labels=buildings.labels.take(slice(*ends[model : model + 2])),
                attributes={
                    "zone": self._task.zones[sites.zone[row]].zone,
                    "seed": str(sites.seed[row]),
                    "model": str(sites.model[row]),
                    "reroll": int(sites.reroll[row]),
                },
                plinth=float(sites.plinth[row]),
            )
            yield building_line(building)


def heights_of(scene: Scene) -> Floats:
    """[num_models] highest point of each model above its origin, in metres; 0 for one without instances."""
    low, high = scene.meshes.bounds()
    ends = np.stack([low, high])[:, scene.mesh] * scene.size
    up = scene.frames[scene.frame, 1]
    top = scene.position[:, 1] + np.maximum(ends[0] * up, ends[1] * up).sum(axis=1)
    heights = np.zeros(scene.num_models)
    np.maximum.at(heights, scene.model, top)
    return heights
