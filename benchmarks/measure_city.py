"""Times, memory and sizes of a city on parcels of a grid: ``python -m benchmarks.measure_city FOLDER 10000``.

A building has about 300 leaves. Each build runs in a process of its own, whose peak of memory is reported: one from
nothing, and one after each of a few changes. The folder must be a new one.
"""

from __future__ import annotations

import json
import resource
import subprocess
import sys
import time
from pathlib import Path

from grammarlab.city.parcel_addresses import Pins, rerolled, save_pins
from grammarlab.runs.city.build import build_city

WIDTH, DEPTH, ROWS, STREET = 18.0, 24.0, 2, 12.0
"""Sides of parcels in metres, rows of parcels of a block, and the width of streets."""
RULES = """
attr floors = floor(rand(4, 9))
@StartRule
Lot --> extrude(3.2 * floors) comp(f) { street.front : Front | side : Wall. | top : roofHip(28) color("#a4553a") Roof. }
Front --> color("#d8c8a8") split(y) { ~3.2 : Floor }*
Floor --> split(x) { ~0.8 : Wall. | { 1.1 : Bay | ~0.8 : Wall. }* }
Bay --> split(y) { 0.9 : Wall. | 1.5 : Window | ~1 : Wall. }
Window --> [ color("#f0efe8") s('1, '1, 0.2) primitiveCube() Frame. ] color("#26323f") t(0, 0, -0.1) Glass.
"""


def write_plan(folder: Path, number: int) -> Path:
    """A plan with so many parcels in blocks of two rows."""
    folder.mkdir(parents=True)
    write_map(folder, number, number)
    (folder / "rules.cga").write_text(RULES)
    plan = folder / "plan.toml"
    plan.write_text('parcels = "map.geojson"\ncrs = "local"\n[[zones]]\nname = "all"\ngrammar = "rules.cga"\n')
    return plan


def write_map(folder: Path, number: int, places: int) -> None:
    """The first parcels on a grid with so many places.

    They are written one by one: where a process is started, its peak begins with that of the process that starts it.
    """
    columns = max(1, round((places * 1.3) ** 0.5))
    with (folder / "map.geojson").open("w", encoding="utf-8") as file:
        file.write('{"type": "FeatureCollection", "crs": null, "features": [')
        for index in range(number):
            file.write((", " if index else "") + json.dumps(parcel(index, columns)))
        file.write("]}")


def parcel(index: int, columns: int) -> dict[str, object]:
    """A parcel of a grid, as a feature of GeoJSON."""
    row, column = divmod(index, columns)
    west = WIDTH * column + STREET * (column // 12)
    south = DEPTH * row + STREET * (row // ROWS)
    east, north = west + WIDTH, south + DEPTH
    ring = [(west, south), (east, south), (east, north), (west, north), (west, south)]
    geometry = {"type": "Polygon", "coordinates": [ring]}
    return {"type": "Feature", "properties": {"id": f"p{index:07d}"}, "geometry": geometry}


def main(folder: Path, number: int) -> None:
    """Build from nothing, then after changes, and print what each build took."""
    plan = write_plan(folder / "plan", number)
    measured("from nothing", folder)
    measured("no change", folder)
    write_map(plan.parent, number + 1, number)
    measured("one more parcel", folder)
    save_pins(rerolled(Pins(), f"p{number // 2:07d}"), plan.parent / "pins.csv")
    measured("reroll", folder)


def measured(name: str, folder: Path) -> None:
    """Build in a process of its own."""
    subprocess.run([sys.executable, "-m", "benchmarks.measure_city", str(folder), "--build", name], check=True)


def build(folder: Path, name: str) -> None:
    """Build, and print what it took."""
    imported = time.process_time()
    result = build_city(folder / "plan" / "plan.toml", folder / "city")
    seconds = time.process_time() - imported
    files = sum(path.stat().st_size for path in (folder / "city").rglob("*") if path.is_file())
    megabytes = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    print(
        f"{name}: {result.num_parcels:,} parcels, {result.num_built:,} built: {seconds:.2f} CPU s after {imported:.2f} "
        f"of importing, peak {megabytes:,.0f} MB, files {files / 1e9:.3f} GB, {result.num_tiles:,} tiles, at most "
        f"{result.most_draws} draws a tile"
    )


if __name__ == "__main__":
    if sys.argv[2] == "--build":
        build(Path(sys.argv[1]), sys.argv[3])
    else:
        main(Path(sys.argv[1]), int(sys.argv[2]))
