"""Whole runs: repeatable, resumable, independent of how they are cut and who does the work."""

import json
import re
from dataclasses import replace
from hashlib import sha256
from typing import Any

import numpy as np
import pytest
import trimesh
from trimesh.exchange.gltf import export_gltf

from grammarlab.errors import AssetError, LanguageError, UsageError
from grammarlab.geometry.footprints.footprint_text import read_footprints
from grammarlab.runs.sample import models as batches_module
from grammarlab.runs.sample.derivations import load_forest
from grammarlab.runs.sample.manifest import read_manifest
from grammarlab.runs.sample.models import cut_batches
from grammarlab.runs.sample.request import SampleRequest, read_model_numbers
from grammarlab.runs.sample.run import repeat_run, sample_run
from grammarlab.runs.work.executor_choice import executor_of
from grammarlab.runs.work.executors import Processes
from grammarlab.scene import realize, triangles
from tests.cases import takes_turns
from tests.runs.grammars import BROKEN, TOWER


def tower(tmp_path, **options: Any):
    values: dict[str, Any] = {"num_models": 3, "image": False, **options}
    return SampleRequest(name="tower", text=TOWER, assets=tmp_path, **values)


def read(path):
    mesh = trimesh.load(path, force="mesh")
    assert isinstance(mesh, trimesh.Trimesh)
    return mesh


def contents(folder):
    return {p.relative_to(folder).as_posix(): p.read_bytes() for p in sorted(folder.rglob("*")) if p.is_file()}


def test_a_run_leaves_one_file_a_model_derivations_and_a_manifest(tmp_path):
    result = sample_run(tower(tmp_path, seed=5), tmp_path / "out")
    assert [m.file for m in result.models] == ["tower-00000.glb", "tower-00001.glb", "tower-00002.glb"]
    forest = load_forest(result.derivations / "00000")
    assert [m.log_probability for m in result.models] == forest.log_probability().tolist()
    assert [m.shapes for m in result.models] == forest.shapes_per_model().tolist()
    assert [m.triangles for m in result.models] == triangles(realize(forest)).triangles_per_model().tolist()
    for model in result.models:
        read_back = read(result.folder / model.file)
        assert len(read_back.faces) == model.triangles
    assert not list(tmp_path.rglob(".part*"))


def test_the_manifest_lists_every_file_with_its_hash_and_nothing_else(tmp_path):
    result = sample_run(tower(tmp_path, file_format="obj"), tmp_path / "out")
    listed = set(read_manifest(result.manifest).files)
    there = set(contents(result.folder)) - {"manifest.json", "derivations/00000/models.json"}
    assert listed == there


def test_the_same_request_gives_the_same_bytes(tmp_path):
    for name in "ab":
        sample_run(tower(tmp_path, seed=9), tmp_path / name)
    assert contents(tmp_path / "a") == contents(tmp_path / "b")


def test_files_do_not_depend_on_the_number_of_processes(tmp_path, monkeypatch):
    monkeypatch.setattr(batches_module, "BATCH_MODELS", 2)
    for jobs in (1, 2):
        sample_run(tower(tmp_path, num_models=5), tmp_path / str(jobs), executor=executor_of(jobs))
    assert contents(tmp_path / "1") == contents(tmp_path / "2")


def test_model_files_do_not_depend_on_the_number_of_models(tmp_path):
    few, many = (sample_run(tower(tmp_path, num_models=n), tmp_path / str(n)) for n in (2, 6))
    for one, other in zip(few.models, many.models, strict=False):
        assert one == other
        assert (few.folder / one.file).read_bytes() == (many.folder / other.file).read_bytes()


@pytest.mark.parametrize(
    ("options", "expected"),
    [
        ({"file_format": "ply", "single_file": True}, "tower.ply"),
        ({"file_format": "glb", "single_file": True, "instancing": "nodes"}, "tower.glb"),
        ({"file_format": "obj", "single_file": True}, "tower.obj"),
    ],
)
def test_a_single_file_holds_the_triangles_of_all_models(tmp_path, options, expected):
    result = sample_run(tower(tmp_path, **options), tmp_path / "out")
    assert {m.file for m in result.models} == {expected}
    read_back = read(result.folder / expected)
    assert len(read_back.faces) == sum(m.triangles for m in result.models)


