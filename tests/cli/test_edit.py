"""``grammarlab facade edit``."""

import json
from pathlib import Path

import pytest
from PIL import Image

from grammarlab.facade.file import load_facade, load_locked, save_facade
from grammarlab.facade.sizes.size_wishes import Aspect, Size
from grammarlab.facade.tree import X, Y, check, decomposition_misses
from tests.facade.grammar.houses import house
from tests.facade.sized import storeys
from tests.facade.test_scene import pictured

KEYS = {
    *("file", "width", "height", "leaves", "energy", "residuals", "grids"),
    *("steps", "proven", "conflict", "relaxed", "faults", "missing", "seconds"),
}


@pytest.fixture
def facade(tmp_path: Path) -> Path:
    return save_facade(storeys(4, 3, widths=(0.8, 1.2)), tmp_path / "f.json")


def results(run, *arguments) -> list[dict]:
    return json.loads(run("facade", "edit", *arguments, "--json").stdout)["results"]


@pytest.mark.parametrize("options", [{"width": 7.0}, {"width": 23.0}, {"height": 14.5}, {"width": 20.0, "height": 5.0}])
def test_facades_are_as_large_as_asked(run, facade: Path, tmp_path: Path, options: dict[str, float]) -> None:
    arguments = [text for key, value in options.items() for text in (f"--{key}", value)]
    found = results(run, facade, *arguments, "-o", tmp_path / "out")
    assert found
    for each in found:
        assert set(each) == KEYS
        made = load_facade(Path(each["file"]))
        for key, value in options.items():
            assert getattr(made, key) == each[key] == pytest.approx(value, abs=1e-6)
        assert each["leaves"] == len(made.leaves)
        assert set(each["residuals"]) == {"decomposition", "alignment", "symmetry", "target"}
        assert max(each["residuals"].values()) <= 1e-6
        assert decomposition_misses(made)[0].max() <= 1e-9
        for ending in ("svg", "png"):
            assert Path(each["file"].replace("facade.json", ending)).is_file()
    assert found == sorted(found, key=lambda each: each["energy"])
    assert found[0]["proven"]
    with Image.open(tmp_path / "out" / "contact.png") as contact, Image.open(tmp_path / "out" / "001.png") as first:
        assert contact.width > first.width


@pytest.mark.parametrize(("columns", "rows"), [(1, 0), (-1, 0), (0, 1), (0, -1), (-2, 1)])
def test_columns_and_rows_come_and_go(run, facade: Path, tmp_path: Path, columns: int, rows: int) -> None:
    found = results(run, facade, f"--columns={columns:+}", f"--rows={rows:+}", "-n", 3, "-o", tmp_path / "out")
    assert 1 <= len(found) <= 3
    before = load_facade(facade)
    for each in found:
        made = check(load_facade(Path(each["file"])))
        assert each["grids"] == [{"name": "windows", "rows": 3 + rows, "columns": 4 + columns}]
        # One for each column and row, or one for all columns of the whole facade.
        assert bool(columns) + bool(rows) <= len(each["steps"]) <= abs(columns) + abs(rows)
        assert not each["conflict"]
        if rows == 0:
            assert (made.width > before.width) == (columns > 0)
            assert made.height == pytest.approx(before.height)
    assert found == sorted(found, key=lambda each: (bool(each["conflict"] or each["missing"]), each["energy"]))


def test_a_width_is_kept_whatever_columns_come(run, facade: Path, tmp_path: Path) -> None:
    options = ("--columns", "+1", "--width", "15", "-n", 2, "-o", tmp_path / "out")
    for each in results(run, facade, *options, "--grid", "windows"):
        assert each["width"] == pytest.approx(15.0, abs=1e-6)
        assert each["grids"][0]["columns"] == 5


@pytest.mark.parametrize("arguments", [("--width", 23.0), ("--columns", 1), ("--columns", 1, "--width", 9.5)])
def test_what_is_locked_stays_and_so_do_its_copies(run, tmp_path: Path, arguments: tuple) -> None:
    facade = storeys(2, 3, widths=(0.8, 1.2))
    wide = [node for node in facade.grids[0].node.tolist() if facade.size[node, X] > 1.0]
    locks = [Size(wide[0], X, 1.2), Aspect(wide[0], 0.5, 5.0), Size(0, X, facade.width)]
    locked = save_facade(facade, tmp_path / "locked.json", locks if "--width" in arguments else locks[:2])
    found = results(run, locked, *arguments, "-n", 3, "-o", tmp_path / "out")
    assert found
    for each in found:
        made, locks = load_locked(Path(each["file"]))
        nodes = {lock.node for lock in locks}
        assert not each["conflict"]
        # A row may have lost what was locked.
        assert nodes or len(made.grids[0].node) < len(facade.grids[0].node)
        assert made.size[sorted(nodes), X] == pytest.approx(1.2, abs=1e-6)


