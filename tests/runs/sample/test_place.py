"""The place of a run: in its manifest, in words, and as the one origin of its files."""

import json
from dataclasses import replace

import numpy as np
import pytest
import trimesh

from grammarlab.errors import AssetError
from grammarlab.runs.sample import models as batches_module
from grammarlab.runs.sample.manifest import place_in_words, place_of, read_manifest
from grammarlab.runs.sample.request import SampleRequest
from grammarlab.runs.sample.run import repeat_run, sample_run
from tests.export.gltf import MESH_FORMATS
from tests.geometry.footprints.maps import BOW_TIE, SQUARE, collection, feature, moved, named, polygon, written

RULES = "attr height = 5\n@StartRule\nLot --> extrude(height) Mass.\n"
FAR = 2683000.13, 1247000.37
"""Zurich, in metres."""


def lots(x, y, scale=1.0, step=40.0, num=3):
    """Equal lots in a row to the east."""
    return [feature(polygon(moved(SQUARE, x + k * step * scale, y, scale))) for k in range(num)]


def request_of(folder, *features, crs=None, **options):
    (folder / "house.cga").write_text(RULES)
    members = {} if crs == "degrees" else {"crs": crs and named(crs)}
    path = written(folder, collection(*features, **members))
    return SampleRequest.of(folder / "house.cga", footprint=path, image=False, **options)


def vertices(path):
    """Vertices of a file as most programs read them: without its comments."""
    mesh = trimesh.load(path, force="mesh", process=False)
    assert isinstance(mesh, trimesh.Trimesh)
    return np.asarray(mesh.vertices)


@pytest.mark.parametrize("file_format", MESH_FORMATS)
@pytest.mark.parametrize("single_file", [False, True])
def test_far_files_of_a_run_keep_their_places_relative_to_each_other(tmp_path, file_format, single_file):
    request = request_of(tmp_path, *lots(*FAR), file_format=file_format, single_file=single_file)
    result = sample_run(request, tmp_path / "out")
    files = sorted({model.file for model in result.models})
    points = np.concatenate([vertices(result.folder / file) for file in files])
    extent = np.ptp(points, axis=0)
    tolerance = 0.3 if file_format == "glb" else 1e-4  # trimesh has 32 bits for the world of a GLB
    assert extent == pytest.approx([90, 5, 8], abs=tolerance)
    if file_format != "glb":
        origin = np.array(place_of(request)["origin"])
        assert origin.tolist() == [2683000, 0, -1247000]
        assert {model.origin for model in result.models} == {tuple(origin)}
        assert (points + origin).min(axis=0) == pytest.approx([FAR[0], 0, -FAR[1] - 8], abs=1e-4)


def test_the_place_is_in_every_manifest(tmp_path):
    degrees = request_of(tmp_path, *lots(7.1, 50.9, 1e-5), crs="degrees")
    cases = [
        (degrees, {"crs": "OGC:CRS84", "longitude": 7.10045, "latitude": 50.90004, "origin": [0, 0, 0]}),
        (
            request_of(tmp_path, *lots(*FAR), crs="EPSG:2056"),
            {"crs": "EPSG:2056", "easting": 2683000, "northing": 1247000, "origin": [2683000, 0, -1247000]},
        ),
        (
            request_of(tmp_path, *lots(0, 0)),
            {"crs": None, "easting": 0, "northing": 0, "origin": [0, 0, 0]},
        ),
        (
            replace(degrees, footprints=(), georeference=None),
            {"crs": None, "easting": 0, "northing": 0, "origin": [0, 0, 0]},
        ),
    ]
    for number, (request, place) in enumerate(cases):
        result = sample_run(request, tmp_path / str(number))
        values = json.loads(result.manifest.read_text())
        origin = place.pop("origin")
        assert values["place"].pop("origin") == origin
        assert values["place"] == pytest.approx(place)
        repeated, different = repeat_run(read_manifest(result.manifest), tmp_path / f"again{number}")
        assert different == ()
        assert repeated.manifest.read_bytes() == result.manifest.read_bytes()
    assert place_in_words(degrees).startswith("origin: longitude 7.1004500, latitude 50.9000400 (OGC:CRS84)")


@pytest.mark.parametrize("file_format", MESH_FORMATS)
@pytest.mark.parametrize(("x", "y"), [(0, 0), (500, -300), FAR])
def test_a_model_is_the_same_whatever_footprints_follow(tmp_path, monkeypatch, x, y, file_format):
    """Near the origin for any footprints, far away if they have the same origin; and in batches of any size."""
    features = lots(x, y, num=5)
    whole = sample_run(request_of(tmp_path, *features, file_format=file_format), tmp_path / "whole")
    monkeypatch.setattr(batches_module, "BATCH_MODELS", 2)
    some = sample_run(request_of(tmp_path, *features[:3], file_format=file_format), tmp_path / "some")
    assert len(some.models) == 3
    for one, other in zip(some.models, whole.models, strict=False):
        assert one == other
        assert (some.folder / one.file).read_bytes() == (whole.folder / other.file).read_bytes()