def test_a_manifest_repeats_its_run_bit_for_bit(tmp_path):
    request = replace(
        tower(tmp_path, seed=2**64 - 1, attributes={"height": 4.1, "style": "näh", "shops": False}),
        footprints=read_footprints("POLYGON ((0 0, 10 0.1, 7 8, 0 0))"),
    )
    first = sample_run(request, tmp_path / "first")
    second, different = repeat_run(read_manifest(first.manifest), tmp_path / "second")
    assert different == ()
    assert contents(first.folder).keys() == contents(second.folder).keys()
    assert first.models == second.models


def test_repeating_names_the_files_that_differ(tmp_path):
    first = sample_run(tower(tmp_path), tmp_path / "first")
    values = json.loads(first.manifest.read_text())
    values["files"]["tower-00001.glb"] = "0" * 64
    first.manifest.write_text(json.dumps(values))
    _, different = repeat_run(read_manifest(first.manifest), tmp_path / "second")
    assert different == ("tower-00001.glb",)


SOLID = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n"


@pytest.fixture
def pieces(tmp_path):
    """A request whose rules name assets in every way, and its folder of assets."""
    folder = tmp_path / "assets"
    (folder / "deep").mkdir(parents=True)
    for name in ("one.obj", "a.obj", "b.obj", "deep/c.obj", "given.obj", "unused.obj"):
        (folder / name).write_text(f"# {name}\n{SOLID}")
    (folder / "wall.png").write_bytes(b"not looked at")
    text = """
attr mine = "one.obj"
Lot --> extrude(2) [ i("one.obj") A ] [ i(listRandom("a.obj;b.obj;")) A ] [ i(fileRandom("deep/*.obj")) A ] i(mine) A
Never --> i("missing.obj") texture("wall.png") i("../outside.obj") print("Really?")
"""
    (tmp_path / "outside.obj").write_text(SOLID)
    attributes = {"mine": "given.obj"}
    return SampleRequest(name="pieces", text=text, assets=folder, attributes=attributes, image=False), folder


def test_the_manifest_holds_the_hashes_of_the_assets_that_the_rules_name(pieces, tmp_path):
    request, folder = pieces
    manifest = read_manifest(sample_run(request, tmp_path / "out").manifest)
    named = ["a.obj", "b.obj", "deep/c.obj", "given.obj", "one.obj", "wall.png"]
    assert manifest.asset_files == {name: sha256((folder / name).read_bytes()).hexdigest() for name in named}


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda folder: (folder / "a.obj").write_text(SOLID), "'a.obj' has changed"),
        (lambda folder: (folder / "b.obj").unlink(), "'b.obj' is missing"),
        (lambda folder: (folder / "deep" / "d.obj").write_text(SOLID), "'deep/d.obj' is new"),
    ],
)
def test_a_run_is_neither_repeated_nor_resumed_with_other_assets(pieces, tmp_path, change, message):
    request, folder = pieces
    first = sample_run(request, tmp_path / "first")
    change(folder)
    with pytest.raises(AssetError, match=message):
        repeat_run(read_manifest(first.manifest), tmp_path / "second")
    assert not (tmp_path / "second").exists()
    with pytest.raises(UsageError, match=message):
        sample_run(request, first.folder, resume=True)


def test_assets_that_the_rules_do_not_name_may_change(pieces, tmp_path):
    request, folder = pieces
    first = sample_run(request, tmp_path / "first")
    (folder / "unused.obj").unlink()
    assert repeat_run(read_manifest(first.manifest), tmp_path / "second")[1] == ()


def test_the_buffers_of_gltf_assets_count_too(tmp_path):
    files = export_gltf(trimesh.Scene(trimesh.creation.box()))
    for name, content in files.items():
        (tmp_path / name).write_bytes(content)
    request = SampleRequest(name="box", text='Lot --> i("/model.gltf") A', assets=tmp_path, image=False)
    named = read_manifest(sample_run(request, tmp_path / "out").manifest).asset_files
    assert len(named) > 1
    assert named.keys() == files.keys()


