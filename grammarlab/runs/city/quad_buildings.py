"""Buildings of the quads of a shard: several quads are derived together, zone by zone, and each is given by itself."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import pyarrow as pa
import shapely

from grammarlab.arrays import Floats, Ints
from grammarlab.city.sites import Sites
from grammarlab.export.cityjson import CityBuilding, Level, building_line
from grammarlab.export.tiles.tile_grid import TileCell, TileGrid, morton
from grammarlab.export.tiles.tile_models import TileModels
from grammarlab.runs.city.quad import Quad
from grammarlab.runs.city.survey import lot_outlines
from grammarlab.runs.city.zone_rules import MadeBuildings, ZoneRules, make_buildings
from grammarlab.scene.instances import Scene
from grammarlab.scene.joined import joined, of_models

_BUILDINGS_AT_ONCE = 160
"""Most buildings of several quads that are derived together: enough for columns to be fast, few for their memory."""


@dataclass(frozen=True, eq=False, kw_only=True)
class SitesOfShard:
    """What the buildings of a shard are derived from."""

    grid: TileGrid
    zones: Sequence[ZoneRules]
    """Rules of the zones of the plan, by number."""
    sites: Sites
    """[S] sites in Morton order of their leaves, then by id."""
    ids: Sequence[str]
    """[S] ids of their parcels."""


@dataclass(frozen=True, eq=False)
class QuadBuildings:
    """The derived buildings of one quad."""

    source: SitesOfShard
    quad: Quad
    _made: Sequence[tuple[Ints, MadeBuildings]]
    """Rows of sites and what was made on them, by zone; with those of other quads."""

    def leaves(self) -> list[tuple[TileCell, TileModels]]:
        """Leaves that have buildings, in Morton order."""
        return [
            (cell, tile) for cell, first, last in self._spans() if (tile := self._tile(cell, first, last)) is not None
        ]

    def lines(self, levels: tuple[Level, ...]) -> Iterator[bytes]:
        """Lines of CityJSON of all buildings, leaf by leaf.

        Args:
            levels: levels of detail of the lines.
        """
        for _, first, last in self._spans():
            for buildings, models, rows in self._built(first, last):
                yield from self._lines(buildings, models, rows, levels)

    def failures(self) -> dict[str, str]:
        """Messages by ids of the parcels whose buildings could not be derived."""
        return {
            self.source.ids[site]: message
            for rows, buildings in self._made
            for row, message in buildings.failures.items()
            if self._is_here(site := int(rows[row]))
        }

    def reports(self) -> dict[str, dict[str, float]]:
        """Sums of reported values by ids of parcels, then by key."""
        return {
            self.source.ids[site]: dict(report)
            for rows, buildings in self._made
            for row, report in zip(buildings.row, buildings.reports, strict=True)
            if report and self._is_here(site := int(rows[row]))
        }

    def missing_assets(self) -> tuple[str, ...]:
        """Paths of missing meshes of all that was derived together, ascending."""
        return tuple(sorted({missing.path for _, buildings in self._made for missing in buildings.missing_assets}))

    def _is_here(self, site: int) -> bool:
        return self.quad.first <= site < self.quad.last

    def _spans(self) -> list[tuple[TileCell, int, int]]:
        """The leaves with their first row and the row after their last one."""
        grid = self.source.grid
        cells = grid.leaves(self.source.sites.corner[self.quad.first : self.quad.last])
        starts = np.flatnonzero(np.diff(morton(cells), prepend=-1)).tolist()
        first = self.quad.first
        return [
            (TileCell(grid.leaf_level, *cells[start].tolist()), first + start, first + end)
            for start, end in zip(starts, [*starts[1:], len(cells)], strict=True)
        ]

    def _built(self, first: int, last: int) -> Iterator[tuple[MadeBuildings, Ints, Ints]]:
        """By zone: the buildings, which of them are on some consecutive sites, and the rows of these sites."""
        for zone_rows, buildings in self._made:
            rows = zone_rows[buildings.row]
            models = np.flatnonzero((rows >= first) & (rows < last))
            if len(models):
                yield buildings, models, rows[models]

    def _tile(self, cell: TileCell, first: int, last: int) -> TileModels | None:
        """The buildings of one leaf, by zone and then in the order of the sites; None if there are none."""
        scenes, rows = list[Scene](), list[Ints]()
        for buildings, models, sites in self._built(first, last):
            if buildings.scene is not None:
                scenes.append(of_models(buildings.scene, models))
                rows.append(sites)
        if not scenes:
            return None
        scene, row = joined(scenes), np.concatenate(rows)
        offset = self.source.sites.corner[row] + scene.origins - self.source.grid.origin(cell)
        return TileModels(scene, offset, self._properties(row, scene))

    def _properties(self, rows: Ints, scene: Scene) -> pa.Table:
        sites, zones = self.source.sites, self.source.zones
        return pa.table(
            {
                "id": pa.array([self.source.ids[row] for row in rows.tolist()], pa.string()),
                "zone": pa.array([zones[zone].zone for zone in sites.zone[rows].tolist()], pa.string()),
                "seed": pa.array(map(str, sites.seed[rows].tolist()), pa.string()),
                "model": pa.array(map(str, sites.model[rows].tolist()), pa.string()),
                "reroll": pa.array(sites.reroll[rows], pa.int32()),
                "height": pa.array(_heights_of(scene).astype(np.float32), pa.float32()),
            }
        )

    def _lines(self, buildings: MadeBuildings, models: Ints, rows: Ints, levels: tuple[Level, ...]) -> Iterator[bytes]:
        """Lines of some buildings."""
        sites, scene = self.source.sites, buildings.scene
        if scene is None:
            return
        ends = np.searchsorted(scene.model, np.arange(scene.num_models + 1))
        numbers: list[int] = rows.tolist()
        lots: list[shapely.Polygon] = lot_outlines(sites.take(rows)).tolist()
        for model, row, lot in zip(models.tolist(), numbers, lots, strict=True):
            alone = of_models(scene, np.array([model]))
            corner = sites.corner[row] + alone.origins[0]
            building = CityBuilding(
                id=self.source.ids[row],
                footprint=lot,
                ground=float(corner[1]),
                scene=alone,
                corner=corner,
                labels=buildings.labels.take(slice(*ends[model : model + 2])),
                attributes={
                    "zone": self.source.zones[sites.zone[row]].zone,
                    "seed": str(sites.seed[row]),
                    "model": str(sites.model[row]),
                    "reroll": int(sites.reroll[row]),
                },
                plinth=float(sites.plinth[row]),
            )
            yield building_line(building, levels)


def quad_buildings(source: SitesOfShard, quads: Sequence[Quad]) -> Iterator[QuadBuildings]:
    """The buildings of quads, in their order."""
    for group in _groups(quads):
        yield from _of_group(source, group)


def _groups(quads: Sequence[Quad]) -> Iterator[list[Quad]]:
    """Consecutive quads with few enough buildings to be derived together, at least one."""
    group: list[Quad] = []
    for quad in quads:
        if group and sum(map(len, group)) + len(quad) > _BUILDINGS_AT_ONCE:
            yield group
            group = []
        group.append(quad)
    if group:
        yield group


def _of_group(source: SitesOfShard, group: Sequence[Quad]) -> Iterator[QuadBuildings]:
    rows = np.concatenate([np.arange(quad.first, quad.last) for quad in group])
    zone = source.sites.zone[rows]
    made = [
        (rows[zone == number], make_buildings(source.zones[number], source.sites.take(rows[zone == number])))
        for number in np.unique(zone).tolist()
    ]
    if len(group) > 1 and any(buildings.missing_assets for _, buildings in made):
        # Which of the buildings lack an asset is not known, and what is said of a quad is its own.
        for quad in group:
            yield from _of_group(source, [quad])
    else:
        yield from (QuadBuildings(source, quad, made) for quad in group)


def _heights_of(scene: Scene) -> Floats:
    """[num_models] highest point of each model above its origin, in metres; 0 for one without instances."""
    low, high = scene.meshes.bounds()
    ends = np.stack([low, high])[:, scene.mesh] * scene.size
    up = scene.frames[scene.frame, 1]
    top = scene.position[:, 1] + np.maximum(ends[0] * up, ends[1] * up).sum(axis=1)
    heights = np.zeros(scene.num_models)
    np.maximum.at(heights, scene.model, top)
    return heights
