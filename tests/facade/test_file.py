"""Files of facades: exact round trips, and messages on invalid files."""

import io
import json
import re
from collections.abc import Callable
from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image

from grammarlab.errors import FacadeError
from grammarlab.facade import file, values
from grammarlab.facade.file import dumps, load_facade, load_locked, loads_locked, save_facade
from grammarlab.facade.grid import Grid
from grammarlab.facade.sizes.size_wishes import Aspect, Position, Size, Wish
from grammarlab.facade.tree import LEAF, Facade, Picture, X, Y, laid_out, plain
from tests.facade.strategies import trees


def facade_of(content: bytes, picture_named: Callable[[str], Picture]) -> Facade:
    """The facade of a file without its locks."""
    return loads_locked(content, picture_named)[0]


def png(color: str = "red", size: tuple[int, int] = (4, 3)) -> bytes:
    file = io.BytesIO()
    Image.new("RGB", size, color).save(file, "PNG")
    return file.getvalue()


DOCUMENTATION = Path(__file__).parents[2] / "docs" / "facades" / "file.md"
FRONT = Picture("front.png", png())


def dressed(facade: Facade, seed: int = 0) -> Facade:
    """A facade with every optional property."""
    randomness = np.random.default_rng(seed)
    counts = np.where(facade.axis == LEAF, randomness.choice([0, 3, 5], len(facade)), 0)
    leaves = facade.leaves
    return replace(
        facade,
        outline_offsets=np.concatenate([[0], np.cumsum(counts)]),
        outline_points=randomness.random((counts.sum(), 2)),
        pictures=(FRONT,),
        picture=np.where(facade.axis == LEAF, 0, -1),
        window=randomness.random((len(facade), 4)),
        grids=(
            Grid("all", leaves, np.zeros(len(leaves), dtype=np.int64), np.arange(len(leaves))),
            Grid("Fenster", np.zeros(0, np.int64), np.zeros(0, np.int64), np.zeros(0, np.int64)),
        ),
    )


def same(first: Facade, second: Facade) -> None:
    for field in fields(Facade):
        one, other = getattr(first, field.name), getattr(second, field.name)
        if field.name == "grids":
            assert [g.name for g in one] == [g.name for g in other]
            for a, b in zip(one, other, strict=True):
                for column in ("node", "row", "column"):
                    assert np.array_equal(getattr(a, column), getattr(b, column))
        elif isinstance(one, np.ndarray):
            assert (one.dtype, one.shape) == (other.dtype, other.shape), field.name
            assert one.tobytes() == other.tobytes(), field.name
        else:
            assert one == other


@given(trees(), st.integers(0, 100))
def test_what_is_written_is_read_to_the_last_bit(facade: Facade, seed: int) -> None:
    for one in (facade, dressed(facade, seed)):
        same(one, facade_of(dumps(one).encode(), lambda _: FRONT))


LENGTHS = st.floats(1e-3, 10.0)
LOCK = st.one_of(
    st.builds(Size, st.integers(0, 2), st.sampled_from([X, Y]), LENGTHS),
    st.builds(Position, st.integers(0, 2), st.sampled_from([X, Y]), LENGTHS),
    st.builds(lambda node, one, more: Aspect(node, one, one + more), st.integers(0, 2), LENGTHS, LENGTHS),
)


@given(st.lists(LOCK, unique_by=lambda lock: (type(lock), lock.node, getattr(lock, "axis", None))))
def test_locks_are_read_as_they_were_written_and_are_not_of_the_facade(locks: list[Wish]) -> None:
    content = dumps(two(), locks).encode()
    facade, found = loads_locked(content, lambda _: FRONT)
    assert set(found) == set(locks)
    same(facade, facade_of(content, lambda _: FRONT))
    assert locks or dumps(two()).encode() == content


def test_locks_lie_in_the_file(tmp_path):
    file = save_facade(two(), tmp_path / "f.json", [Size(1, X, 0.1), Aspect(2, 0.1, 0.1)])
    assert json.loads(file.read_text())["locks"] == [{"node": 1, "width": 0.1}, {"node": 2, "aspect": [0.1, 0.1]}]
    assert load_locked(file)[1] == (Size(1, X, 0.1), Aspect(2, 0.1, 0.1))


def test_the_example_of_the_documentation_is_a_file_as_it_would_be_written():
    (example,) = re.findall(r"```json\n(.*?)```", DOCUMENTATION.read_text(encoding="utf-8"), re.DOTALL)
    assert dumps(facade_of(example.encode(), lambda name: replace(FRONT, name=name))) == example


def test_a_facade_and_its_picture_go_into_a_folder_and_come_back(tmp_path):
    facade = dressed(two())
    assert save_facade(facade, tmp_path / "f.json") == tmp_path / "f.json"
    assert sorted(path.name for path in tmp_path.iterdir()) == ["f.json", "front.png"]
    same(facade, load_facade(tmp_path / "f.json"))
    save_facade(facade, tmp_path / "again.json")