@takes_turns
def test_a_picture_that_is_there_is_not_drawn_again(tmp_path):
    request = tower(tmp_path, image=True)
    result = sample_run(request, tmp_path / "out")
    assert result.sheet is not None
    before = result.sheet.stat().st_mtime_ns
    sample_run(request, tmp_path / "out", resume=True)
    assert result.sheet.stat().st_mtime_ns == before
    content = result.sheet.read_bytes()
    result.sheet.unlink()
    sample_run(request, tmp_path / "out", resume=True, executor=Processes(2))
    assert result.sheet.read_bytes() == content


class StopError(Exception):
    """Stands for Ctrl-C after some batches."""


def interrupted_run(request, folder, after):
    def stop(what, done, _total):
        if what == "models" and done >= after:
            raise StopError

    with pytest.raises(StopError):
        sample_run(request, folder, on_progress=stop)


def test_an_interrupted_run_goes_on_with_what_is_missing(tmp_path, monkeypatch):
    monkeypatch.setattr(batches_module, "BATCH_MODELS", 2)
    request = tower(tmp_path, num_models=6)
    whole = sample_run(request, tmp_path / "whole")
    interrupted_run(request, tmp_path / "cut", after=4)
    assert not read_manifest(tmp_path / "cut").complete
    finished = tmp_path / "cut" / "tower-00001.glb"
    read(finished)
    before = finished.stat().st_mtime_ns
    done = []
    sample_run(request, tmp_path / "cut", resume=True, on_progress=lambda _what, count, _total: done.append(count))
    assert done == [4, 6]
    assert finished.stat().st_mtime_ns == before
    assert contents(tmp_path / "cut") == contents(whole.folder)


def test_resuming_replaces_a_file_that_was_lost(tmp_path):
    result = sample_run(tower(tmp_path), tmp_path / "out")
    before = contents(result.folder)
    (result.folder / "tower-00001.glb").unlink()
    sample_run(tower(tmp_path), tmp_path / "out", resume=True)
    assert contents(result.folder) == before


def test_resuming_another_run_is_refused_with_the_difference(tmp_path):
    sample_run(tower(tmp_path, seed=1), tmp_path / "out")
    with pytest.raises(UsageError, match="seed was 1 and is 2"):
        sample_run(tower(tmp_path, seed=2), tmp_path / "out", resume=True)
    with pytest.raises(UsageError, match="the file of the models differs"):
        sample_run(replace(tower(tmp_path, seed=1), text=TOWER + "\n"), tmp_path / "out", resume=True)


def test_a_new_run_removes_the_files_of_the_old_one_and_no_others(tmp_path):
    sample_run(tower(tmp_path, num_models=5), tmp_path / "out")
    (tmp_path / "out" / "notes.txt").write_text("mine")
    sample_run(tower(tmp_path, num_models=2), tmp_path / "out")
    names = {p.name for p in (tmp_path / "out").iterdir()}
    assert names == {"tower-00000.glb", "tower-00001.glb", "derivations", "manifest.json", "notes.txt"}


@pytest.mark.parametrize("wrong", [{"attributes": {"hight": 3.0}}, {"start_rule": "Nothing"}])
def test_wrong_options_leave_the_files_of_the_old_run(tmp_path, wrong):
    before = contents(sample_run(tower(tmp_path), tmp_path / "out").folder)
    with pytest.raises(UsageError, match=r"hight|Nothing"):
        sample_run(replace(tower(tmp_path), **wrong), tmp_path / "out")
    assert contents(tmp_path / "out") == before


@pytest.mark.parametrize("manifest", ['{"name": "my page"}', "[]", "no JSON", '{"grammar": {"name": 3}}'])
def test_a_manifest_of_somebody_else_is_left_alone(tmp_path, manifest):
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "manifest.json").write_text(manifest)
    with pytest.raises(UsageError, match=r"no run wrote.*another folder with -o"):
        sample_run(tower(tmp_path), tmp_path / "out")
    assert [(file.name, file.read_text()) for file in (tmp_path / "out").iterdir()] == [("manifest.json", manifest)]


