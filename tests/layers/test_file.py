"""Designs as TOML."""

from pathlib import Path

import pytest

from grammarlab.errors import FacadeError, LanguageError
from grammarlab.layers.file import MOST_LAYERS, load_design, parse_design
from tests.layers.samples import DESIGNS, RESIDENTIAL, residential

LAYER = '[[layers]]\nx = "A"\ny = "P"\n'
SMALL = f"canvas = {{ width = 6.0, height = 3.0 }}\nsymbols = {{ A = 1.0, P = 3.0 }}\n{LAYER}"


def mistake(text: str) -> tuple[int, int, str]:
    with pytest.raises(LanguageError) as caught:
        parse_design(text)
    (finding,) = caught.value.findings
    return finding.location.line, finding.location.column, finding.message


def test_the_shipped_house_is_read() -> None:
    house = load_design(DESIGNS / "residential.toml")
    assert [layer.name for layer in house.layers] == ["roof", "door", "columns", "house"]
    assert house.layers[0].groups == ("roof", "")
    assert house.layers[1].masks == (None, frozenset("P"))
    assert house.symbols["B"].size == 1.6
    assert house.symbols["e"].size is None
    assert not house.symbols["C"].opaque
    assert house.shape(house.layers[3], "B", "Q").label == "window"
    assert house.shape(house.layers[0], "H", "P").label == "H P"


def test_a_small_design_needs_little() -> None:
    small = parse_design(SMALL)
    assert small.layers[0].patterns == ("A", "P")
    assert small.symbols["A"].opaque


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('"A(BA)^k"', '"A(BX)^k"', "unknown symbol 'X'"),
        ('"A(BA)^k"', '"A(B(A)^2)^k"', "cannot be nested"),
        ("size = 1.6", "size = -1.6", "above 0"),
        ("size = 1.6", "size = 0", "above 0"),
        ("size = 1.6", "size = inf", "number"),
        ("size = 1.6", 'size = "wide"', "number"),
        ("size = 1.6", "sise = 1.6", "found 'sise'"),
        ("width = 6.0", "width = 0", "above 0"),
        ("width = 6.0", "width = 1e9", "at least 1e-06 and at most 10,000"),
        ("width = 6.0", "width = 1e-320", "above 0"),
        ("size = 1.6", "size = 1e-320", "above 0"),
        ("size = 1.6", "size = 1" + "0" * 5_000, "number"),
        ("width = 6.0", "width = nan", "number"),
        ("size = 1.6", "size = 1" + "0" * 400, "number"),
        ('x = "Cx"', 'x = "Cz"', "unknown symbol 'z'"),
        ('mask = { y = ["R"] }', 'mask = { y = ["Z"] }', "P, Q, R; found 'Z'"),
        ('H.R = { label = "roof" }', 'Z.R = "roof"', "unknown symbol 'Z'"),
        ('H.R = { label = "roof" }', "H.R = 3", "table"),
        ('label = "roof"', 'label = "roof", inset = [0.1, 0.1]', "left, bottom, right, top"),
        ('label = "roof"', 'label = "roof", inset = [0.1, 0.1, -0.1, 0]', "metres of at least 0"),
        ('label = "roof"', 'label = "roof", frame = 3', "label"),
        ("title =", "title = =", "not TOML"),
        ("[patterns]", "[pattern]", "found 'pattern'"),
        ("[patterns]", "[counters]\nk = { least = 5, most = 2 }\n[patterns]", "at least 5"),
        ("[patterns]", '[counters]\nk = { reflection = "up" }\n[patterns]', "pivot-total"),
        ("[patterns]", "[solver]\nomega = -1\n[patterns]", "at least 0"),
        ("[patterns]", "[solver]\nsizing = 1e-320\n[patterns]", "at least 0"),
    ],
)
def test_mistakes_are_said_with_their_place(old: str, new: str, message: str) -> None:
    assert old in RESIDENTIAL
    text = RESIDENTIAL.replace(old, new, 1)
    line, column, found = mistake(text)
    assert message in found
    lines = text.split("\n")
    at = sum(len(each) + 1 for each in lines[: line - 1]) + column - 1
    start = text.index(new)
    assert start <= at < start + len(new)


def test_carets_stand_below_the_mistake_within_a_pattern() -> None:
    with pytest.raises(LanguageError) as caught:
        residential({'"A(BA)^k"': '"A(BX)^k"'})
    shown = str(caught.value).splitlines()
    assert shown[1][shown[2].index("^")] == "X"


@pytest.mark.parametrize(
    "text",
    [
        "",
        "layers = []",
        "layers = 3",
        "canvas = 3",
        SMALL.replace('x = "A"\n', ""),
        SMALL.replace('"A"', '["A"]'),
        SMALL.replace("A = 1.0", "A = true"),
        SMALL.replace("A = 1.0", '"{A" = 1.0'),
        SMALL + "on = false",
        SMALL + 'on = "no"',
        SMALL + "depth = inf",
        SMALL + "mask = { x = 3 }",
        SMALL + "group = { z = 3 }",
        SMALL + "group = { x = 3 }",
        SMALL + "shapes = { A = 3 }",
        SMALL + 'shapes = { A = { P = { label = "\\u0007" } } }',
        SMALL + LAYER * MOST_LAYERS,
        SMALL + LAYER * 5_000,
        "x = " + "[" * 100_000,
        SMALL.replace("6.0", "6.0.0"),
    ],
)
def test_other_mistakes_are_found(text: str) -> None:
    mistake(text)


def test_files_are_bounded_and_of_text(tmp_path) -> None:
    large, odd = tmp_path / "large.toml", tmp_path / "odd.toml"
    large.write_text("#" * (2**20 + 1))
    odd.write_bytes(b"\xff\xfe\x00")
    with pytest.raises(FacadeError, match="at most"):
        load_design(large)
    with pytest.raises(LanguageError, match="UTF-8"):
        load_design(odd)


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig"])
def test_a_byte_order_mark_changes_no_design_and_no_place(tmp_path, encoding) -> None:
    path = tmp_path / "design.toml"
    path.write_text(SMALL, encoding=encoding)
    assert load_design(path) == parse_design(SMALL)
    path.write_text(SMALL.replace("6.0", "6.0.0"), encoding=encoding)
    with pytest.raises(LanguageError) as caught:
        load_design(path)
    (finding,) = caught.value.findings
    assert (finding.location.line, finding.location.column) == (1, 23)


def test_the_documented_design_is_one() -> None:
    text = (Path(__file__).parents[2] / "docs" / "layers" / "file.md").read_text(encoding="utf-8")
    made = parse_design(text.split("```toml\n")[1].split("```")[0])
    assert [layer.name for layer in made.layers] == ["columns", "house"]
    assert made.patterns["corners"].placeholders() == {"e"}


@pytest.mark.parametrize("path", sorted(DESIGNS.glob("*.toml")), ids=lambda path: path.stem)
def test_shipped_designs_say_what_they_are(path: Path) -> None:
    made = load_design(path)
    assert made.title
    used = {name for layer in made.layers for key in layer.patterns for name in made.patterns[key].symbols()}
    assert used == set(made.symbols)
    assert {key for layer in made.layers for key in layer.patterns} == set(made.patterns)
