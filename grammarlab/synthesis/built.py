"""New buildings from examples: labels, walls and meshes, and reports on them; nothing here reads or writes files."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from math import isfinite
from typing import Any

from grammarlab.errors import UsageError
from grammarlab.facade.grammar.family import Range, WrittenFamily
from grammarlab.synthesis.analysis.example import MOST_LINES, Example, Region
from grammarlab.synthesis.assembly import Tiling, assemble, counts_for, natural, sources_of, stretch_for, tile
from grammarlab.synthesis.building_family import building_family
from grammarlab.synthesis.building_grammar import BuildingRules, parts_of
from grammarlab.synthesis.closing import TOLERANCE, Closed, closed, rounded
from grammarlab.synthesis.label_grid import LabelGrid, Labels, Wishes
from grammarlab.synthesis.label_synthesis import NO_WISHES, Method, Synthesis, synthesize
from grammarlab.synthesis.mesh.surface import EdgeNumbers, Surface, edge_numbers, sliced
from grammarlab.synthesis.mesh.views import plane_of
from grammarlab.synthesis.units import Stretch, UnitStock, stock_of

Box = tuple[float | None, float | None, float | None]
"""Width, height and depth in metres; None for those that follow from the units."""
_WIDEST = 10_000.0
"""Largest side of a box, metres."""
_MIN_FACTOR, _MAX_FACTOR = 0.75, 1.25
"""Range of sizes of a family, as multiples of those of the example and the result."""


class Stopwatch:
    """Durations of stages, in seconds."""

    def __init__(self) -> None:
        self.seconds: dict[str, float] = {}

    @contextmanager
    def __call__(self, stage: str) -> Iterator[None]:
        start = time.perf_counter()
        try:
            yield
        finally:
            self.seconds[stage] = self.seconds.get(stage, 0.0) + time.perf_counter() - start


@dataclass(frozen=True, eq=False)
class Built:
    """One new building."""

    main: Synthesis
    tilings: tuple[Tiling, ...]
    stretch: Stretch
    closed: Closed
    example_boundary: int
    boundary: int
    watertight: bool
    seconds: dict[str, float]

    @property
    def surface(self) -> Surface:
        return self.closed.surface

    def as_dict(self) -> dict[str, Any]:
        """Values for `--json`, without files."""
        quality = self.main.quality
        return {
            "rows": self.main.grid.rows,
            "columns": self.main.grid.columns,
            "labels": self.main.grid.labels.tolist(),
            "names": list(self.main.grid.names),
            "units": self.main.grid.labels.size,
            "method": self.main.method,
            "energy": self.main.energy,
            "bound": self.main.bound,
            "proven": self.main.proven,
            "paper_energy": self.main.paper_energy,
            "patch_similarity": quality.patch_similarity,
            "cooccurrence": quality.cooccurrence,
            "histogram": quality.histogram,
            "novelty": quality.novelty,
            "watertight": self.watertight,
            "boundary_edges": {"example": self.example_boundary, "result": self.boundary},
            "triangles": len(self.surface),
            "stitching": {"points_moved": self.closed.moved, "widest_gap": self.closed.farthest},
            "size": [float(extent) for extent in self.surface.points.max(axis=0) - self.surface.points.min(axis=0)],
            "walls": [
                {"name": tiling.region.name, "rows": tiling.grid.rows, "columns": tiling.grid.columns}
                for tiling in self.tilings
            ],
            "notes": list(self.main.notes),
            "seconds": self.seconds,
        }


@dataclass(frozen=True, eq=False)
class NewBuildings:
    """New buildings, the one of least energy first, and what they were made of."""

    examples: tuple[Example, ...]
    stock: UnitStock
    built: tuple[Built, ...]


def check_size(rows: int, columns: int, box: Box) -> None:
    """Refuse rows and columns of a wall, or a box around a building, that are out of range.

    Raises:
        UsageError: If one of them is.
    """
    for name, value in (("rows", rows), ("columns", columns)):
        if not 1 <= value <= MOST_LINES:
            raise UsageError(f"`{name}=`: expected 1 to {MOST_LINES}, found {value}.")
    for value in box:
        if value is not None and not (isfinite(value) and 0.0 < value <= _WIDEST):
            raise UsageError(f"`box=`: expected metres above 0 and at most {_WIDEST:,.0f}, found {value:g}.")


def new_buildings(
    examples: Sequence[Example],
    rows: int,
    columns: int,
    *,
    box: Box = (None, None, None),
    method: Method = "exact",
    wishes: Wishes = NO_WISHES,
    regions: Labels | None = None,
    seed: int = 0,
    count: int = 1,
    before: EdgeNumbers | None = None,
    seconds: dict[str, float] | None = None,
) -> NewBuildings:
    """Buildings similar to examples, the one of least energy first.

    Args:
        examples: the example, and others whose main walls also provide units.
        rows: rows of the main wall; those of other walls follow from their room.
        columns: columns of the main wall.
        box: width, height and depth in metres; None for those that follow from the units.
        method: solver for the labels of the main wall.
        wishes: wishes for the main wall.
        regions: [rows, columns] example of each cell; any example when left out.
        seed: seed of all random choices.
        count: largest number of buildings.
        before: edges of the example as it was read; those of its surface when left out.
        seconds: durations of stages so far.

    Raises:
        UsageError: If rows, columns or the box are out of range.
        FacadeError: If no units are found, or wishes contradict each other.
    """
    check_size(rows, columns, box)
    watch = Stopwatch()
    watch.seconds.update(seconds or {})
    with watch("cutting"):
        stock = stock_of(examples)
    with watch("labels"):
        mains = synthesize(
            stock.grids, rows, columns, method=method, wishes=wishes, seed=seed, count=count, regions=regions
        )
    edges = edge_numbers(examples[0].surface) if before is None else before
    built = [build(examples[0], stock, main, regions, box, seed, edges, dict(watch.seconds)) for main in mains]
    return NewBuildings(tuple(examples), stock, tuple(built))


def family_of(
    new: NewBuildings, widths: Range | None = None, heights: Range | None = None
) -> tuple[WrittenFamily, BuildingRules]:
    """The grammar of the best new building in other sizes, and the same rules with the meshes that they insert.

    Args:
        new: the new buildings.
        widths: least and largest width of the main wall, metres; about those of the example and the building if None.
        heights: least and largest height, metres.

    Raises:
        FacadeError: If no building of the family has such a size.
    """
    best, main = new.built[0], new.stock.walls[0]
    tiling = best.tilings[0]
    ranges = []
    for given, result, example in (
        (widths, tiling.columns, main.columns.line),
        (heights, tiling.rows, main.rows.line),
    ):
        sizes = float(result[-1] - result[0]), float(example[-1] - example[0])
        ranges.append(given or (_MIN_FACTOR * min(sizes), _MAX_FACTOR * max(sizes)))
    return building_family(parts_of(new.examples, new.stock), best.tilings, best.stretch, *ranges)


def build(
    example: Example,
    stock: UnitStock,
    main: Synthesis,
    regions: Labels | None,
    box: Box,
    seed: int,
    before: EdgeNumbers,
    seconds: dict[str, float],
) -> Built:
    """The building for a grid of the main wall.

    Args:
        example: the building that provides the other walls and the rest.
        stock: units of its walls, and of the main walls of other examples.
        main: the grid.
        regions: [rows, columns] example of each cell; any example when left out.
        box: width, height and depth in metres; None for those that follow from the units.
        seed: seed of the labels of other walls.
        before: edges of the example, as it was read.
        seconds: durations of stages so far.

    Raises:
        FacadeError: If the box leaves no room for units.
    """
    watch = Stopwatch()
    watch.seconds.update(seconds)
    sources = sources_of(stock.walls, stock.choice, main.grid, regions)
    stretch = stretch_for(example, natural(stock.walls, sources), box)
    with watch("labels"):
        grids = _grids(example, main, stretch, seed)
    with watch("assembly"):
        tilings = [tile(stock.walls, 0, main.grid, sources, stretch)]
        for wall, grid in enumerate(grids, start=1):
            tilings.append(tile(stock.walls, wall, grid, sources_of(stock.walls, (wall,), grid), stretch))
        pieces = assemble(stock.cut, tilings, stretch)
    with watch("stitching"):
        noise = max(region.noise for region in stock.walls)
        done = closed(pieces, tilings, noise, was_closed=before.closed)
        if example.bend is not None:
            bent = _bent(done.surface, example, tilings[0])
            done = replace(done, surface=rounded(bent, was_closed=before.closed, sheets=done.sheets))
        after = edge_numbers(done.surface)
    return Built(
        main=main,
        tilings=tuple(tilings),
        stretch=stretch,
        closed=done,
        example_boundary=before.boundary,
        boundary=after.boundary,
        watertight=after.watertight,
        seconds=watch.seconds,
    )


def _bent(surface: Surface, example: Example, main: Tiling) -> Surface:
    """The building; along an arc it is bent back, and cut at the lines of columns: long edges follow the arc."""
    for line in main.columns:
        plane = plane_of(main.region.side, 0, float(line))
        surface = sliced(surface, plane.axis, plane.position, TOLERANCE)
    return surface.moved(example.bent(surface.points))


def _grids(example: Example, main: Synthesis, stretch: Stretch, seed: int) -> list[LabelGrid]:
    """The grid of each region except the main one; equal walls get the same one."""
    by_key: dict[tuple[Any, ...], LabelGrid] = {}
    grids = []
    for region in example.regions[1:]:
        rows, columns = counts_for(region, stretch)
        key = _key(region, rows, columns)
        if key not in by_key:
            results = synthesize([region.grid], rows, columns, method=main.method, seed=seed, count=1)
            by_key[key] = results[0].grid
        grids.append(LabelGrid.from_labels(by_key[key].labels, region.grid.names))
    return grids


def _key(region: Region, rows: int, columns: int) -> tuple[Any, ...]:
    return rows, columns, region.grid.labels.shape, region.grid.labels.tobytes(), region.grid.names