def test_a_run_does_not_replace_the_run_of_another_grammar(tmp_path):
    before = contents(sample_run(tower(tmp_path), tmp_path / "out").folder)
    with pytest.raises(UsageError, match=r"holds models of 'tower'.*-o"):
        sample_run(replace(tower(tmp_path), name="house"), tmp_path / "out")
    assert contents(tmp_path / "out") == before
    sample_run(replace(tower(tmp_path), text=TOWER + "\n"), tmp_path / "out")  # rules that were edited


def test_a_manifest_cannot_make_a_run_remove_files_elsewhere(tmp_path):
    precious = tmp_path / "precious.txt"
    precious.write_text("mine")
    (tmp_path / "out").mkdir()
    files = {"../precious.txt": "", str(precious): "", "..\\precious.txt": ""}
    (tmp_path / "out" / "manifest.json").write_text(json.dumps({"grammar": {"name": "tower"}, "files": files}))
    sample_run(tower(tmp_path), tmp_path / "out")
    assert precious.read_text() == "mine"


def test_properties_of_footprints_become_attributes_unless_the_request_says_otherwise(tmp_path):
    square = [[0, 0], [10, 0], [10, 10], [0, 10], [0, 0]]
    features = [
        {"type": "Feature", "geometry": {"type": "Polygon", "coordinates": [square]}, "properties": properties}
        for properties in ({"height": 2, "levels": 7, "unknown": 3}, {"height": "5", "style": 1900}, {})
    ]
    path = tmp_path / "lots.geojson"
    path.write_text(json.dumps({"type": "FeatureCollection", "features": features, "crs": None}))
    request = replace(tower(tmp_path, num_models=2), footprints=read_footprints(str(path)))
    result = sample_run(request, tmp_path / "out")
    heights = [read(result.folder / m.file).extents[1] for m in result.models]
    assert heights[:4] == pytest.approx([2, 2, 5, 5])
    assert len(set(np.round(heights[4:], 6))) == 2
    overruled = sample_run(replace(request, attributes={"height": 3.0}), tmp_path / "out")
    heights = [read(overruled.folder / m.file).extents[1] for m in overruled.models]
    assert heights == pytest.approx([3.0] * 6)


def test_models_on_footprints_share_one_file_where_the_map_has_them(tmp_path):
    lots = "MULTIPOLYGON (((0 0, 10 0, 10 10, 0 10, 0 0)), ((100 50, 110 50, 110 60, 100 60, 100 50)))"
    request = replace(tower(tmp_path, num_models=1, single_file=True), footprints=read_footprints(lots))
    result = sample_run(request, tmp_path / "out")
    low, high = read(result.folder / "tower.glb").bounds
    assert (low[[0, 2]], high[[0, 2]]) == (pytest.approx([0, -60]), pytest.approx([110, 0]))


def test_batches_cover_every_model_once_and_span_footprints(tmp_path):
    request = replace(tower(tmp_path, num_models=150), footprints=read_footprints("5x5") * 3)
    batches = cut_batches(request)
    models = [b.first_model + k for b in batches for k in range(b.num_models)]
    assert models == list(range(450))
    assert [b.num_models for b in batches] == [64] * 7 + [2]


def test_runs_of_the_first_format_are_resumed_where_their_batches_are_the_same(tmp_path):
    request = replace(tower(tmp_path, num_models=2), footprints=read_footprints("5x5") * 2)
    for name, cut_alike in (("one", True), ("two", False)):
        asked = replace(request, footprints=request.footprints[:1]) if cut_alike else request
        first = sample_run(asked, tmp_path / name)
        before = contents(first.folder)
        values = json.loads(first.manifest.read_text())
        first.manifest.write_text(json.dumps({**values, "format": 1}))
        (first.folder / first.models[0].file).unlink()
        if cut_alike:
            sample_run(asked, first.folder, resume=True)
            assert contents(first.folder) == before
        else:
            with pytest.raises(UsageError, match=r"2 footprints of an earlier version.*without `resume=True`"):
                sample_run(asked, first.folder, resume=True)
            sample_run(asked, first.folder)
            assert contents(first.folder) == before


