"""One new building: its labels, walls and mesh, and a report on it."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import Any

from grammarlab.synthesis.analysis.example import Example, Region
from grammarlab.synthesis.assembly import Tiling, assemble, counts_for, natural, sources_of, stretch_for, tile
from grammarlab.synthesis.closing import TOLERANCE, Closed, closed, rounded
from grammarlab.synthesis.label_grid import LabelGrid, Labels
from grammarlab.synthesis.label_synthesis import Synthesis, synthesize
from grammarlab.synthesis.mesh.surface import EdgeNumbers, Surface, edge_numbers, sliced
from grammarlab.synthesis.mesh.views import plane_of
from grammarlab.synthesis.units import Stretch, UnitStock

Box = tuple[float | None, float | None, float | None]


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
            "size": [float(each) for each in self.surface.points.max(axis=0) - self.surface.points.min(axis=0)],
            "walls": [
                {"name": each.region.name, "rows": each.grid.rows, "columns": each.grid.columns}
                for each in self.tilings
            ],
            "notes": list(self.main.notes),
            "seconds": self.seconds,
        }


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
        for own, grid in enumerate(grids, start=1):
            tilings.append(tile(stock.walls, own, grid, sources_of(stock.walls, (own,), grid), stretch))
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
    for at in main.columns:
        plane = plane_of(main.region.side, 0, float(at))
        surface = sliced(surface, plane.axis, plane.position, TOLERANCE)
    return surface.moved(example.bent(surface.points))


def _grids(example: Example, main: Synthesis, stretch: Stretch, seed: int) -> list[LabelGrid]:
    """The grid of each region except the main one; equal walls get the same one."""
    known: dict[tuple[Any, ...], LabelGrid] = {}
    grids = []
    for region in example.regions[1:]:
        rows, columns = counts_for(region, stretch)
        key = _key(region, rows, columns)
        if key not in known:
            found = synthesize([region.grid], rows, columns, method=main.method, seed=seed, count=1)
            known[key] = found[0].grid
        grids.append(LabelGrid.from_labels(known[key].labels, region.grid.names))
    return grids


def _key(region: Region, rows: int, columns: int) -> tuple[Any, ...]:
    return rows, columns, region.grid.labels.shape, region.grid.labels.tobytes(), region.grid.names
