"""``grammarlab facade synthesize``."""

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from PIL import Image

from grammarlab.facade.file import load_facade
from grammarlab.facade.tree import check
from grammarlab.runs.sample.shipped import examples_folder
from grammarlab.synthesis.analysis.example import analyse
from grammarlab.synthesis.built import build
from grammarlab.synthesis.example_pictures import building_picture
from grammarlab.synthesis.label_grid import LabelGrid
from grammarlab.synthesis.label_synthesis import synthesize
from grammarlab.synthesis.mesh.building_files import read_mesh, write_glb
from grammarlab.synthesis.mesh.surface import edge_numbers
from grammarlab.synthesis.units import stock_of
from tests.cases import some, takes_turns
from tests.synthesis.analyses import analysed_once
from tests.synthesis.houses import BASE, MARGIN, RECESS, TOP, WINDOW, house


@pytest.fixture(scope="module")
def building(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return house(5, 4, 2, broad=((2, 0),)).write(tmp_path_factory.mktemp("house") / "house.obj")


@pytest.fixture(autouse=True)
def small_pictures(monkeypatch: pytest.MonkeyPatch) -> None:
    """Nobody looks at the pictures of buildings here, which take half of the time at their usual size."""
    monkeypatch.setattr(building_picture, "__defaults__", ((120, 100),))


@pytest.fixture(autouse=True)
def analyses(monkeypatch: pytest.MonkeyPatch) -> None:
    """A file that was analysed by one test is not analysed again by the next one, where the command does it."""
    monkeypatch.setattr("grammarlab.runs.facade.synthesize.analyse", analysed_once)


def report(run, *arguments) -> dict:
    return json.loads(run("facade", "synthesize", *arguments, "--json").stdout)


def test_the_report_says_what_the_files_hold(run, building: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    found = report(run, building, "--rows", 6, "--columns", 8, "--seed", 3, "-n", 2, "-o", out)
    assert 1 <= len(found["results"]) <= 2
    assert [each["energy"] for each in found["results"]] == sorted(each["energy"] for each in found["results"])
    for each in found["results"]:
        assert (each["rows"], each["columns"], each["units"]) == (6, 8, 48)
        labels = np.array(each["labels"])
        assert labels.shape == (6, 8)
        # The door stands in the lowest row, which comes first, and only there.
        door = each["names"].index("door")
        assert (labels == door).sum() == (labels[0] == door).sum() == 1
        assert each["bound"] <= each["energy"]
        assert 0.0 <= each["patch_similarity"] <= 1.0
        assert each["watertight"]
        assert each["boundary_edges"] == {"example": 0, "result": 0}
        assert all(value >= 0.0 for value in each["seconds"].values())
        files = each["files"]
        mesh: Any = trimesh.load(files["glb"], force="mesh")
        assert mesh.is_watertight
        assert len(mesh.faces) == each["triangles"]
        assert np.ptp(mesh.vertices, axis=0) == pytest.approx(each["size"], abs=1e-4)
        facade = check(load_facade(Path(files["facade"])))
        assert facade.width == pytest.approx(each["size"][0], abs=0.1)
        assert sum(facade.name_of(leaf) in {"window", "door"} for leaf in facade.leaves.tolist()) == 48
        for key in ("picture", "labels"):
            with Image.open(files[key]) as picture:
                assert picture.width > 100


def test_the_rules_make_the_same_building(run, building: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    found = report(run, building, "--rows", 3, "--columns", 4, "-o", out)["results"][0]
    run("sample", found["files"]["cga"], "-n", 1, "-o", tmp_path / "sampled", "--no-image", "--jobs", 1)
    made: Any = trimesh.load(found["files"]["glb"], force="mesh")
    sampled: Any = trimesh.load(tmp_path / "sampled" / "001-00000.glb", force="mesh")
    assert sampled.area == pytest.approx(made.area, rel=1e-5)
    assert np.ptp(sampled.vertices, axis=0) == pytest.approx(np.ptp(made.vertices, axis=0), abs=1e-4)


def test_what_was_found_can_be_corrected_and_a_folder_shows_one_run(run, building: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    first = report(run, building, "--rows", 5, "--columns", 6, "-n", 2, "-o", out)
    corrections = Path(first["example"]["corrections"])
    document = json.loads(corrections.read_text())
    for row in document["walls"][0]["labels"]:
        row[:] = ["bay"] * len(row)
    corrections.write_text(json.dumps(document))
    second = report(run, building, "--rows", 5, "--columns", 6, "-o", out, "--example", corrections)
    assert second["results"][0]["names"] == ["bay"]
    assert [path.name for path in sorted(out.glob("0*.glb"))] == ["001.glb"]


def test_wishes_are_kept_and_the_family_is_ready_to_be_sampled(run, building: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    wishes = ["--count", "window-2=2:3", "--only", "window-2=top", "--fix", "window-2=4,1", "--symmetric", "--no-keep"]
    found = report(run, building, "--rows", 5, "--columns", 7, *wishes, "-o", out)
    made = found["results"][0]
    labels, broad = np.array(made["labels"]), made["names"].index("window-2")
    assert (labels == labels[:, ::-1]).all()
    assert 2 <= (labels == broad).sum() == (labels[4] == broad).sum() <= 3
    assert labels[4, 1] == broad
    family = found["family"]
    assert family["columns"][0] < 7 <= family["columns"][1]
    run("sample", family["file"], "-n", 3, "--seed", 1, "-o", tmp_path / "samples", "--no-image", "--jobs", 1)
    for path in sorted((tmp_path / "samples").glob("*.glb")):
        mesh: Any = trimesh.load(path, force="mesh")
        width = np.ptp(mesh.vertices[:, 0]) - 2.0 * MARGIN
        assert family["widths"][0] - 1e-3 <= width <= family["widths"][1] + 1e-3
        # Whole columns, 3 m each, and units that fill them.
        assert width / 3.0 == pytest.approx(round(width / 3.0), abs=1e-3)


@takes_turns
@pytest.mark.parametrize("pitch", [3.0, 3.5])
def test_samples_of_the_family_are_closed_houses_with_windows_on_all_sides(run, tmp_path: Path, pitch: float) -> None:
    """The volume of a house is that of a box less the recesses of whole windows, as large as in the example.

    In wider cells, the wall at the back has another number of columns.
    """
    file = house(4, 3, 2, door=None).write(tmp_path / "house.obj")
    box = f"{5 * pitch + 2 * MARGIN}x0x0"
    family = report(run, file, "--rows", 4, "--columns", 5, "--box", box, "-o", tmp_path / "out")["family"]
    run("sample", family["file"], "-n", 5, "--seed", 2, "-o", tmp_path / "samples", "--no-image", "--jobs", 1)
    sizes = set()
    for path in sorted((tmp_path / "samples").glob("*.glb")):
        mesh: Any = trimesh.load(path, force="mesh", process=False)
        width, height, depth = np.ptp(mesh.vertices, axis=0)
        columns, rows = (width - 2.0 * MARGIN) / pitch, (height - BASE - TOP) / 3.0
        assert depth == pytest.approx(2.0 * MARGIN + 6.0, abs=1e-3)
        assert [columns, rows] == pytest.approx([round(columns), round(rows)], abs=1e-3)
        windows = (width * height * depth - mesh.volume) / (RECESS * np.prod(WINDOW))
        assert windows == pytest.approx(rows * round(windows / rows), abs=0.02)
        assert windows / rows == pytest.approx(2.0 * columns + 4.0, abs=0.02 if pitch == 3.0 else 1.02)
        # Units and parts of the rest are closed solids that touch.
        read = edge_numbers(read_mesh(path).surface)
        assert read.closed
        assert read.boundary == 0
        sizes.add((round(columns), round(rows)))
    assert len(sizes) > 2


def test_parts_are_made_after_the_example_that_a_map_names(run, building: Path, tmp_path: Path) -> None:
    other = house(4, 3, 2, storey=3.5, door=None).write(tmp_path / "other.obj")
    (tmp_path / "map.json").write_text("[[1], [2]]")
    options = ["--rows", 6, "--columns", 4, "--regions", tmp_path / "map.json", "--no-keep"]
    found = report(run, building, other, *options, "-o", tmp_path / "out")
    made = found["results"][0]
    # Windows of both are equal, so that they are one label; the upper rows are as high as those of the second.
    assert set(made["names"]) == {"window", "window-2", "door"}
    rows = load_facade(Path(made["files"]["facade"]))
    windows = [leaf for leaf in rows.leaves.tolist() if rows.name_of(leaf) == "window"]
    bottoms = np.unique(np.round(rows.position[windows, 1], 2))
    assert np.diff(bottoms)[-2:] == pytest.approx([3.5, 3.5], abs=0.02)
    assert np.diff(bottoms)[0] == pytest.approx(3.0, abs=0.3)
    assert made["watertight"]


@takes_turns
def test_shops_keep_their_ground_floor_and_their_door(run, tmp_path: Path) -> None:
    rules = examples_folder() / "facades" / "blocks.cga"
    options = ["--start", "Shops", "--attr", "columns=5", "--attr", "storeys=4", "-n", 1, "--format", "ply"]
    run("sample", rules, *options, "--no-image", "-o", tmp_path / "shops")
    file = next((tmp_path / "shops").glob("*.ply"))
    made = report(run, file, "--rows", 5, "--columns", 7, "-o", tmp_path / "out")["results"][0]
    labels = np.array(made["labels"])
    door, shop = (made["names"].index(name) for name in ("door", "shop"))
    assert (labels == door).sum() == (labels[0] == door).sum() == 1
    assert (labels == shop).sum() == (labels[0] == shop).sum() == 6
    assert made["watertight"]
    # One cornice, 0.3 m high, stands out over the shops; the windows of the rows above it come from higher rows.
    mesh: Any = trimesh.load(made["files"]["glb"], force="mesh")
    corners = mesh.vertices
    front = corners[corners[:, 2] > corners[:, 2].max() - 0.01]
    assert np.ptp(front[:, 1]) == pytest.approx(0.3, abs=0.02)


def test_the_only_door_of_a_house_of_two_storeys_stays_on_the_ground(run, tmp_path: Path) -> None:
    file = house(4, 2, 2, door=1).write(tmp_path / "house.obj")
    made = report(run, file, "--rows", 4, "--columns", 5, "-o", tmp_path / "out")["results"][0]
    labels = np.array(made["labels"])
    assert (labels == made["names"].index("door")).sum(axis=1).tolist() == [1, 0, 0, 0]
    assert made["proven"]
    assert made["watertight"]
    facade = load_facade(Path(made["files"]["facade"]))
    doors = [leaf for leaf in facade.leaves.tolist() if facade.name_of(leaf) == "door"]
    windows = [leaf for leaf in facade.leaves.tolist() if facade.name_of(leaf) == "window"]
    assert len(doors) == 1
    assert facade.position[doors[0], 1] < facade.position[windows, 1].min()


@pytest.mark.parametrize("start", some(["Block", "Shops", "Corner", "Curved"]))
def test_shipped_examples_make_buildings_that_trimesh_finds_closed(run, start: str, tmp_path: Path) -> None:
    facades = examples_folder() / "facades"
    lot = ["--footprint", facades / "curved_street.geojson"] if start == "Curved" else ["--attr", "columns=3"]
    options = ["--start", start, *lot, "--attr", "storeys=2", "-n", 1, "--format", "obj", "--no-image"]
    run("sample", facades / "blocks.cga", *options, "-o", tmp_path / "out", "--jobs", 1)
    mesh = read_mesh(next((tmp_path / "out").glob("*.obj")))
    before = edge_numbers(mesh.surface)
    assert before.closed
    example = analyse(mesh)
    stock = stock_of([example])
    made = synthesize(stock.grids, 3, 4)[0]
    random = np.random.default_rng(7)
    names = made.grid.names
    shuffled = replace(made, grid=LabelGrid.from_labels(random.integers(0, len(names), (3, 4)), names))
    for main in (made, shuffled):
        built = build(example, stock, main, None, (None, None, None), 0, before, {})
        assert built.watertight
        assert built.boundary == 0
        read: Any = trimesh.load(write_glb(built.surface, stock.colors, tmp_path / "made.glb"), force="mesh")
        # Materials are meshes of their own in the file: points of equal coordinates are one.
        whole = trimesh.Trimesh(read.vertices, read.faces, process=True)
        assert whole.is_watertight
        assert whole.is_winding_consistent
        assert whole.volume > 0.0


@pytest.mark.parametrize("method", some(["exact", "em"]))
def test_a_box_is_filled_and_a_seed_makes_one_building(run, building: Path, tmp_path: Path, method: str) -> None:
    options = ["--rows", 4, "--columns", 7, "--box", "30x12x18", "--seed", 5, "--method", method]
    one, other = (report(run, building, *options, "-o", tmp_path / name)["results"][0] for name in ("a", "b"))
    assert one["size"] == pytest.approx([30.0, 18.0, 12.0], abs=1e-4)
    assert one["labels"] == other["labels"]
    assert Path(one["files"]["glb"]).read_bytes() == Path(other["files"]["glb"]).read_bytes()


@pytest.mark.parametrize(
    ("options", "code", "message"),
    [
        (["--rows", 0, "--columns", 5], 2, "--rows"),
        (["--rows", 5, "--columns", 100_000], 2, "--columns"),
        (["--rows", 5, "--columns", 5, "--box", "wide"], 2, "--box"),
        (["--rows", 5, "--columns", 5, "--box", "1x20x20"], 1, "no room"),
        (["--rows", 5, "--columns", 5, "--box", "nanx20x20"], 2, "--box"),
        (["--rows", 5, "--columns", 5, "--up", "x"], 2, "--up"),
        (["--rows", 5, "--columns", 5, "--count", "door"], 2, "door=1"),
        (["--rows", 5, "--columns", 5, "--only", "door=below"], 2, "ground"),
        (["--rows", 5, "--columns", 4, "--count", "door=1", "--symmetric"], 1, "middle column"),
        (["--rows", 5, "--columns", 5, "--fix", "portal=0,1"], 1, "window, door, window-2"),
        (["--rows", 5, "--columns", 5, "--unit", "mm"], 1, "0.017 m large"),
    ],
)
def test_mistakes_are_named(run, building: Path, tmp_path: Path, options: list, code: int, message: str) -> None:
    result = run("facade", "synthesize", building, *options, "-o", tmp_path / "out", code=code)
    assert message in result.stderr
    assert not (tmp_path / "out").exists()


def test_a_building_does_not_replace_its_example(run, building: Path, tmp_path: Path) -> None:
    example = tmp_path / "001.glb"
    trimesh.load_scene(building).export(example)
    before = example.read_bytes()
    result = run("facade", "synthesize", example, "--rows", 4, "--columns", 5, "-o", tmp_path, code=2)
    assert "is the input file" in result.stderr
    assert example.read_bytes() == before