def test_errors_in_the_rules_come_before_anything_is_written(tmp_path):
    request = SampleRequest(name="broken", text=BROKEN, assets=tmp_path)
    with pytest.raises(LanguageError, match=r"broken\.cga:"):
        sample_run(request, tmp_path / "out")
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"num_models": 0}, "number of models"),
        ({"num_models": 10**12 + 1}, "number of models"),
        ({"seed": -1}, "seed"),
        ({"seed": 2**64}, "seed"),
        ({"file_format": "fbx"}, "glb, obj, ply"),
        ({"file_format": "obj", "instancing": "gpu"}, "needs format 'glb'"),
        ({"name": "../escape"}, "cannot name files"),
        ({"name": ".."}, "cannot name files"),
        ({"renderer": "vulkan"}, "expected one of auto, cast, gl"),
        ({"scale": "none"}, "expected one of same, each"),
    ],
)
def test_requests_that_make_no_sense_are_refused(tmp_path, options, message):
    values: dict[str, Any] = {"name": "tower", "text": TOWER, "assets": tmp_path, **options}
    with pytest.raises(UsageError, match=re.escape(message)):
        SampleRequest(**values)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda v: v.update(format=9), "found format 9"),
        (lambda v: v["grammar"].update(text=TOWER + " "), "does not match its hash"),
        (lambda v: v["request"].update(seed="5"), "does not describe a run"),
        (lambda v: v["request"].update(name="../../x"), "does not describe a run"),
        (lambda v: v["request"].update(extra=1), "does not describe a run"),
        (lambda v: v["request"].update(footprints=[{"polygon": [1, 2]}]), "does not describe a run"),
        (lambda v: v.pop("request"), "damaged"),
        (lambda v: v.update(files=3), "damaged"),
    ],
)
def test_a_manifest_that_was_tampered_with_is_refused(tmp_path, change, message):
    result = sample_run(tower(tmp_path), tmp_path / "out")
    values = json.loads(result.manifest.read_text())
    change(values)
    result.manifest.write_text(json.dumps(values))
    with pytest.raises(AssetError, match=message):
        read_manifest(result.manifest)


@pytest.mark.parametrize("content", ["", "[]", "{}", "[" * 100_000])
def test_a_file_that_is_no_manifest_is_refused(tmp_path, content):
    (tmp_path / "manifest.json").write_text(content)
    with pytest.raises(AssetError, match="damaged"):
        read_manifest(tmp_path)


@pytest.mark.parametrize("footprint", ["", "rows"])
def test_chosen_models_are_those_of_the_whole_run(tmp_path, monkeypatch, footprint):
    monkeypatch.setattr(batches_module, "BATCH_MODELS", 2)
    footprints = read_footprints("MULTIPOLYGON (((0 0, 9 0, 9 9, 0 0)), ((20 0, 30 0, 30 9, 20 0)))")
    options = {"footprints": footprints, "num_models": 5} if footprint else {"num_models": 10}
    whole = sample_run(tower(tmp_path, **options), tmp_path / "whole")
    some = sample_run(tower(tmp_path, **options, models=(8, 3, 4, 5, 3)), tmp_path / "some")
    assert [model.index for model in some.models] == [3, 4, 5, 8]
    for model in some.models:
        assert model == whole.models[model.index]
        assert (some.folder / model.file).read_bytes() == (whole.folder / model.file).read_bytes()
    assert len(list(some.folder.glob("*.glb"))) == 4
    again, different = repeat_run(read_manifest(some.manifest), tmp_path / "again")
    assert (again.request.models, different) == ((3, 4, 5, 8), ())
    with pytest.raises(UsageError, match=r"models was \[3, 4, 5, 8\] and is 'as usual'"):
        sample_run(tower(tmp_path, **options), some.folder, resume=True)
    (some.folder / "tower-00004.glb").write_bytes(b"")
    sample_run(some.request, some.folder, resume=True)
    assert contents(some.folder) == contents(again.folder)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "expected numbers such as 3,7,9-12, found ''"),
        ("3,,4", "expected numbers such as 3,7,9-12, found ''"),
        ("-1", "expected numbers such as 3,7,9-12, found '-1'"),
        ("٣", "expected numbers such as 3,7,9-12"),
        ("9-3", "the smaller number first, as in 3-9, found '9-3'"),
        ("16", "the run has the models 0 to 15, found '16'"),
    ],
)
def test_lists_of_models_that_are_none_are_refused(text, message):
    with pytest.raises(UsageError, match=re.escape(message)):
        read_model_numbers(text, 16)


