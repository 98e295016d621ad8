"""Building a city: from a plan to tiles, a table of parcels, and buildings as CityJSON."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryFile
from time import perf_counter

import numpy as np

from grammarlab.about import __version__
from grammarlab.city.plan import read_plan
from grammarlab.export.cityjson import CityJsonWriter, Level
from grammarlab.export.tiles.city_tileset import TILESET, write_city
from grammarlab.export.tiles.composite_tileset import write_together
from grammarlab.export.tiles.earth_placement import EarthPlacement
from grammarlab.export.tiles.tile_grid import TileCell, TileGrid
from grammarlab.files import write_text
from grammarlab.geometry.footprints.footprint import Remark
from grammarlab.runs.city.city_clearing import clear_city
from grammarlab.runs.city.parcel_listing import ParcelListing
from grammarlab.runs.city.shard import ShardRecord, build_shard, kept_shard, lines_of
from grammarlab.runs.city.shard_tasks import ShardTasks
from grammarlab.runs.city.site_store import SiteStore
from grammarlab.runs.city.survey import Survey, surveyed
from grammarlab.runs.city.tree_places import TreePlaces, tree_places
from grammarlab.runs.city.tree_tiles import TILESET as TREES_TILESET
from grammarlab.runs.city.tree_tiles import clear_trees, write_trees
from grammarlab.runs.city.zone_rules import ZoneRules
from grammarlab.runs.work.executors import SERIAL, AbstractExecutor
from grammarlab.runs.work.results import Progress
from grammarlab.runs.work.run_folder import only_run_in

PARCELS = "parcels.parquet"
BUILDINGS = "city.city.jsonl"
CITY = "city.json"
"""What was built: version, plan, frame and zones."""
FAILED = "failed"
"""Reason of parcels whose building could not be derived."""
BUILDINGS_TILESET = "buildings.json"
"""Tileset of the buildings, where there are trees."""


@dataclass(frozen=True, slots=True, kw_only=True)
class CityResult:
    """A built city."""

    folder: Path
    num_parcels: int
    num_built: int
    empty: Mapping[str, int]
    """Numbers of empty parcels by reason, most first."""
    num_tiles: int
    num_reused: int
    """Number of shards that were built before."""
    most_draws: int
    """Largest number of draws of a tile."""
    seconds: float
    failures: Mapping[str, str]
    """Messages by ids of parcels whose buildings could not be derived."""
    missing_assets: tuple[str, ...]
    remarks: tuple[Remark, ...]

    @property
    def tileset(self) -> Path:
        """The root of the tiles, which is missing if nothing is built."""
        return self.folder / TILESET

    @property
    def table(self) -> Path:
        """The table of all parcels."""
        return self.folder / PARCELS


@dataclass(frozen=True, slots=True, kw_only=True)
class BuildOptions:
    """Which files a city has."""

    implicit: bool
    """Whether the tileset is implicit."""
    cityjson: tuple[Level, ...]
    """Levels of detail of `BUILDINGS`."""


def build_city(
    plan: Path,
    folder: Path,
    *,
    executor: AbstractExecutor = SERIAL,
    cityjson: tuple[Level, ...] = (),
    implicit: bool = False,
    on_progress: Progress = lambda _what, _done, _total: None,
) -> CityResult:
    """Build the city of a plan.

    A shard that was built before from the same sites and rules is kept, so a stopped run goes on, and a change costs
    the shards that it concerns.

    Args:
        plan: file of the plan.
        folder: made if missing; the files of an earlier city in it are replaced.
        executor: builds the shards; the files do not depend on it.
        cityjson: levels of detail of `BUILDINGS`, which is not written if there are none.
        implicit: write an implicit tileset.
        on_progress: called after every finished shard.

    Raises:
        GrammarlabError: If the plan, one of its files, or the folder cannot be used.
    """
    start = perf_counter()
    read = read_plan(plan)
    zones = tuple(ZoneRules.of(zone) for zone in read.zones)
    street_trees = None if read.street_trees is None else ZoneRules.along_streets(read.street_trees)
    for zone, rules in zip(read.zones, zones, strict=True):
        rules.check(sorted(zone.attributes))
    survey = surveyed(read, zones)
    grid = TileGrid.around(survey.sites.corner)
    placement = EarthPlacement(survey.parcels.frame, read.geoid_height or 0.0)
    with only_run_in(folder), TemporaryFile(dir=folder) as file:
        store = SiteStore(file, survey.sites, grid)
        # From here on, memory does not hold the sites of buildings, and hardly grows with their number.
        survey = survey.without_buildings([rules.is_park for rules in zones])
        ids = survey.parcels.id
        tasks = ShardTasks(
            folder=folder, grid=grid, placement=placement, zones=zones, store=store, ids=ids, cityjson=cityjson
        )
        records, num_reused = _built(tasks, executor.in_folder(folder), on_progress)
        shards = {cell: record.tree for cell, record in zip(tasks.cells, records, strict=True)}
        clear_city(folder, grid, shards, (TILESET, BUILDINGS_TILESET, *(() if cityjson else (BUILDINGS,))))
        trees = tree_places(survey, zones, street_trees, folder)
        written = {cell: tree for cell, tree in shards.items() if tree}
        num_tiles = _write_tilesets(tasks, written, trees, seed=read.seed, implicit=implicit)
        failures = {name: message for record in records for name, message in record.failures.items()}
        reason = _reasons(survey, failures)
        reports = {name: report for record in records for name, report in record.reports.items()}
        listing = ParcelListing(survey=survey, zones=zones, grid=grid, store=store, reason=reason, reports=reports)
        listing.write(folder / PARCELS)
        if cityjson:
            _write_buildings(folder / BUILDINGS, survey, tasks)
        _write_city(folder / CITY, survey, zones, BuildOptions(implicit=implicit, cityjson=cityjson))
    empty = Counter(reason[reason != ""].tolist())
    return CityResult(
        folder=folder,
        num_parcels=len(survey.parcels),
        num_built=int((reason == "").sum()),
        empty=dict(empty.most_common()),
        num_tiles=num_tiles,
        num_reused=num_reused,
        most_draws=max((record.most_draws for record in records), default=0),
        seconds=perf_counter() - start,
        failures=failures,
        missing_assets=tuple(sorted({path for record in records for path in record.missing_assets})),
        remarks=survey.remarks,
    )


def _built(tasks: ShardTasks, executor: AbstractExecutor, on_progress: Progress) -> tuple[list[ShardRecord], int]:
    """The records of all shards, in order, and how many were built before."""
    records = {number: record for number, task in enumerate(tasks) if (record := kept_shard(task)) is not None}
    num_reused = len(records)
    missing = [number for number in range(len(tasks)) if number not in records]
    on_progress("shards", num_reused, len(tasks))

    def then(index: int, record: ShardRecord) -> None:
        records[missing[index]] = record
        on_progress("shards", len(records), len(tasks))

    executor.run(build_shard, (tasks[number] for number in missing), then)
    return [records[number] for number in range(len(tasks))], num_reused


def _write_tilesets(
    tasks: ShardTasks, shards: Mapping[TileCell, str], trees: Sequence[TreePlaces], *, seed: int, implicit: bool
) -> int:
    """Write the tilesets of buildings and of trees, and one of both; the number of all tiles.

    An implicit tileset is one of buildings alone: it cannot refer to others.
    """
    folder, grid, placement = tasks.folder, tasks.grid, tasks.placement
    are_together = bool(trees) and not implicit
    name = BUILDINGS_TILESET if are_together else TILESET
    num_tiles = write_city(folder, grid, placement, shards, implicit=implicit, name=name) if shards else 0
    if not trees:
        clear_trees(folder)
        return num_tiles
    num_tiles += write_trees(folder, trees, grid, placement, seed)
    if are_together:
        write_together(folder / TILESET, (BUILDINGS_TILESET, TREES_TILESET) if shards else (TREES_TILESET,))
    return num_tiles


def _reasons(survey: Survey, failures: Mapping[str, str]) -> np.ndarray:
    reason = survey.reason.copy()
    reason[np.isin(survey.parcels.id, list(failures))] = FAILED
    return reason


def _write_buildings(path: Path, survey: Survey, tasks: ShardTasks) -> None:
    """Join the lines of all shards."""
    with CityJsonWriter(path, survey.parcels.frame) as writer:
        for task in tasks:
            for lines in lines_of(task):
                writer.add_lines(lines)


def _write_city(path: Path, survey: Survey, zones: Sequence[ZoneRules], options: BuildOptions) -> None:
    plan, frame = survey.plan, survey.parcels.frame
    values = {
        "grammarlab": __version__,
        "plan": str(plan.path.resolve()),
        "crs": frame.crs,
        "origin": list(frame.origin),
        "seed": str(plan.seed),
        "implicit": options.implicit,
        "cityjson": list(options.cityjson),
        "zones": {rules.zone: {"grammar": rules.name, "hash": rules.hash} for rules in zones},
        "remarks": [str(remark) for remark in survey.remarks],
    }
    write_text(path, json.dumps(values, indent=1, ensure_ascii=False) + "\n")