def test_a_town_across_the_origin_counts_from_it(tmp_path):
    """Its outer lots are far, but all together are not."""
    request = request_of(tmp_path, *lots(-3000, 0, step=1000, num=7), file_format="ply")
    assert request.origin == (0, 0, 0)
    result = sample_run(request, tmp_path / "out")
    for model, lot in zip(result.models, request.footprints, strict=True):
        low = vertices(result.folder / model.file).min(axis=0)
        assert low == pytest.approx(lot.polygon.min(axis=0), abs=1e-4)


def test_remarks_are_in_the_manifest_and_a_run_is_repeated_with_them(tmp_path):
    values = [{"height": "12 m"}, {"height": "tall"}, {"height": [3]}]
    features = [feature(polygon(moved(SQUARE, 20 * k, 0)), **value) for k, value in enumerate(values)]
    request = request_of(tmp_path, *features, feature(polygon(BOW_TIE)))
    result = sample_run(request, tmp_path / "out")
    assert [round(np.ptp(vertices(result.folder / model.file)[:, 1]), 6) for model in result.models] == [12, 5, 5]
    assert [(remark.kind, str(remark)) for remark in result.request.remarks] == [
        ("outline", "lots.geojson, feature 3: self-intersection at x = 45, y = 4"),
        ("property", "lots.geojson, feature 1: attribute 'height': expected a finite number, found 'tall'"),
        ("property", "lots.geojson, feature 2: attribute 'height': expected a finite number, a text, true or false"),
    ]
    manifest = read_manifest(result.manifest)
    assert manifest.request.remarks == result.request.remarks
    repeated, different = repeat_run(manifest, tmp_path / "again")
    assert (different, repeated.request.remarks) == ((), result.request.remarks)
    sample_run(request, tmp_path / "out", resume=True)


def test_manifests_of_earlier_versions_have_no_place(tmp_path):
    result = sample_run(request_of(tmp_path, *lots(0, 0)), tmp_path / "out")
    values = json.loads(result.manifest.read_text())
    del values["place"], values["remarks"]
    result.manifest.write_text(json.dumps(values))
    manifest = read_manifest(result.manifest)
    assert (manifest.request.georeference, manifest.request.remarks) == (None, ())
    assert repeat_run(manifest, tmp_path / "again")[1] == ()
    resumed = sample_run(result.request, tmp_path / "out", resume=True)
    assert json.loads(resumed.manifest.read_text())["place"] == place_of(result.request)


@pytest.mark.parametrize(
    "members",
    [
        {"place": {"crs": 3}},
        {"place": {"crs": "EPSG:4326", "longitude": "7"}},
        {"place": 7},
        {"remarks": [{"other": 1}]},
        {"remarks": 5},
        {"remarks": [{"source": [], "kind": "outline", "reason": ""}]},
        {"remarks": [3]},
    ],
)
def test_a_damaged_place_is_an_error(tmp_path, members):
    result = sample_run(request_of(tmp_path, *lots(0, 0)), tmp_path / "out")
    result.manifest.write_text(json.dumps(json.loads(result.manifest.read_text()) | members))
    with pytest.raises(AssetError, match="damaged"):
        read_manifest(result.manifest)


@pytest.mark.parametrize(
    ("pivot", "file_format", "words"),
    [
        ("world", "usd", "each file has its place in its prim 'World'"),
        ("world", "glb", "each file has its place in a node 'origin'"),
        ("world", "obj", "all files count from it"),
        ("local", "usd", "all files count from it"),
        ("footprint", "obj", "each file counts from an origin of its own, which is in a comment"),
        ("centre", "stl", "each file counts from an origin of its own, which is in its first 80 bytes"),
    ],
)
def test_a_run_says_whether_its_files_have_places_of_their_own(tmp_path, pivot, file_format, words):
    request = request_of(tmp_path, *lots(*FAR), crs="EPSG:2056", pivot=pivot, file_format=file_format)
    assert place_in_words(request).endswith(f"; {words}")
    origins = [model.origin for model in sample_run(request, tmp_path / "out").models]
    is_shared = "all files" in words
    assert (len(set(origins)) == 1, request.origin in origins) == (is_shared, is_shared)


def test_files_near_the_origin_are_said_to_count_from_it_only_if_they_do(tmp_path):
    near = {"crs": "EPSG:2056", "file_format": "ply"}
    assert place_in_words(request_of(tmp_path, *lots(0, 0), **near)).endswith("northing (EPSG:2056)")
    in_degrees = request_of(tmp_path, *lots(7.1, 50.9, 1e-5), crs="degrees", pivot="centre", file_format="ply")
    for request in (request_of(tmp_path, *lots(0, 0), pivot="footprint", **near), in_degrees):
        assert place_in_words(request).endswith("; each file counts from an origin of its own, which is in a comment")
    grid = request_of(tmp_path, *lots(*FAR), num_models=2, single_file=True, **near)
    assert place_in_words(grid).endswith("; the file has its models on a grid instead")