@pytest.mark.parametrize("models", [(3,), (-1,), (True,), (0.0,), range(20_000)])
def test_a_request_refuses_models_that_its_run_does_not_have(tmp_path, models):
    with pytest.raises(UsageError, match=r"models: (the run has the models 0 to 2, found|expected at most 10,000)"):
        tower(tmp_path, models=models)
    with pytest.raises(UsageError, match=r"models: expected at most 10,000 of them, found '0-99999999999' and"):
        read_model_numbers("0-99999999999")


def test_one_file_of_chosen_models_has_their_numbers_attributes_and_reports(tmp_path):
    rules = 'attr height = rand(3, 9)\nLot --> extrude(height) report("top", scope.sy) Box'
    options = {"text": rules, "num_models": 9, "models": (2, 3, 7)}
    apart = sample_run(replace(tower(tmp_path), **options), tmp_path / "apart")
    together = sample_run(replace(tower(tmp_path), **options, single_file=True), tmp_path / "together")
    nodes = {node["name"]: node.get("extras") for node in gltf(together.folder / "tower.glb")["nodes"]}
    for model in apart.models:
        own = {node["name"]: node.get("extras") for node in gltf(apart.folder / model.file)["nodes"]}
        assert nodes[f"model_{model.index}"] == own[f"tower-{model.index:05d}"]
        assert set(nodes[f"model_{model.index}"]) == {"attributes", "reports"}


def gltf(path):
    content = path.read_bytes()
    return json.loads(content[20 : 20 + int.from_bytes(content[12:16], "little")])


@pytest.mark.parametrize(
    ("rules", "start", "message"),
    [
        (
            "Help --> NIL  Plot --> s(3, 0, 3) Mass  Mass --> A",
            "",
            "they begin with Help; `start_rule=Plot` may be meant",
        ),
        ("Plot --> Mass  Mass --> NIL", "", "they begin with Plot$"),
        ("Wall(x) --> A  Help --> NIL  Plot --> Wall(1) B", "", "they begin with Help; `start_rule=Plot` may be meant"),
        ("Help --> NIL  Plot --> A", "Plot", None),
        ("@StartRule Help --> NIL  Plot --> A B", "", None),
    ],
)
def test_empty_models_that_nobody_chose_a_start_rule_for_name_the_likely_one(tmp_path, rules, start, message):
    request = SampleRequest(name="a", text=rules, assets=tmp_path, num_models=1, image=False, start_rule=start)
    found = [finding.message for finding in sample_run(request, tmp_path / "run").warnings]
    assert len(found) == (message is not None)
    assert message is None or re.search(message, found[0])


def test_a_run_warns_of_empty_models_if_those_of_all_batches_are_empty(tmp_path):
    request = SampleRequest(name="a", text="Lot --> 50% : A else : NIL", assets=tmp_path, num_models=9, image=False)
    shapes = [model.shapes for model in sample_run(request, tmp_path / "all").models]
    empty = [number for number, count in enumerate(shapes) if count == 1]
    for name, chosen, num_warnings in (("some", (empty[0], shapes.index(2)), 0), ("none", (empty[0], empty[-1]), 1)):
        result = sample_run(replace(request, models=tuple(sorted(chosen))), tmp_path / name)
        assert len(result.warnings) == num_warnings
