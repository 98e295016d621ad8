"""``grammarlab sample``."""

import json
import sys

import pytest
import trimesh

from grammarlab.cli import sample as sample_module
from grammarlab.export import FORMATS
from tests.geometry.footprints.maps import BOW_TIE, SQUARE, collection, feature, moved, named, polygon, written
from tests.runs.grammars import BROKEN, TOWER


def test_the_formats_are_those_of_the_writers():
    assert tuple(sample_module.FileFormat) == FORMATS


def test_a_shipped_grammar_is_sampled_by_name_with_a_picture(run, tmp_path):
    result = run("sample", "toy", "-n", "2", "--seed", "5", "-o", tmp_path / "out", "--jobs", "1")
    assert "2 models of toy" in result.stderr
    assert result.stdout == ""
    names = {p.name for p in (tmp_path / "out").iterdir()}
    assert names == {"toy-00000.glb", "toy-00001.glb", "toy.png", "derivations", "manifest.json"}
    assert (tmp_path / "out" / "toy.png").read_bytes().startswith(b"\x89PNG")


def test_json_is_one_object_about_the_run(run, rules, tmp_path):
    path = rules(TOWER)
    result = run(
        "sample", path, "-n", "3", "--seed", "8", "-o", tmp_path / "out", "--no-image", "--json", "--jobs", "1"
    )
    values = json.loads(result.stdout)
    told = {"grammar", "hash", "seed", "models", "prints", "kept_files", "warnings", "sheet", "derivations", "manifest"}
    assert (set(values), values["warnings"]) == (told | {"place", "remarks"}, [])
    assert (values["grammar"], values["seed"], values["sheet"]) == ("house", 8, None)
    assert [m["index"] for m in values["models"]] == [0, 1, 2]
    for model in values["models"]:
        assert set(model) == {
            "index",
            "file",
            "seed",
            "shapes",
            "triangles",
            "log_probability",
            "reports",
            "origin",
        } | {
            "tries",
            "accepted",
        }
        mesh = trimesh.load(model["file"], force="mesh")
        assert isinstance(mesh, trimesh.Trimesh)
        assert len(mesh.faces) == model["triangles"]


def test_what_rules_print_is_told_also_when_a_run_is_resumed(run, rules, tmp_path):
    path = rules('Lot --> print("wide " + scope.sx) print("a\u001bb") extrude(3)')
    options = ["-n", "30", "-o", tmp_path / "out", "--no-image", "--jobs", "1", "--footprint", "8x3"]
    first = run("sample", path, *options)
    assert first.stderr.count("wide 8\n") + first.stderr.count("a\\x1bb\n") == sample_module.MOST_PRINTS
    assert "10 more printed lines" in first.stderr
    again = json.loads(run("sample", path, *options, "--resume", "--json").stdout)
    assert sorted(again["prints"]) == ["a\u001bb"] * 30 + ["wide 8"] * 30


def test_options_reach_the_model(run, rules, tmp_path):
    options = ["--attr", "height=7.5", "--footprint", "8x3", "--format", "ply", "--no-image", "-n", "1"]
    run("sample", rules(TOWER), *options, "-o", tmp_path / "out")
    mesh = trimesh.load(tmp_path / "out" / "house-00000.ply", force="mesh")
    assert isinstance(mesh, trimesh.Trimesh)
    assert mesh.extents == pytest.approx([8, 7.5, 3])


@pytest.mark.parametrize(
    ("text", "num", "is_said"),
    [
        ("attr h = 3\nLot --> extrude(h) A", 2, True),
        ("const h = 3\nLot --> extrude(h) A", 2, True),
        ("Lot --> extrude(3) A", 1, False),
        ("Lot --> extrude(rand(3, 9)) A", 2, False),
        ("Lot --> 50% : A else : extrude(3) B", 2, False),
        ("Lot --> scatter(surface, 3, uniform) { A }", 2, False),
        ('Lot --> texture(fileRandom("*.png")) A', 2, False),
        ("Lot --> extrude(3 + seedian / 1000000000) A", 2, False),
    ],
)
def test_rules_without_chance_are_said_to_make_equal_models(run, rules, tmp_path, text, num, is_said):
    said = run("sample", rules(text), "-n", str(num), "--no-image", "-o", tmp_path / "out").stderr
    assert ("all models are equal: the rules draw nothing at random" in said) == is_said
    assert ("--attr NAME=VALUE makes others" in said) == (is_said and "attr" in text)


