"""``grammarlab facade grammar``, ``show`` and ``read`` of rules."""

import json
from pathlib import Path
from typing import Any

import pytest
import trimesh
from PIL import Image

from grammarlab.facade.file import load_facade, save_facade
from tests.facade.grammar.houses import house
from tests.facade.test_scene import pictured


@pytest.fixture
def facade(tmp_path: Path) -> Path:
    return save_facade(pictured(house(columns=3, rows=2)), tmp_path / "house.facade.json")


def test_an_exact_grammar_is_sampled_with_its_picture(run, facade: Path, tmp_path: Path) -> None:
    rules = tmp_path / "house.cga"
    result = json.loads(run("facade", "grammar", facade, "-o", rules, "--json").stdout)
    assert result["rules"] == 8
    assert result["exact"] <= 1e-9
    assert result["choices"] == {}
    assert (tmp_path / "assets" / "a.png").is_file()
    run("sample", rules, "-n", 1, "--jobs", 1, "--no-image", "-o", tmp_path / "out")
    model: Any = trimesh.load(tmp_path / "out" / "house-00000.glb", force="mesh")
    assert model.visual.material.baseColorTexture is not None
    # A second run into the same folder changes nothing.
    assert json.loads(run("facade", "grammar", facade, "-o", rules, "--json").stdout) == result


def test_a_family_is_told_in_words_and_numbers(run, facade: Path, tmp_path: Path) -> None:
    rules = tmp_path / "family.cga"
    options = ("facade", "grammar", facade, "--widths", "6:12", "-o", rules)
    result = json.loads(run(*options, "--json").stdout)
    assert result["exact"] <= 1e-9
    assert result["choices"]["columns"] == [3, 5]
    assert result["choices"]["rows"] == {"windowRows": [1, 2]}
    assert result["choices"]["facades"] == 12
    told = run(*options)
    assert told.stdout.strip() == str(rules)
    assert "3 to 5 columns" in told.stderr
    assert (tmp_path / "assets" / "a.png").is_file()
    run("sample", rules, "-n", 1, "--jobs", 1, "--no-image", "-o", tmp_path / "out")
    model: Any = trimesh.load(tmp_path / "out" / "family-00000.glb", force="mesh")
    assert model.visual.material.baseColorTexture is not None


@pytest.mark.parametrize("value", ["10", "10:4", "a:b", "nan:10", "-1:5", "0:0", "1:inf", "1:2:3"])
def test_a_range_that_is_none_is_refused(run, facade: Path, value: str) -> None:
    assert "such as 10:40" in run("facade", "grammar", facade, f"--widths={value}", code=2).output


def test_a_family_that_is_empty_is_explained(run, facade: Path) -> None:
    assert "its columns make widths from" in run("facade", "grammar", facade, "--widths", "0.1:1", code=1).output


@pytest.mark.parametrize("ending", ["svg", "png", "glb", "obj", "ply"])
def test_every_kind_of_file_is_written(run, facade: Path, tmp_path: Path, ending: str) -> None:
    target = tmp_path / "new" / f"x.{ending}"
    assert run("facade", "show", facade, "-o", target, "--pixels", 10).stdout.strip() == str(target)
    assert target.stat().st_size > 200


def test_unknown_endings_are_refused(run, facade: Path, tmp_path: Path) -> None:
    assert ".svg, .png, .glb" in run("facade", "show", facade, "-o", tmp_path / "x.pdf", code=2).output
    assert "This is not a facade" in run("facade", "show", _other(tmp_path), "-o", tmp_path / "x.svg", code=1).output


def _other(folder: Path) -> Path:
    path = folder / "other.json"
    path.write_text("{}")
    return path


def test_a_side_of_a_building_is_read_with_its_picture(run, rules, tmp_path: Path) -> None:
    path = rules(
        "@StartRule\nLot --> s(6, 4, 1) primitiveCube() comp(f) { front : F }\n"
        "F --> split(x) { ~1 : Wall. | 2 : Window. | ~1 : Wall. }"
    )
    target = tmp_path / "front.json"
    result = json.loads(run("facade", "read", path, "--parts", "Window", "-o", target, "--json").stdout)
    assert result["leaves"] == 3
    assert load_facade(target).pictures[0].name == "front.png"
    # Made again from other rules, into the same place.
    path.write_text(path.read_text().replace("2 :", "3 :"))
    run("facade", "read", path, "--parts", "Window", "-o", target)
    assert load_facade(target).size[load_facade(target).leaves[1], 0] == pytest.approx(3.0, abs=1e-4)
    # A photograph of that name is not replaced.
    (tmp_path / "front.png").write_bytes(b"photograph")
    refused = run("facade", "read", path, "--parts", "Window", "-o", target, code=1)
    assert "front.png exists and differs" in refused.stderr
    assert (tmp_path / "front.png").read_bytes() == b"photograph"
    assert "--face and --parts" in run("facade", "read", path, "--width", 3, code=2).output
    assert "unknown side" in run("facade", "read", path, "--face", "top", code=2).output


def test_the_picture_of_a_large_side_has_fewer_pixels_per_metre(
    run, rules, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """At the usual 50 pixels per metre this picture would be larger than any renderer makes."""
    monkeypatch.setattr("grammarlab.runs.facade.read.MAX_PIXELS", 4_800)
    path = rules(
        "@StartRule\nLot --> s(480, 40, 1) primitiveCube() comp(f) { front : F }\n"
        "F --> split(x) { ~1 : Wall. | 100 : Window. | ~1 : Wall. }"
    )
    target = tmp_path / "front.json"
    assert json.loads(run("facade", "read", path, "-o", target, "--json").stdout)["leaves"] == 3
    with Image.open(tmp_path / "front.png") as picture:
        assert picture.size == (240, 20)


def test_rules_do_not_replace_the_facade(run, facade: Path) -> None:
    before = facade.read_bytes()
    assert "is the input file" in run("facade", "grammar", facade, "-o", facade, code=2).stderr
    assert facade.read_bytes() == before
