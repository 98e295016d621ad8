"""``grammarlab facade layers``."""

import json
from pathlib import Path

import numpy as np
import pytest
import trimesh
from PIL import Image

from grammarlab.facade.file import load_facade
from grammarlab.facade.tree import check
from tests.layers.samples import DESIGNS, RESIDENTIAL

KEYS = {
    *("counters", "words", "columns", "omega", "span", "sizes", "sizing_residual", "energy", "bound", "proven"),
    "seconds",
}
HOUSE = DESIGNS / "residential.toml"


def layouts(run, *arguments) -> list[dict]:
    return json.loads(run("facade", "layers", *arguments, "--json").stdout)["layouts"]


def test_the_house_of_the_paper(run, tmp_path: Path) -> None:
    found = layouts(run, HOUSE, "-n", 3, "-o", tmp_path / "out")
    assert len(found) == 3
    best = found[0]
    assert best.keys() >= KEYS
    assert best["counters"] == {"k": 2}
    assert best["words"] == [
        {"layer": "roof", "x": "H", "y": "PQR"},
        {"layer": "door", "x": "fDf", "y": "PQ"},
        {"layer": "columns", "x": "CeC", "y": "PQ"},
        {"layer": "house", "x": "ABABA", "y": "PQ"},
    ]
    assert best["columns"]["x"] == [
        ["f1", "C", "A"], ["f2", "e", "B"], ["D", "e", "A"], ["f2", "e", "B"], ["f1", "C", "A"],
    ]  # fmt: skip
    assert best["columns"]["y"] == [["P"] * 4, ["Q"] * 4, ["R", "ε", "ε", "ε"]]
    assert best["columns"]["x:roof"] == [["H"]]
    assert best["omega"] == pytest.approx(0.2)
    expected = {"A": 104 / 105, "C": 104 / 105, "D": 104 / 105, "B": 1.514286, "e": 4.019048, "f": 2.504762, "H": 6.0}
    assert {name: best["sizes"][name] for name in expected} == pytest.approx(expected, abs=1e-6)
    assert best["sizing_error"] == pytest.approx(0.019524, abs=1e-6)
    assert best["sizing_residual"] <= 1e-9
    assert best["proven"]
    assert best["bound"] == pytest.approx(best["energy"])
    assert [each["energy"] for each in found] == sorted(each["energy"] for each in found)
    for ends, side in ((best["ends"]["x"], 6.0), (best["ends"]["y"], 4.5)):
        assert ends[0] == 0.0
        assert ends[-1] == pytest.approx(side, abs=1e-9)


def test_the_files_of_a_layout(run, tmp_path: Path) -> None:
    (best,) = layouts(run, HOUSE, "-n", 1, "-o", tmp_path / "out")
    files = {key: Path(name) for key, name in best["files"].items()}
    assert set(files) == {"facade", "drawing", "picture", "glb", "obj", "rules"}
    facade = check(load_facade(files["facade"]))
    assert (facade.width, facade.height) == (6.0, 4.5)
    for key in ("glb", "obj"):
        mesh = trimesh.load(files[key], force="mesh")
        assert isinstance(mesh, trimesh.Trimesh)
        assert np.allclose(np.ptp(mesh.bounds, axis=0)[:2], (6.0, 4.5), atol=1e-5)
    with Image.open(files["picture"]) as picture:
        assert picture.width > picture.height
    assert files["drawing"].read_text(encoding="utf-8").startswith("<svg")
    run("check", files["rules"])


def test_larger_canvases_change_counters_only(run, tmp_path: Path) -> None:
    found = {width: layouts(run, HOUSE, "--width", width, "-n", 1, "-o", tmp_path / str(width))[0] for width in (6, 12)}
    assert [each["counters"] for each in found.values()] == [{"k": 2}, {"k": 4}]
    assert found[12]["words"][3]["x"] == "A" + "BA" * 4
    for layer in (0, 1, 2):
        assert found[12]["words"][layer] == found[6]["words"][layer]
    assert found[12]["width"] == 12.0


def test_a_second_run_replaces_the_first(run, tmp_path: Path) -> None:
    layouts(run, HOUSE, "-n", 3, "-o", tmp_path / "out")
    layouts(run, HOUSE, "-n", 1, "-o", tmp_path / "out")
    assert not {path.name for path in (tmp_path / "out").iterdir() if path.name.startswith(("002", "003"))}


@pytest.mark.parametrize("name", ["residential", "apartment", "concert_hall"])
def test_shipped_designs_are_solved_and_proven(run, tmp_path: Path, name: str) -> None:
    (best,) = layouts(run, DESIGNS / f"{name}.toml", "-n", 1, "-o", tmp_path / "out")
    assert best["proven"]
    assert "outside" not in load_facade(Path(best["files"]["facade"])).labels


def test_rules_of_many_canvases(run, tmp_path: Path) -> None:
    found = json.loads(
        run("facade", "layers", HOUSE, "-n", 2, "-o", tmp_path / "out", "--widths", "6:12:3", "--json").stdout
    )
    assert found["family"]["rules"] < found["family"]["rules_alone"]
    made = json.loads(run("sample", found["family"]["file"], "-n", 4, "-o", tmp_path / "models", "--json").stdout)
    assert made


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--width", "0"], "above 0"),
        (["--width", "1e9"], "at most 10,000"),
        (["--height", "nan"], "above 0"),
        (["-n", "0"], "-n"),
        (["-n", "101"], "-n"),
        (["--widths", "6"], "such as"),
        (["--widths", "9:6"], "such as"),
        (["--heights", "1:2:1000"], "such as"),
    ],
)
def test_mistakes_of_use(run, tmp_path: Path, options: list[str], message: str) -> None:
    result = run("facade", "layers", HOUSE, "-o", tmp_path / "out", *options, code=2)
    assert message in result.stderr
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('"A(BA)^k"', '"A(BX)^k"', "house.toml:19:10: error: unknown symbol 'X'"),
        ('"A(BA)^k"', '"((A)^kB)^m"', "cannot be nested"),
        ("size = 1.6", "size = 0", "above 0"),
        ('"fdf; d := D"', '"f^mdf; d := D"', "counter m has no bound"),
        ('"PQ"', '"P^40"', "no word fits"),
        ("width = 6.0", "width = 0.0", "above 0"),
        ("width = 6.0", "width = 1e9", "at most 10,000"),
        ("width = 6.0", "width = 9999", "more than 400 letters"),
        ("[[layers]]", "[[layers]]\nx = 3\n[[layers]]", "expected a pattern"),
        ("[[layers]]", '[[layers]]\nx = "A"\ny = "P"\n' * 3000 + "[[layers]]", "at most 64 layers"),
    ],
)
def test_mistakes_in_designs(run, tmp_path: Path, old: str, new: str, message: str) -> None:
    file = tmp_path / "house.toml"
    file.write_text(RESIDENTIAL.replace(old, new, 1), encoding="utf-8")
    result = run("facade", "layers", file, "-o", tmp_path / "out", code=1)
    assert message in result.stderr
    assert not (tmp_path / "out").exists()