def test_a_start_rule_can_be_chosen(run, rules, tmp_path):
    options = ["--start", "Storey", "--no-image", "-n", "1", "--json"]
    values = json.loads(run("sample", rules(TOWER), *options, "-o", tmp_path / "out").stdout)
    assert values["models"][0]["shapes"] == 2


def test_a_manifest_repeats_its_run_and_says_so(run, rules, tmp_path):
    run("sample", rules(TOWER), "-n", "2", "--no-image", "-o", tmp_path / "a")
    result = run("sample", "--manifest", tmp_path / "a" / "manifest.json", "-o", tmp_path / "b")
    assert "equal to those of the manifest" in result.stderr
    (tmp_path / "b" / "house-00001.glb").write_bytes(b"")
    run("sample", "--manifest", tmp_path / "a", "-o", tmp_path / "b", code=2)
    again = run("sample", "--manifest", tmp_path / "a", "-o", tmp_path / "b", "--resume", "--json")
    assert json.loads(again.stdout)["different_files"] == []


def test_each_grammar_has_a_folder_of_its_own(run, rules, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    options = ("-n", 1, "--no-image", "--jobs", 1)
    run("sample", rules(TOWER), *options)
    run("sample", "toy", *options)
    run("sample", rules(TOWER), *options)
    assert {path.name for path in (tmp_path / "out").iterdir()} == {"house", "toy"}
    assert "holds models of 'toy'" in run("sample", rules(TOWER), *options, "-o", "out/toy", code=2).stderr
    assert (tmp_path / "out" / "toy" / "toy-00000.glb").is_file()
    assert "give another folder" in run("sample", "--manifest", "out/toy", code=2).stderr
    assert "bit for bit" in run("sample", "--manifest", "out/toy/manifest.json", "-o", "again").stderr


def test_a_manifest_leaves_no_room_for_other_options(run, rules, tmp_path):
    run("sample", rules(TOWER), "-n", "1", "--no-image", "-o", tmp_path / "a")
    result = run("sample", "--manifest", tmp_path / "a", "--seed", "3", "-o", tmp_path / "b", code=2)
    assert "leave out seed" in result.stderr


def test_resume_goes_on_and_refuses_another_run(run, rules, tmp_path):
    path = rules(TOWER)
    run("sample", path, "-n", "2", "--no-image", "-o", tmp_path / "a")
    run("sample", path, "-n", "2", "--no-image", "-o", tmp_path / "a", "--resume")
    result = run("sample", path, "-n", "3", "--no-image", "-o", tmp_path / "a", "--resume", code=2)
    assert "num_models was 2 and is 3" in result.stderr


@pytest.mark.parametrize(
    ("options", "code", "message"),
    [
        (["bilding"], 2, "Did you mean 'building'?"),
        ([], 2, "which grammar"),
        (["toy", "--attr", "h1"], 2, "expected name=value"),
        (["toy", "--attr", "h1=1", "--attr", "h1=2"], 2, "given twice"),
        (["toy", "--attr", "unknown=1"], 2, "unknown attribute unknown"),
        (["toy", "--attr", "h1=nan"], 2, "finite"),
        (["toy", "--attr", "side=wide"], 2, "expected a finite number"),
        (["toy", "--start", "Nothing"], 2, "Nothing"),
        (["toy", "--footprint", "POLYGON ((0 0, 9 9, 9 0, 0 9, 0 0))"], 1, "self-intersection"),
        (["toy", "--footprint", "nowhere.geojson"], 1, "no such footprint file"),
        (["toy", "--assets", "/nonexistent"], 2, "assets folder"),
        (["toy", "--format", "ply", "--instancing", "gpu"], 2, "needs format 'glb'"),
        (["toy", "--seed", str(2**64)], 2, "seed"),
        (["toy", "-n", "0"], 2, "'--num-models': Input should be greater than or equal to 1"),
        (["toy", "-n", "-3"], 2, "'--num-models': Input should be greater than or equal to 1"),
        (["--manifest", "/nonexistent/manifest.json"], 1, "no such manifest"),
    ],
)
def test_bad_input_ends_in_one_message(run, tmp_path, monkeypatch, options, code, message):
    monkeypatch.chdir(tmp_path)
    result = (
        run("sample", "-n", "1", *options, "--no-image", code=code)
        if "--manifest" not in options
        else run("sample", *options, code=code)
    )
    assert message in result.stderr


def test_errors_in_the_rules_come_with_line_and_caret(run, rules, tmp_path):
    result = run("sample", rules(BROKEN), "-o", tmp_path / "out", code=1)
    assert "house.cga:" in result.stderr
    assert "^" in result.stderr


def test_endless_recursion_ends_in_an_error_that_names_the_rule(run, rules, tmp_path):
    path = rules("Lot --> split(x) { '0.5 : Half | '0.5 : Half }\nHalf --> 99% : Lot else : NIL")
    result = run("sample", path, "-n", "1", "--no-image", "-o", tmp_path / "out", code=1)
    assert "Lot" in result.stderr


def test_an_error_in_another_process_reads_the_same(run, rules, tmp_path):
    path = rules('attr a = 50% : 2 else : "tall"\nLot --> extrude(a)')
    options = ["--no-image", "-n", "200", "--attr", "a=red"]
    alone = run("sample", path, *options, "-o", tmp_path / "a", "--jobs", "1", code=1)
    shared = run("sample", path, *options, "-o", tmp_path / "b", "--jobs", "2", code=1)
    assert alone.stderr == shared.stderr != ""


def test_an_unwritable_folder_is_an_error(run, tmp_path):
    (tmp_path / "file").write_text("in the way")
    result = run("sample", "toy", "-n", "1", "--no-image", "-o", tmp_path / "file" / "out", code=1)
    assert str(tmp_path / "file") in result.stderr


def test_files_that_differ_from_what_the_earlier_run_wrote_are_named(run, rules, tmp_path):
    command = ("sample", rules(TOWER), "-n", 1, "--no-image", "-o", tmp_path / "out")
    run(*command)
    manifest = tmp_path / "out" / "manifest.json"
    values = json.loads(manifest.read_text())
    names = [f"mine-{number}\x1b[31m.txt" for number in range(8)]
    for name in names:
        (tmp_path / "out" / name).write_text("mine")
    values["files"] |= dict.fromkeys(names, "x")
    manifest.write_text(json.dumps(values))
    message = run(*command).stderr
    assert f"kept in {tmp_path / 'out'}, since they are not as the earlier run recorded them" in message
    assert "mine-0?[31m.txt" in message
    assert "and 3 more" in message
    assert len(list((tmp_path / "out").glob("mine-*"))) == 8
    assert json.loads(run(*command, "--json").stdout)["kept_files"] == []


@pytest.mark.skipif(sys.platform == "win32", reason="this system has no limit for the size of files")
@pytest.mark.parametrize("options", [("--format", "ply"), ("--single-file",)])
def test_a_full_disk_is_an_error_that_names_the_file(run, rules, tmp_path, options):
    import resource

    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    command = ("sample", rules(TOWER), "-n", 2, "--no-image", "-o", tmp_path / "out", *options)
    try:
        resource.setrlimit(resource.RLIMIT_FSIZE, (100, before[1]))
        result = run(*command, code=1)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    assert f"error: {tmp_path / 'out'}/" in result.stderr
    assert ".part-" not in result.stderr
    assert not list(tmp_path.rglob(".*"))
    run(*command)


def test_completion_offers_shipped_grammars():
    assert sample_module.complete_grammar("sky") == ["skyscraper"]


def test_the_picture_of_a_manifest_can_be_drawn_by_another_renderer(run, rules, tmp_path):
    run("sample", rules(TOWER), "-n", "1", "--scale", "same", "-o", tmp_path / "a")
    path = tmp_path / "a" / "manifest.json"
    values = json.loads(path.read_text())
    values["request"]["renderer"] = "gl"
    path.write_text(json.dumps(values))
    result = run("sample", "--manifest", path, "--renderer", "cast", "-o", tmp_path / "b")
    assert "equal to those of the manifest" in result.stderr
    assert json.loads((tmp_path / "b" / "manifest.json").read_text())["request"]["renderer"] == "cast"


def test_opengl_that_does_not_work_is_an_error_that_says_what_to_do(run, rules, tmp_path, monkeypatch):
    monkeypatch.setattr("grammarlab.rendering.choice.PLATFORMS", ("nonsense",))
    result = run("sample", rules(TOWER), "-n", "1", "--renderer", "gl", "-o", tmp_path / "out", code=2)
    assert "OpenGL does not work here" in result.stderr
    assert "'cast'" in result.stderr
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("option", ["--renderer", "--scale"])
def test_unknown_ways_to_draw_are_refused_with_the_choices(run, option):
    assert "'vulkan' is not one of" in run("sample", "toy", option, "vulkan", code=2).stderr


def test_what_is_left_out_or_cannot_be_carried_out_is_told_once(run, rules, tmp_path):
    path = rules(
        'import lib : "lib.cga"\nimport gone : "gone.cga"\nLot --> setupUV(0, 1, 1) set(trim.vertical, false) lib.A'
    )
    rules("A --> setupUV(2, 1, 1) extrude(3) [ extrud(2) B ] [ extrud(3) ]", "lib.cga")
    told = run("sample", path, "-n", "2", "-o", tmp_path / "out", "--no-image", "--jobs", "1").stderr.splitlines()
    assert told[0] == "ignored, since no shape or colour depends on it: setupUV"
    assert told[1].startswith('not supported: the import "gone.cga", which cannot be read')
    assert told[2].startswith("warning: neither a rule nor an operation, so that shapes end there: ")
    assert "extrud (`grammarlab check" in told[2]
    assert told[3].startswith("--library DIR names a folder of further projects")


MISSING = (
    'attr tree = "trees/oak.obj"\n'
    'Lot --> extrude(3) comp(f) { side : i("win" + "dow.glb") A | top : i(tree) B }\nB --> i(tree) i("seat.obj")'
)


def test_meshes_that_are_not_there_are_told_once_with_their_place(run, rules, tmp_path):
    options = ["-n", "2", "-o", tmp_path / "out", "--no-image", "--jobs", "1"]
    path = rules(MISSING)
    told = [line for line in run("sample", path, *options).stderr.splitlines() if "missing-asset" in line]
    places = {"seat.obj": "3:15", "trees/oak.obj": "2:68", "window.glb": "2:37"}
    assert told == [
        f'house.cga:{place}: warning: there is no asset "{name}" in the asset folder {tmp_path}; '
        "a box stands in its place [missing-asset]"
        for name, place in places.items()
    ]
    again = run("sample", path, *options, "--resume", "--json")
    assert again.stderr.count("hint: say where the meshes are with --assets DIR") == 1
    found = json.loads(again.stdout)["warnings"]
    assert {one["code"] for one in found} == {"missing-asset"}
    recorded = json.loads((tmp_path / "out" / "manifest.json").read_text())["missing_assets"]
    assert [(one["path"], one["location"]) for one in recorded] == [
        (name, one["location"]) for name, one in zip(places, found, strict=True)
    ]


def test_many_meshes_that_are_not_there_are_counted(run, rules, tmp_path):
    path = rules("Lot --> " + " ".join(f'i("{k}.obj")' for k in range(30)))
    told = run("sample", path, "-n", "1", "-o", tmp_path / "out", "--no-image", "--jobs", "1").stderr
    assert told.count("missing-asset") == sample_module.MOST_WARNINGS
    assert "and 10 more missing assets" in told


def test_meshes_outside_their_folder_are_still_refused(run, rules, tmp_path):
    path = rules('Lot --> i("../../gone.obj")')
    told = run("sample", path, "-n", "1", "-o", tmp_path / "out", "--no-image", "--jobs", "1", code=1).stderr
    assert "lies outside the asset folder" in told


def test_images_that_are_not_there_are_told_once(run, rules, tmp_path):
    path = rules(
        'Lot --> extrude(3) comp(f) { top : texture("b.png") A | side : texture("/City/maps/a.jpg") B '
        '| all : C texture("x") NIL }'
    )
    told = run("sample", path, "-n", "2", "-o", tmp_path / "out", "--no-image", "--jobs", "1").stderr
    assert told.count(f"no such image in {tmp_path}: /City/maps/a.jpg, b.png\n") == 1


def test_a_run_with_imports_can_be_repeated_without_the_imported_files(run, rules, tmp_path):
    path = rules('import lib : "lib.cga"\nattr h = 5\nLot --> lib.A report("size." + h, scope.sx)')
    library = rules("attr h = 1\nA --> extrude(h)", "lib.cga")
    options = ["--no-image", "--jobs", "1"]
    result = run("sample", path, "-n", "1", "--footprint", "4x3", "-o", tmp_path / "one", "--json", *options)
    (model,) = json.loads(result.stdout)["models"]
    assert trimesh.load(model["file"], force="mesh").extents.tolist() == [4.0, 5.0, 3.0]
    assert model["reports"]["size.5"]["sum"] == 4.0
    library.unlink()
    again = run("sample", "--manifest", tmp_path / "one", "-o", tmp_path / "two", "--jobs", "1", "--json")
    assert json.loads(again.stdout)["different_files"] == []


def test_what_is_left_out_of_a_map_and_where_it_is_is_told(run, rules, tmp_path):
    path = rules("attr height = 5 Lot --> extrude(height) Mass")
    squares = [moved(SQUARE, 7.1 + k * 1e-3, 50.9, 1e-5) for k in range(3)]
    features = [
        feature(polygon(squares[0]), height="40 ft"),
        feature(polygon(squares[1]), height="about 12"),
        *(feature({"type": "LineString", "coordinates": squares[2]}) for _ in range(sample_module.MOST_NAMES + 2)),
        feature(polygon(moved(BOW_TIE, 7.1, 50.9, 1e-5))),
    ]
    lots = written(tmp_path, collection(*features))
    options = ["sample", path, "-n", "1", "--footprint", lots, "-o", tmp_path / "out", "--no-image"]
    result = run(*options)
    for line in (
        "10 geometries are left out:",
        "  lots.geojson, feature 2: a LineString is not an outline",
        "  … and 2 more; the manifest lists them",
        "1 bad outline is left out:",
        "  lots.geojson, feature 12: self-intersection at longitude 7.10045, latitude 50.90004",
        "1 property is not used, and that of the file is used instead:",
        "  lots.geojson, feature 1: attribute 'height': expected a finite number, found 'about 12'",
        "2 models of house in",
        "origin: longitude 7.1005500, latitude 50.9000400 (OGC:CRS84); x is east of it and z south, in metres",
    ):
        assert line in result.stderr
    values = json.loads(run(*options, "--json").stdout)
    assert len(values["remarks"]) == 12
    assert values["remarks"][-1]["source"] == "lots.geojson, feature 1"
    assert values["place"]["latitude"] == pytest.approx(50.90004)


def test_showing_a_model_tells_what_is_left_out_of_its_map(run, rules, tmp_path):
    path = rules("attr height = 5 Lot --> extrude(height) Mass")
    lots = written(tmp_path, collection(feature(polygon(SQUARE), height="tall"), feature(polygon(BOW_TIE)), crs=None))
    result = run("show", path, "--model", "3", "--footprint", lots)
    assert "feature 1: self-intersection" in result.stderr
    assert "feature 0: attribute 'height'" in result.stderr


def test_without_the_extra_a_crs_that_is_not_metres_is_refused_with_the_command_that_converts_it(
    run, rules, tmp_path, monkeypatch
):
    monkeypatch.setitem(sys.modules, "pyproj", None)
    lots = written(tmp_path, collection(feature(polygon(SQUARE)), crs=named("EPSG:3857")))
    result = run("sample", rules("Lot --> Mass"), "--footprint", lots, "-o", tmp_path / "out", code=1)
    assert "EPSG:3857" in result.stderr
    assert "ogr2ogr -t_srs EPSG:4326 lots-degrees.geojson lots.geojson" in result.stderr
    assert not (tmp_path / "out").exists()


def test_rows_are_sampled_without_files_of_models(run, rules, tmp_path):
    arguments = ("sample", rules(TOWER), "-n", "5", "--no-models", "--shard-models", "2", "-o", tmp_path / "out")
    result = run(*arguments, "--json", "--jobs", "1")
    values = json.loads(result.stdout)
    assert (values["models"], values["shards"], values["made"]) == (5, 3, 3)
    again = run(*arguments, "--jobs", "1")
    assert "5 models of house in 3 tables, 0 of them made now" in again.stderr
    assert again.stdout.strip() == str(tmp_path / "out")
    assert "leave out --format" in run(*arguments, "--format", "obj", code=2).stderr
    assert "--shard-models needs --no-models" in run("sample", "toy", "--shard-models", "2", code=2).stderr
    assert "(--no-models)" in run("sample", "toy", "-n", "3000000", code=2).stderr


def test_chosen_models_of_a_run_are_sampled_and_bad_lists_refused(run, rules, tmp_path):
    path = rules(TOWER)
    options = ("sample", path, "--no-image", "--jobs", "1", "-o", tmp_path / "out")
    run(*options, "--models", "3, 20-21")
    assert {p.stem for p in (tmp_path / "out").glob("*.glb")} == {"house-00003", "house-00020", "house-00021"}
    for more, message in (
        (("--models", "3", "-n", "3"), "the run has the models 0 to 2, found 3. A larger --num-models has more"),
        (("--models", "x"), "models: expected numbers such as 3,7,9-12, found 'x'"),
        (("--models", "3", "--no-models"), "--no-models writes no files of models: leave out --models"),
    ):
        assert message in run(*options, *more, code=2).stderr