def test_a_wish_for_the_whole_goes_before_its_lock_and_places_hold_alone(run, tmp_path: Path) -> None:
    facade = storeys(1, 2)
    locks = [Size(0, X, facade.width), Size(0, Y, facade.height)]
    file = save_facade(facade, tmp_path / "locked.json", locks)
    (first, *_) = results(run, file, "--width", 23.0, "-o", tmp_path / "out")
    assert (first["width"], first["height"]) == (pytest.approx(23.0), pytest.approx(facade.height))
    assert load_locked(Path(first["file"]))[1] == (locks[1],)


def test_what_is_in_conflict_is_named(run, facade: Path, tmp_path: Path) -> None:
    for each in results(run, facade, "--width", "0.001", "-o", tmp_path / "out"):
        assert "the facade is 0.001 m wide" in each["conflict"]
        assert each["relaxed"]
    assert "in conflict" in run("facade", "edit", facade, "--width", "0.001", "-o", tmp_path / "out").stderr


def test_a_facade_without_grids_gets_some(run, tmp_path: Path) -> None:
    path = save_facade(pictured(house(columns=3, rows=2)), tmp_path / "house.json")
    assert not load_facade(path).grids
    found = results(run, path, "--columns", "+1", "-o", tmp_path / "out")
    assert found[0]["grids"]
    assert all("repeated" in step or "2 times" in step for each in found for step in each["steps"])
    # Its picture comes along, also when results are edited in turn, into the same folder as often as one likes.
    again = ("facade", "edit", tmp_path / "out" / "001.facade.json", "--width", "9", "-n", "1", "-o", tmp_path / "next")
    assert run(*again).stdout == run(*again).stdout == f"{tmp_path / 'next' / '001.facade.json'}\n"
    assert load_facade(tmp_path / "next" / "001.facade.json").pictures == load_facade(path).pictures


@pytest.mark.parametrize(
    ("arguments", "code", "says"),
    [
        ([], 2, "nothing to do"),
        (["--width", "0"], 2, "above 0"),
        (["--width", "-3"], 2, "above 0"),
        (["--height", "1e9"], 2, "to 1,000,000"),
        (["--width", "nan"], 2, "above 0"),
        (["--width", "wide"], 2, "valid number"),
        (["--columns", "21"], 2, "at most 20"),
        (["--columns", "-4"], 1, "no column can be removed: it has one column"),
        (["--columns", "1", "--grid", "doors"], 1, "expected one of: windows"),
        (["--width", "9", "--grid", "doors"], 1, "expected one of: windows"),
        (["--width", "9", "-n", "0"], 2, "-n"),
    ],
)
def test_bad_wishes_are_explained(run, facade: Path, tmp_path: Path, arguments, code: int, says: str) -> None:
    assert says in run("facade", "edit", facade, *arguments, "-o", tmp_path / "out", code=code).stderr
    assert not (tmp_path / "out").exists()


def test_nothing_is_written_over(run, facade: Path, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("mine")
    run("facade", "edit", facade, "--width", 9, "-o", tmp_path / "file", code=2)
    run("facade", "edit", facade, "--width", 9, "-o", tmp_path / "file" / "below", code=1)
    assert (tmp_path / "file").read_text() == "mine"
    assert "This is not a facade" in run("facade", "edit", other(tmp_path), "--width", 9, "-o", tmp_path, code=1).stderr
    run("facade", "edit", facade, "--width", 9, "-o", tmp_path / "out")
    first = tmp_path / "out" / "001.facade.json"
    content = first.read_bytes()
    assert "overwritten" in run("facade", "edit", first, "--width", 5, "-o", tmp_path / "out", code=2).stderr
    assert first.read_bytes() == content


def other(folder: Path) -> Path:
    path = folder / "other.json"
    path.write_text("{}")
    return path


def test_a_folder_shows_one_run(run, facade: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    run("facade", "edit", facade, "--width", 23, "-o", out)
    many = {path.name for path in out.iterdir()}
    assert "002.facade.json" in many
    (out / "mine.png").write_bytes(b"mine")
    # What is edited is never removed, by whatever number it goes.
    run("facade", "edit", out / "002.facade.json", "--width", 23, "-n", 1, "-o", out, code=2)
    assert {path.name for path in out.iterdir()} == many | {"mine.png"}
    run("facade", "edit", facade, "--width", 23, "-n", 1, "-o", out)
    names = {path.name for path in out.iterdir()}
    assert {"001.facade.json", "001.png", "001.svg", "contact.png", "mine.png"} <= names
    assert not [name for name in names if name.startswith("002")]
