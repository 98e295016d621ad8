"""Stands of trees as runs: the same trees in other areas, in their places, repeated and resumed."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from PIL import Image

from grammarlab.errors import AssetError, GrammarlabError, UsageError
from grammarlab.randomness import root_keys
from grammarlab.runs.sample.manifest import place_of, read_manifest
from grammarlab.runs.sample.request import SampleRequest
from grammarlab.runs.sample.run import RunResult, repeat_run, sample_run
from grammarlab.runs.sample.species_models import with_attributes
from grammarlab.runs.sample.stand import Stand
from grammarlab.runs.sample.stand_plan import draw_plan
from grammarlab.runs.sample.tree_table import TreeTable
from grammarlab.runs.work.executor_choice import executor_of
from grammarlab.trees.accepted_trees import accepted_rows
from grammarlab.trees.crown_reach import CrownReach, reach
from grammarlab.trees.growth import grow
from grammarlab.trees.species_file import parse
from tests.command_line import invoke
from tests.export.gltf import MESH_FORMATS
from tests.geometry.footprints.maps import collection, feature, named, polygon, written
from tests.geometry.footprints.test_ground import box

SIMPLE = {"levels": 2.0, "branches_1": 5.0, "seg_splits_0": 0.0, "seg_splits_1": 0.0, "leaves": 3.0, "detail": "low"}
"""Attributes of a tree of few parts."""
FAR = "SRID=25832;POLYGON ((691000 5335000, 691090 5335000, 691090 5335060, 691000 5335060, 691000 5335000))"
"""Part of a park in Munich, in metres of UTM."""


def request_of(on: str, **options: Any) -> SampleRequest:
    values: dict[str, Any] = {"attributes": SIMPLE, "seed": 3, "image": False} | options
    return SampleRequest.of("birch", on=on, **values)


def stand_of(request: SampleRequest) -> Stand:
    assert request.stand is not None
    return request.stand


def files_by_model(result: RunResult) -> dict[int, bytes]:
    models = stand_of(result.request).model.tolist()
    return {
        model: (result.folder / record.file).read_bytes() for model, record in zip(models, result.models, strict=True)
    }


def test_a_larger_area_has_the_files_of_a_smaller_one_bit_for_bit(tmp_path):
    """In a format whose files do not have the names of models, which differ."""
    small = sample_run(request_of("30x25", density=200.0, file_format="ply"), tmp_path / "small")
    large = sample_run(
        request_of("POLYGON ((-10 -40, 45 -40, 45 5, -10 5, -10 -40))", density=200.0, file_format="ply"),
        tmp_path / "large",
        executor=executor_of(2),
    )
    few, many = files_by_model(small), files_by_model(large)
    assert 3 < len(few) < len(many)
    assert few.items() <= many.items()
    x, _, z = stand_of(large.request).position.T
    assert ((x > 0) & (x < 30) & (z > 0) & (z < 25)).sum() == len(few)


def test_fewer_trees_are_the_first_ones_of_more(tmp_path):
    few, many = (sample_run(request_of("80x60", num_models=num), tmp_path / str(num)) for num in (3, 7))
    for one, other in zip(few.models, many.models[:3], strict=True):
        assert one.file == other.file
        assert (few.folder / one.file).read_bytes() == (many.folder / other.file).read_bytes()


@pytest.mark.parametrize("file_format", MESH_FORMATS)
@pytest.mark.parametrize("single_file", [False, True])
@pytest.mark.parametrize("on", ["50x40", FAR])
def test_trees_stand_at_their_places_in_all_files(tmp_path, file_format, single_file, on):
    """The lowest points of trunks, as trimesh reads them, are around the places of the trees."""
    request = request_of(on, num_models=4, file_format=file_format, single_file=single_file)
    result = sample_run(request, tmp_path / "out")
    origin = np.array(place_of(request)["origin"])
    assert origin.tolist() == ([0, 0, 0] if on == "50x40" else [691000, 0, -5335000])
    for k, (record, position) in enumerate(zip(result.models, stand_of(request).position, strict=True)):
        scene: Any = trimesh.load(result.folder / record.file, process=False)
        mesh: Any = scene.to_geometry() if isinstance(scene, trimesh.Scene) else scene
        points = np.asarray(mesh.vertices)
        world = points if file_format == "glb" else points + origin
        distance = np.hypot(*(world - position)[:, [0, 2]].T)
        base = (world[:, 1] < 0.05) & (distance < 1.5)
        # trimesh has 32 bits for the world of a GLB.
        tolerance = 0.6 if file_format == "glb" and on == FAR else 0.1
        assert base.sum() >= 3, k
        assert ((world[base].min(axis=0) + world[base].max(axis=0)) / 2 - position)[[0, 2]] == pytest.approx(
            0.0, abs=tolerance
        )


def test_a_tree_of_a_stand_is_the_tree_of_its_address(tmp_path):
    """Its parameters are those of the model with its index under the seed."""
    request = request_of("50x40", num_models=4)
    result = sample_run(request, tmp_path / "out")
    table = TreeTable.load(result.derivations / "00000")
    species = with_attributes(parse(request.text, "birch"), SIMPLE)
    trees = accepted_rows(species, root_keys(3, stand_of(request).model))
    assert (table.rows == trees.rows).all()
    assert (table.key == trees.keys).all()
    assert len(np.unique(table.heading)) == 4  # trunks curve about one axis: unturned, a forest would lean one way


def test_a_run_is_repeated_from_its_manifest_and_resumed(tmp_path):
    request = request_of(FAR, num_models=2, image=True, columns=2)
    result = sample_run(request, tmp_path / "out")
    manifest = read_manifest(result.manifest)
    assert manifest.request.as_json() == request.as_json()
    assert manifest.request.origin == request.origin
    assert {"birch.png", "birch_plan.png"} <= manifest.files.keys()
    _, different = repeat_run(manifest, tmp_path / "again")
    assert different == ()
    (tmp_path / "out" / "birch_plan.png").write_bytes(b"")
    (tmp_path / "out" / "birch-00001.glb").unlink()
    sample_run(request, tmp_path / "out", resume=True)
    assert read_manifest(tmp_path / "out").files == manifest.files
    sample_run(request_of("20x20", num_models=1), tmp_path / "out")
    assert sorted(path.name for path in (tmp_path / "out").glob("*.*")) == ["birch-00000.glb", "manifest.json"]


@pytest.mark.parametrize(
    ("member", "value"),
    [
        ("size", "large"),
        ("density", None),
        ("is_full", 1),
        ("outlines", [[[[0, 0], [1, 1]]]]),
        ("outlines", [[[[0, 0], [1, 1], [1e300, 0]]]]),
        ("outlines", [0]),
        ("trees", 5),
        ("trees", []),
        ("trees", [{"model": "1", "x": 0, "z": 0}] * 2),
        ("trees", [{"model": "-1", "x": 0, "z": 0, "radius": 1}] * 2),
        ("trees", [{"model": "9" * 30, "x": 0, "z": 0, "radius": 1}] * 2),
        ("trees", [{"model": 1, "x": 0, "z": 0, "radius": 1}] * 2),
        ("trees", [{"model": "1", "x": float("nan"), "z": 0, "radius": 1}] * 2),
        ("trees", [{"model": "1", "x": 1e12, "z": 0, "radius": 1}] * 2),
        ("trees", [{"model": "1", "x": 0, "z": 0, "radius": -1}] * 2),
    ],
)
def test_damaged_stands_of_manifests_are_refused(member, value):
    request = request_of("50x40", num_models=2)
    values = json.loads(json.dumps(request.as_json()))
    values["stand"][member] = value
    with pytest.raises(AssetError):
        SampleRequest.from_json(values, request.text, request.assets)


def test_the_plan_shows_crowns_outlines_and_holes():
    square, hole = np.array([[0.0, 0], [40, 0], [40, 30], [0, 30]]), np.array([[25.0, 5], [35, 5], [35, 15], [25, 15]])
    position = np.array([[8.0, 0, 8], [20, 0, 22]])
    stand = Stand(np.zeros(2, np.uint64), position, np.array([4.0, 5.0]), ((square, hole),), 1100.0, 18.0, 0.0, False)
    picture = draw_plan(stand, "oak").astype(int)
    scale = 1200 / (40 * 1.02)
    left, top = picture.shape[1] / 2 - 20 * scale, 40 + (picture.shape[0] - 80) / 2 - 15 * scale

    def color(x: float, z: float) -> list[int]:
        return picture[int(top + z * scale), int(left + x * scale)].tolist()

    paper, ground = [247, 247, 245], [232, 231, 220]
    assert color(30, 10) == paper
    assert color(2, 28) == color(12, 3) == color(30, 22) == ground
    for x, z in ((8, 5), (11, 8), (20, 26), (16, 22)):
        red, green, blue = color(x, z)
        assert green > red + 20 > blue
    assert color(8, 13) == ground
    assert max(color(8, 8)) < 120


@pytest.mark.parametrize("name", ["birch", "palm", "shrub"])
def test_hardly_a_crown_is_wider_than_its_room(name):
    """Trees that are not among the references, grown with all levels and leaves."""
    species = parse(SampleRequest.of(name).text, name)
    models = np.arange(1000, 1012, dtype=np.uint64)
    trees = accepted_rows(species, root_keys(3, models))
    ratio = reach(grow(trees.rows, trees.keys)) / CrownReach(species, 3)(models)
    assert ratio.max() < 1.1
    assert ratio.mean() > 0.75


def test_a_park_in_degrees_keeps_its_place_on_the_earth(tmp_path):
    """And its trees in a larger map that has another middle."""
    park, town = box(11.6, 48.15, 6e-4, 4e-4), box(11.601, 48.1504, 4e-3, 3e-3)
    few = request_of(written(tmp_path, collection(feature(polygon(park))), "park.geojson"), density=150.0)
    many = request_of(written(tmp_path, collection(feature(polygon(town))), "town.geojson"), density=150.0)
    one, other = stand_of(few), stand_of(many)
    rows = [other.model.tolist().index(model) for model in one.model.tolist()]
    assert len(rows) > 5
    assert (other.radius[rows] == one.radius).all()
    move = other.position[rows] - one.position
    assert np.ptp(move, axis=0) == pytest.approx(0.0, abs=0.01)
    assert move.mean(axis=0) == pytest.approx([-1e-3 * 74_500, 0, 4e-4 * 111_200], rel=0.01)
    assert few.georeference is not None
    assert few.georeference.longitude == pytest.approx(11.6)
    assert few.origin == (0.0, 0.0, 0.0)


@pytest.mark.parametrize(
    ("options", "error", "message"),
    [
        ({"on": "50x40", "footprint": "20x12"}, UsageError, "an area or on footprints"),
        ({"density": 5.0}, UsageError, "say which with --on"),
        ({"gap": 1.0}, UsageError, "say which with --on"),
        ({"on": "50x40"}, UsageError, "how many trees"),
        ({"on": "50x40", "density": -1.0}, UsageError, "density: expected"),
        ({"on": "0.1x0.1", "num_models": 4}, UsageError, "no tree stands on the 0.01 square metres"),
        ({"on": "50x0", "num_models": 4}, AssetError, "too few points"),
        ({"on": "nowhere.geojson", "num_models": 4}, AssetError, "no such footprint file"),
        ({"on": "POLYGON ((0 0, 50 40, 50 0, 0 40, 0 0))", "num_models": 4}, AssetError, "self-intersection"),
        ({"on": "50x40", "num_models": 4, "gap": -100.0}, UsageError, "gap: expected at least"),
        ({"on": "50x40", "num_models": 4, "attributes": {"scale": 1e9}}, UsageError, "scale"),
    ],
)
def test_bad_areas_and_numbers_are_refused(options, error, message):
    with pytest.raises(error, match=message):
        SampleRequest.of("birch", seed=3, **({"attributes": SIMPLE} | options))


def test_only_trees_are_planted():
    with pytest.raises(GrammarlabError, match="only trees are planted"):
        SampleRequest.of("toy", on="50x40", num_models=4)


def sampled(folder: Path, *arguments: str):
    attributes = [text for name, value in SIMPLE.items() for text in ("--attr", f"{name}={value}")]
    return invoke("sample", "birch", *attributes, "--jobs", 1, "-o", folder, *arguments)


def test_the_command_plants_trees_and_says_how_to_plant_more(tmp_path):
    metres = collection(feature(polygon([[0, 0], [60, 0], [60, 50], [0, 50], [0, 0]])), crs=named("EPSG:25832"))
    area = written(tmp_path, metres)
    result = sampled(tmp_path / "out", "-n", "2", "--on", area, "--seed", "3")
    assert result.exit_code == 0
    assert "2 trees on 0.3 hectares. On a larger area, --density " in result.output
    assert "birch_plan.png" in result.output
    with Image.open(tmp_path / "out" / "birch_plan.png") as plan:
        assert plan.width > 1000
    density = result.output.split("--density ")[1].split()[0]
    again = sampled(tmp_path / "again", "--on", area, "--seed", "3", "--density", density, "--json", "--no-image")
    values = json.loads(again.stdout)
    assert len(values["models"]) == 2
    assert values["stand"]["density"] == float(density)
    assert values["plan"] is None
    assert values["place"]["crs"] == "EPSG:25832"
    for path in (tmp_path / "again").glob("*.glb"):
        assert path.read_bytes() == (tmp_path / "out" / path.name).read_bytes()


def test_the_command_plants_as_many_as_fit(tmp_path):
    result = sampled(tmp_path / "out", "-n", "500", "--on", "25x20", "--no-image")
    assert result.exit_code == 0
    assert "hardly another one fits" in result.output
    refused = sampled(tmp_path / "none", "--on", "25x20", "--footprint", "9x9")
    assert refused.exit_code == 2
    assert "an area or on footprints" in refused.output
