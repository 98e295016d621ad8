"""The design session of the paper: supplement, Figure 2, and the apartment house in its complexity (Figure 9)."""

import pytest

from grammarlab.layers.design import Design
from grammarlab.layers.file import load_design, parse_design
from grammarlab.runs.facade.layer_files import SolvedLayout, solve_design
from tests.layers.samples import DESIGNS, residential

CANVAS = "canvas = { width = 6.0, height = 3.0 }"
SYMBOLS = {"A": "{ size = 1.0 }", "B": "{ size = 1.6 }", "P": "{ size = 2.0 }", "Q": "{ size = 1.0 }"}
SHAPES = {'A."*"': '"wall"', "B.P": '"shop window"', "B.Q": '"window"'}
HOUSE = '[[layers]]\nname = "house"\nx = "Bx"\ny = "By"\n'
COLUMNS = '[[layers]]\nname = "columns"\nx = "Cx"\ny = "By"\nmask = { y = ["P"] }\n'
DOOR = '[[layers]]\nname = "door"\nx = "Dx"\ny = "By"\nmask = { y = ["P"] }\n'
ROOF = '[[layers]]\nname = "roof"\nx = "Rx"\ny = "Ry"\ngroup = { x = "roof" }\nmask = { y = ["R"] }\n'


def stage(last: int) -> Design:
    """The design after a step of the session; steps 3, 7, 11 and 16 make a layer."""
    patterns = {"Bx": "A(BA)^k", "By": "PQ"}
    symbols, shapes, layers, canvas = dict(SYMBOLS), dict(SHAPES), HOUSE, CANVAS
    if last >= 7:
        patterns["Cx"] = "cec; c := C"
        symbols |= {"C": "{ size = 1.1, opaque = false }", "e": "{}"}
        shapes["C.P"], layers = '"column"', COLUMNS + layers
    if last >= 11:
        patterns["Dx"] = "fdf; d := D"
        symbols |= {"D": "{ size = 1.0 }", "f": "{}"}
        shapes["D.P"], layers = '"door"', DOOR + layers
    if last >= 14:
        canvas = canvas.replace("3.0", "4.5")
    if last >= 16:
        patterns |= {"Rx": "H", "Ry": "PQR"}
        symbols |= {"R": "{ size = 1.5 }", "H": "{}"}
        shapes["H.R"], layers = '"roof"', ROOF + layers
    quoted = {key: f'"{text}"' for key, text in patterns.items()}
    tables = "".join(
        f"[{name}]\n" + "".join(f"{key} = {value}\n" for key, value in table.items())
        for name, table in (("symbols", symbols), ("shapes", shapes), ("patterns", quoted))
    )
    return parse_design(f"{canvas}\n{tables}{layers}")


def labels(solved: SolvedLayout) -> dict[str, int]:
    found = [solved.facade.name_of(leaf) for leaf in solved.facade.leaves.tolist()]
    return {label: found.count(label) for label in sorted(set(found))}


@pytest.mark.parametrize(
    ("last", "sizes", "error", "shown"),
    [
        (
            4, {"A": 1.0 - 0.6 / 13, "B": 1.6 - 0.4 / 13}, 0.04 / 13, {"shop window": 2, "wall": 6, "window": 2},
        ),
        (
            8, {"A": 84 / 85, "C": 84 / 85, "B": 1.517647, "e": 4.023529}, 0.019412,
            {"column": 2, "shop window": 2, "wall": 4, "window": 2},
        ),
        (
            12, {"A": 104 / 105, "D": 104 / 105, "B": 1.514286, "f": 2.504762}, 0.019524,
            {"column": 2, "door": 1, "shop window": 2, "wall": 3, "window": 2},
        ),
        (
            17, {"A": 104 / 105, "C": 104 / 105, "B": 1.514286, "R": 1.5, "H": 6.0}, 0.019524,
            {"column": 2, "door": 1, "roof": 1, "shop window": 2, "wall": 3, "window": 2},
        ),
    ],
)  # fmt: skip
def test_the_session_of_the_paper(last: int, sizes: dict[str, float], error: float, shown: dict[str, int]) -> None:
    solved = solve_design(stage(last))[0]
    assert solved.layout.candidate.counters == {"k": 2}
    assert {name: solved.layout.sizing.sizes[name] for name in sizes} == pytest.approx(sizes, abs=1e-6)
    assert solved.layout.sizing.error == pytest.approx(error, abs=1e-6)
    assert labels(solved) == shown
    assert solved.facade.height == (4.5 if last >= 14 else 3.0)


def test_the_session_ends_with_the_shipped_house() -> None:
    made, shipped = solve_design(stage(17))[0], solve_design(residential())[0]
    assert made.layout.energy == pytest.approx(shipped.layout.energy)
    assert [label for label in labels(shipped) if label != "wall"] == [
        label for label in labels(made) if label != "wall"
    ]


def test_columns_that_keep_their_size_overhang() -> None:
    """Supplement, section 3.4."""
    text = (
        f"{CANVAS}\nsolver = {{ overhang = true }}\n[symbols]\nA = 1.0\nB = 1.6\nP = 2.0\nQ = 1.0\ne = {{}}\n"
        'C = { size = 1.1, opaque = false }\n[patterns]\nBx = "A(BA)^k"\nBy = "PQ"\nCx = "cec; c := C"\n'
    )
    solved = solve_design(parse_design(text + COLUMNS + HOUSE))[0]
    sizes = solved.layout.sizing.sizes
    assert {name: sizes[name] for name in "ABC"} == pytest.approx({"A": 0.953846, "B": 1.569231, "C": 1.1}, abs=1e-6)
    assert solved.layout.sizing.error == pytest.approx(0.003077, abs=1e-6)


def test_layers_and_masks_are_switches() -> None:
    off = residential({'name = "door"\n': 'name = "door"\non = false\n'})
    assert "door" not in labels(solve_design(off)[0])
    everywhere = residential(
        {'y = "By"\nmask = { y = ["P"] }\n\n[[layers]]\nname = "columns"': 'y = "By"\n\n[[layers]]\nname = "columns"'}
    )
    assert "D Q" in labels(solve_design(everywhere)[0])


def test_designs_have_the_complexity_of_the_paper() -> None:
    apartment = load_design(DESIGNS / "apartment.toml")
    assert (len(apartment.patterns), len(apartment.layers)) == (6, 4)
    assert (len(apartment.symbols), len(apartment.counters)) == (12, 4)
    assert len(load_design(DESIGNS / "concert_hall.toml").layers) == 26