def test_a_picture_of_somebody_else_is_not_written_over(tmp_path):
    (tmp_path / "front.png").write_bytes(png("blue"))
    with pytest.raises(FacadeError, match="exists and differs"):
        save_facade(dressed(two()), tmp_path / "f.json")
    assert [path.name for path in tmp_path.iterdir()] == ["front.png"]
    assert (tmp_path / "front.png").read_bytes() == png("blue")


def test_thousands_of_nodes_within_each_other_are_written_and_read():
    depth = 3_000  # too deep for a recursive program
    parent = np.array([-1, *(above for level in range(depth) for above in (2 * level, 2 * level))])
    axis = np.where(np.arange(2 * depth + 1) % 2, LEAF, np.arange(2 * depth + 1) // 2 % 2).astype(np.int8)
    axis[-1] = LEAF
    position, size = laid_out(parent, axis, np.ones((len(parent), 2)))
    facade = plain(parent, axis, position, size, [""] * len(parent))
    same(facade, facade_of(dumps(facade).encode(), lambda _: FRONT))


def two() -> Facade:
    return plain(
        np.array([-1, 0, 0]),
        np.array([X, LEAF, LEAF], dtype=np.int8),
        np.array([[0, 0], [0, 0], [0.1, 0]]),
        np.array([[0.30000000000000004, 2], [0.1, 2], [0.2, 2]]),
        ["", "wall", "window"],
    )


def changed(*path_and_value):
    """The file of a small facade with one value replaced."""
    document = json.loads(dumps(replace(two(), grids=(Grid("g", np.array([1]), np.array([0]), np.array([0])),))))
    *path, last, value = path_and_value
    place = document
    for step in path:
        place = place[step]
    if value is None:
        del place[last]
    else:
        place[last] = value
    return json.dumps(document).encode()


@pytest.mark.parametrize(
    ("content", "says"),
    [
        (b"", "not valid JSON"),
        (b"\xff\xfe\x00", "not valid JSON"),
        (b"[" * 100_000, "too deep"),
        (b'{"format": NaN}', "finite numbers, found NaN"),
        (b"[]", "not a facade"),
        (b"{}", 'expected an object with "format"'),
        (changed("version", 2), "Expected version 1 of the format, found 2"),
        (changed("labels", ["wall", "wall"]), "labels: expected unique names"),
        (changed("labels", "wall"), "labels: expected a list, found 'wall'"),
        (changed("nodes", None), "nodes: expected a list, found nothing"),
        (changed("locks", 5), "locks: expected a list, found 5"),
        (changed("locks", [5]), "Lock 0: expected an object, found 5"),
        (changed("locks", [{"node": 3, "width": 1}]), "Lock 0, node: expected a whole number from 0 to 2, found 3"),
        (changed("locks", [{"node": 1, "width": "a"}]), "Lock 0, width: expected a finite number, found 'a'"),
        (changed("locks", [{"node": 1, "height": 0}]), "node 1) is 0 m high: expected a length above 0"),
        (changed("locks", [{"node": 1, "left": -1}]), "expected a length of at least 0"),
        (changed("locks", [{"node": 1, "width": 1e9}]), "at most 2000 m"),
        (changed("locks", [{"node": 1, "aspect": [2, 1]}]), "the smaller number first"),
        (changed("locks", [{"node": 1, "aspect": [2]}]), "expected 2 numbers"),
        (changed("locks", [{"node": 1}, {"node": 1}]), "Lock 1: node 1 has several entries"),
        (changed("nodes", []), "expected at most 0 entries"),
        (changed("nodes", 1, "x", "left"), "Node 1, x: expected a finite number, found 'left'"),
        (changed("nodes", 1, "x", 10**400), "Node 1, x: expected a finite number"),
        (changed("nodes", 1, "x", True), "Node 1, x: expected a finite number, found True"),
        (changed("nodes", 1, "width", None), "Node 1, width: expected a finite number, found nothing"),
        (changed("nodes", 1, "width", -0.1), "Node 1: expected a width and height above 0"),
        (changed("nodes", 1, "width", 0.15), "miss its width"),
        (changed("nodes", 0, "width", 1e-320), "Node 0: expected a width and height above 0, from 1e-09"),
        (changed("nodes", 0, "width", 1e308), "from 1e-09 to 1,000,000 m"),
        (changed("nodes", 0, "width", 10**400), "Node 0, width: expected a finite number"),
        (b'{"format": ' + b"9" * 5_000 + b"}", "not valid JSON"),
        (b'{"version": ' + b'{"a":' * 700 + b"1" + b"}" * 701, "not a facade"),
        (changed("labels", ["\ud800", "wall"]), "labels: expected Unicode text, found half of a character"),
        (changed("nodes", 1, "parent", 1.0), "Node 1, parent: expected a whole number from -1 to 2"),
        (changed("nodes", 1, "parent", 2), "earlier nodes"),
        (changed("nodes", 1, "label", "roof"), "'roof' is not in the list \"labels\""),
        (changed("nodes", 1, "label", 0), "expected a text"),
        (changed("nodes", 0, "axis", "z"), 'Node 0, axis: expected "x", "y" or nothing'),
        (changed("nodes", 0, "axis", []), 'Node 0, axis: expected "x", "y" or nothing'),
        (changed("nodes", 1, "outline", [[0, 0], [1, 1]]), "at least 3 corners"),
        (changed("nodes", 1, "outline", [[0, 0], [1, 1], [2, 0]]), "corners from 0 to 1"),
        (changed("nodes", 1, "window", [0, 0, 1]), "expected 4 numbers, found a list of 3"),
        (changed("nodes", 1, "window", [0, 0, 1, 7]), "numbers from 0 to 1"),
        (changed("nodes", 1, "picture", "a.png"), "is not in the list"),
        (changed("nodes", 1, "picture"), "expected an object"),
        (changed("pictures", ["../a.png"]), "expected the plain name"),
        (changed("pictures", ["a.exe"]), "expected the plain name"),
        (changed("pictures", [".png"]), "expected the plain name"),
        (changed("pictures", ["missing.png"]), "not in the folder"),
        (changed("grids", 0, "elements", 0, "node", 3), "Grid 0, node: expected a whole number from 0 to 2"),
        (changed("grids", 0, "elements", 0, "row", -1), "Grid 0, row"),
        (changed("grids", 0, "elements", [{"node": 1, "row": 10**5, "column": 10**5}]), "at most 10,000,000 places"),
        (changed("grids", 0, "elements", [{"node": 1, "row": 0, "column": 0}] * 2), "ascending nodes"),
        (changed("grids", 0, "elements", [{"node": n, "row": 0, "column": 0} for n in (1, 2)]), "one element per row"),
        (changed("grids", [{"name": "g", "elements": []}] * 2), "grids: expected unique names"),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_what_is_no_facade_is_explained(content, says, tmp_path):
    (tmp_path / "f.json").write_bytes(content)
    with pytest.raises(FacadeError) as told:
        load_facade(tmp_path / "f.json")
    assert says in str(told.value)
    assert str(told.value).startswith("f.json: ")


def test_files_and_pictures_that_are_too_large_are_refused(tmp_path, monkeypatch):
    save_facade(dressed(two()), tmp_path / "f.json")
    monkeypatch.setattr(file, "MOST_PIXELS", 11)
    with pytest.raises(FacadeError, match="4 x 3 pixels; expected at most 11"):
        load_facade(tmp_path / "f.json")
    with pytest.raises(FacadeError, match="at most 10 bytes"):
        values.read_bounded(tmp_path / "f.json", 10)


def test_a_picture_that_is_none_or_links_elsewhere_is_refused(tmp_path):
    folder = tmp_path / "folder"
    folder.mkdir()
    save_facade(dressed(two()), folder / "f.json")
    (folder / "front.png").write_bytes(b"GIF89a")
    with pytest.raises(FacadeError, match="not a PNG or JPEG"):
        load_facade(folder / "f.json")
    (folder / "front.png").unlink()
    (tmp_path / "front.png").write_bytes(png())
    (folder / "front.png").symlink_to(tmp_path / "front.png")
    with pytest.raises(FacadeError, match="not in the folder"):
        load_facade(folder / "f.json")


def test_what_could_not_be_read_is_not_written(tmp_path):
    for wrong in (replace(two(), labels=("wall", "wall")), replace(two(), pictures=(Picture("../x.png", png()),))):
        with pytest.raises(FacadeError):
            save_facade(wrong, tmp_path / "f.json")
    assert list(tmp_path.iterdir()) == []


VALID = dumps(dressed(two())).encode()


@given(st.integers(0, len(VALID)), st.integers(0, 40), st.binary(max_size=20))
def test_a_damaged_file_is_a_facade_or_refused_in_words(start, length, other):
    try:
        facade = facade_of(VALID[:start] + other + VALID[start + length :], lambda name: replace(FRONT, name=name))
    except FacadeError:
        return
    again = facade_of(dumps(facade).encode(), lambda name: replace(FRONT, name=name))
    assert again.size.tolist() == facade.size.tolist()


SCRAPS = st.recursive(
    st.none()
    | st.booleans()
    | st.integers()
    | st.floats()
    | st.text(st.characters(), max_size=3)
    | st.sampled_from([1e308, -1e308, 1e-320, 10**400, "\ud800", "\x1b[31m", "\0"]),
    lambda some: st.lists(some, max_size=3) | st.dictionaries(st.sampled_from(["node", "row", "name", "x"]), some),
    max_leaves=6,
)
PLACES: list[tuple[str | int, ...]] = [
    ("nodes",),
    ("grids",),
    ("labels",),
    ("pictures",),
    ("version",),
    ("nodes", 1),
    ("grids", 0),
]
PLACES += [("nodes", 1, key) for key in ("parent", "axis", "x", "width", "label", "outline", "picture", "window")]
PLACES += [("grids", 0, key) for key in ("name", "elements")] + [("grids", 0, "elements", 0)]


@given(st.sampled_from(PLACES), SCRAPS)
def test_any_value_in_any_place_is_read_or_refused_in_words(place, value):
    try:
        facade_of(changed(*place, 0 if value is None else value), lambda name: replace(FRONT, name=name))
    except FacadeError:
        return
