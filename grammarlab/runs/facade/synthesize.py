"""New buildings from one example: read, analysed, labelled anew, built, stitched, measured and written."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from io import BytesIO
from math import isfinite
from pathlib import Path
from typing import Any

from PIL import Image

from grammarlab.errors import UsageError
from grammarlab.facade.examples.analysis.correction import corrected, dumps
from grammarlab.facade.examples.analysis.example import MOST_LINES, Example, Region, analyse
from grammarlab.facade.examples.building.assembly import Tiling, assemble, counts_for, stretch_for, tile
from grammarlab.facade.examples.building.bridge import facade_of, facade_of_tiling
from grammarlab.facade.examples.building.closing import Closed, closed
from grammarlab.facade.examples.building.grammar import building_rules
from grammarlab.facade.examples.building.pictures import building_picture, label_picture
from grammarlab.facade.examples.building.stretching import Stretch
from grammarlab.facade.examples.building.units import Cut, cut_up
from grammarlab.facade.examples.label_grid import LabelGrid
from grammarlab.facade.examples.mesh.reading import read_mesh
from grammarlab.facade.examples.mesh.surface import Surface, edge_numbers
from grammarlab.facade.examples.mesh.writing import write_glb
from grammarlab.facade.examples.synthesis import NO_WISHES, Method, Synthesis, synthesize
from grammarlab.facade.examples.wishes import Wishes
from grammarlab.facade.file import save_facade
from grammarlab.files import write_bytes, write_text
from grammarlab.runs.facade.gallery import sheet

Box = tuple[float | None, float | None, float | None]


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
        """For `--json`, without files."""
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


class Stopwatch:
    """Seconds per stage."""

    def __init__(self) -> None:
        self.seconds: dict[str, float] = {}

    @contextmanager
    def __call__(self, stage: str) -> Iterator[None]:
        start = time.perf_counter()
        try:
            yield
        finally:
            self.seconds[stage] = self.seconds.get(stage, 0.0) + time.perf_counter() - start


def synthesize_buildings(
    file: Path,
    folder: Path,
    *,
    rows: int,
    columns: int,
    box: Box = (None, None, None),
    method: Method = "exact",
    wishes: Wishes = NO_WISHES,
    seed: int = 0,
    count: int = 1,
    up: str = "",
    corrections: Path | None = None,
) -> dict[str, Any]:
    """Write new buildings like the one in a file, best first, and report on them.

    Args:
        file: a mesh.
        folder: where to write.
        rows: of the main wall; other walls get as many as fit beside.
        columns: of the main wall.
        box: width, height and depth in metres; as the units make it where None.
        method: of label synthesis.
        wishes: for the main wall.
        seed: of all random choices.
        count: buildings wanted; fewer come where there are no more.
        up: `y` or `z`; found out where empty.
        corrections: a file of an earlier run, with lines and labels that a person has corrected.

    Raises:
        UsageError: for rows, columns or a box out of range.
        FacadeError: where the file cannot be read, or no units are found.
    """
    _check(rows, columns, box)
    watch = Stopwatch()
    with watch("read"):
        mesh = read_mesh(file)
    with watch("analysis"):
        example = analyse(mesh, up)
        example = corrected(example, corrections) if corrections else example
    with watch("cutting"):
        cut = cut_up(example.surface, example.regions)
    with watch("labels"):
        mains = synthesize([example.main.grid], rows, columns, method=method, wishes=wishes, seed=seed, count=count)
    before = edge_numbers(mesh.surface)
    built = [_built(example, cut, main, box, seed, before, dict(watch.seconds)) for main in mains]
    folder.mkdir(parents=True, exist_ok=True)
    with watch("pictures"):
        picture = building_picture(example.surface, mesh.colors)
    save_facade(facade_of(example.main), folder / "example.facade.json")
    write_text(folder / "example.json", dumps(example))
    results = []
    for number, each in enumerate(built, start=1):
        files = _write(each, example, cut, folder, f"{number:03}", picture, each.seconds)
        results.append({**each.as_dict(), "files": files})
    _remove_later(folder, len(built))
    return {
        "example": _example_dict(example, folder),
        "results": results,
        "notes": list(example.notes),
    }


def _check(rows: int, columns: int, box: Box) -> None:
    for name, value in (("--rows", rows), ("--columns", columns)):
        if not 1 <= value <= MOST_LINES:
            raise UsageError(f"{name}: expected 1 to {MOST_LINES}, found {value}.")
    for value in box:
        if value is not None and not (isfinite(value) and 0.0 < value <= 10_000.0):
            raise UsageError(f"--box: expected metres above 0 and at most 10,000, found {value:g}.")


def _built(
    example: Example,
    cut: Cut,
    main: Synthesis,
    box: Box,
    seed: int,
    before: tuple[int, bool],
    seconds: dict[str, float],
) -> Built:
    """One building for a grid of the main wall, of an example with so many open edges that is closed or not."""
    watch = Stopwatch()
    watch.seconds.update(seconds)
    stretch = stretch_for(example, main.grid, box)
    with watch("labels"):
        grids = _grids(example, main, stretch, seed)
    with watch("assembly"):
        tilings = tuple(tile(region, grid, stretch) for region, grid in zip(example.regions, grids, strict=True))
        pieces = assemble(cut, tilings, stretch)
    with watch("stitching"):
        noise = max(region.noise for region in example.regions)
        done = closed(pieces, tilings, noise, was_closed=before[1])
        boundary, watertight = edge_numbers(done.surface)
    return Built(main, tilings, stretch, done, before[0], boundary, watertight, watch.seconds)


def _grids(example: Example, main: Synthesis, stretch: Stretch, seed: int) -> list[LabelGrid]:
    """The grid of each region; walls that are alike get the same."""
    known: dict[tuple[Any, ...], LabelGrid] = {}
    grids = [main.grid]
    for region in example.regions[1:]:
        rows, columns = counts_for(region, stretch)
        key = _key(region, rows, columns)
        if key not in known:
            found = synthesize([region.grid], rows, columns, method=main.method, seed=seed, count=1)
            known[key] = found[0].grid
        grids.append(LabelGrid.of(known[key].labels, region.grid.names))
    return grids


def _key(region: Region, rows: int, columns: int) -> tuple[Any, ...]:
    return rows, columns, region.grid.labels.shape, region.grid.labels.tobytes(), region.grid.names


def _write(
    built: Built, example: Example, cut: Cut, folder: Path, name: str, picture: Image.Image, seconds: dict[str, float]
) -> dict[str, Any]:
    """The files of one building."""
    watch = Stopwatch()
    colors = example.mesh.colors
    files = {
        "glb": folder / f"{name}.glb",
        "labels": folder / f"{name}.labels.png",
        "facade": folder / f"{name}.facade.json",
        "cga": folder / f"{name}.cga",
        "picture": folder / f"{name}.png",
    }
    with watch("files"):
        write_glb(built.surface, colors, files["glb"])
        save_facade(facade_of_tiling(built.tilings[0], built.stretch), files["facade"])
        written = building_rules(
            cut,
            built.tilings,
            built.stretch,
            colors,
            f"A building of {built.main.grid.rows} rows and {built.main.grid.columns} columns of units",
        )
        write_text(files["cga"], written.text)
        (folder / "assets").mkdir(exist_ok=True)
        for terminal in written.terminals:
            write_glb(terminal.surface, colors, folder / "assets" / terminal.name)
    with watch("pictures"):
        grids = [label_picture(each) for each in (example.main.grid, built.main.grid)]
        write_bytes(files["labels"], _png(grids[1]))
        whole = building_picture(built.surface, colors)
        write_bytes(files["picture"], _png(sheet([picture, grids[0], grids[1], whole])))
    seconds.update(watch.seconds)
    return {key: str(path) for key, path in files.items()}


def _example_dict(example: Example, folder: Path) -> dict[str, Any]:
    """For `--json`: what was found in the example."""
    return {
        "triangles": len(example.surface),
        "rows": example.main.grid.rows,
        "columns": example.main.grid.columns,
        "labels": example.main.grid.labels.tolist(),
        "names": list(example.main.grid.names),
        "facade": str(folder / "example.facade.json"),
        "corrections": str(folder / "example.json"),
        "walls": [
            {
                "name": each.name,
                "rows": each.grid.rows,
                "columns": each.grid.columns,
                "labels": each.grid.labels.tolist(),
                "names": list(each.grid.names),
                "pitch": [each.columns.pitch, each.rows.pitch],
                "regular": [each.columns.is_regular, each.rows.is_regular],
            }
            for each in example.regions
        ],
    }


def _remove_later(folder: Path, count: int) -> None:
    """Remove buildings of higher numbers that an earlier run has left: a folder shows one run."""
    number = count + 1
    while (folder / f"{number:03}.glb").is_file():
        for ending in ("glb", "labels.png", "facade.json", "cga", "png"):
            (folder / f"{number:03}.{ending}").unlink(missing_ok=True)
        number += 1


def _png(picture: Image.Image) -> bytes:
    content = BytesIO()
    picture.save(content, "PNG")
    return content.getvalue()
