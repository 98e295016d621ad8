"""Words that fit a canvas."""

import math
from itertools import product

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import minimize

from grammarlab.errors import FacadeError
from grammarlab.layers.candidates import MOST_CANDIDATES, FittingWords
from grammarlab.layers.file import parse_design
from tests.cases import bulk
from tests.layers.samples import design, residential

HOUSE = "A = 1.0\nB = 1.6"
APART = """
canvas = { width = 12, height = 30 }
symbols = { A = 1, P = 3 }
[[layers]]
x = "A^k"
y = "P^{10k}"
"""


def fits(made, tolerance: float) -> list:
    return FittingWords(made, made.width, made.height).within(tolerance)


def text(instance) -> str:
    return "".join(letter.symbol for letter in instance.word)


def test_errors_of_the_wall_of_the_paper() -> None:
    """One layer fills the canvas, so its bound is its error of sizes."""
    found = {fit.counters["k"]: fit.bound for fit in fits(design({"wall": "A(BA)^k"}, HOUSE, 6.0), 3.0)}
    assert found == pytest.approx({1: 1.152, 2: 0.04 / 13, 3: 0.3136})


def test_words_of_the_house() -> None:
    best = fits(residential(), 3.0)[0]
    assert best.counters == {"k": 2}
    assert {name: text(each) for name, each in best.words.items()} == {
        "Rx": "H",
        "Ry": "PQR",
        "Dx": "fDf",
        "By": "PQ",
        "Cx": "CeC",
        "Bx": "ABABA",
    }
    assert best.words["Bx"].size == pytest.approx(6.2)


def test_words_are_shorter_below_letters_that_hide_them() -> None:
    """Supplement, section 3.2: canvas 12, I(BI)^l over A^k."""
    symbols = "A = 4\nB = {{ size = 4, opaque = false }}\nI = {{ size = 1, opaque = {} }}"
    counts = {}
    for opaque in ("true", "false"):
        made = design({"front": "I(BI)^l", "back": "A^k"}, symbols.format(opaque), 12.0)
        counts[opaque] = {fit.counters["k"] for fit in fits(made, 1.0) if fit.counters["l"] == 2}
    assert counts == {"true": {3, 2}, "false": {3}}


def test_tolerance_bounds_words_from_both_sides() -> None:
    """Figure 7: canvas 10 and a tolerance of 1 allow words of 9 to 11 m."""
    made = design({"front": "A^k"}, "A = 1", 10.0)
    assert sorted(fit.counters["k"] for fit in fits(made, 1.0)) == [9, 10, 11]
    unsized = design({"front": "eBe; B := C^k"}, "C = 3\ne = {}", 10.0)
    assert sorted(fit.counters["k"] for fit in fits(unsized, 1.0)) == [0, 1, 2, 3]


def test_counters_are_the_same_along_both_axes() -> None:
    made = parse_design(APART.replace("10k", "k - 1").replace("30", "9"))
    found = fits(made, 100.0)
    assert {fit.counters["k"] for fit in found} == {4, 5, 6, 7, 8, 9, 10}
    assert all(len(fit.words["P^{k - 1}"].word) == fit.counters["k"] - 1 for fit in found)


def test_alternatives_are_candidates() -> None:
    found = fits(design({"wall": "A(B|CC)A"}, "A = 1\nB = 2\nC = 1.1", 4.0), 1.0)
    assert [text(fit.words["A(B|CC)A"]) for fit in found] == ["ABA", "ACCA"]


def test_counters_without_a_letter_make_no_other_candidates() -> None:
    made = design({"wall": "A B^n|C^m"}, "A = 1\nB = 2\nC = 3", 9.0)
    found = fits(made, 1.0)
    assert len(found) == 2
    counters = {text(fit.words["A B^n|C^m"]): fit.counters for fit in found}
    assert counters == {"CCC": {"n": 0, "m": 3}, "ABBBB": {"n": 4, "m": 0}}
    both = fits(design({"wall": "A^kA^m"}, "A = 1", 4.0), 0.0)
    assert [text(fit.words["A^kA^m"]) for fit in both] == ["AAAA"]


@bulk(30)
@given(
    sizes=st.lists(st.integers(1, 30), min_size=3, max_size=3),
    counts=st.tuples(st.integers(0, 4), st.integers(0, 4)),
    canvas=st.integers(20, 120),
)
def test_bounds_are_least_sums_of_squares(sizes: list[int], counts: tuple[int, int], canvas: int) -> None:
    """A single layer has to fill the canvas: its bound is the optimum of an independent optimizer."""
    made = design(
        {"wall": "A^kC(AB)^lC"},
        "\n".join(f"{name} = {size / 10}" for name, size in zip("ABC", sizes, strict=True)),
        canvas / 10,
        counters="k = { most = 4 }\nl = { most = 4 }",
    )
    all_fits = {(fit.counters["k"], fit.counters["l"]): fit for fit in fits(made, 100.0)}
    fit = all_fits.get(counts)
    often = np.array([counts[0] + counts[1], counts[1], 2.0])
    length = float(often @ sizes) / 10
    if fit is None:
        assert not canvas / 30 - 1e-9 <= length <= 3 * canvas / 10 + 1e-9
        return
    least = minimize(
        lambda x: float(((x - np.array(sizes) / 10) ** 2).sum()),
        np.array(sizes) / 10,
        constraints={"type": "eq", "fun": lambda x: often @ x - canvas / 10},
    )
    assert fit.bound == pytest.approx(least.fun, abs=1e-5)
    assert fit.gap == pytest.approx(abs(length - canvas / 10))


@bulk(25)
@given(
    canvas=st.floats(3.0, 12.0),
    tolerance=st.floats(0.1, 2.0),
    sizes=st.lists(st.floats(0.5, 2.5), min_size=3, max_size=3),
)
def test_no_words_are_missing(canvas: float, tolerance: float, sizes: list[float]) -> None:
    """Against all pairs of counters: a top layer of A and B, and below it C with gaps for the letters above."""
    symbols = "\n".join(f"{name} = {size!r}" for name, size in zip("ABC", sizes, strict=True))
    made = design({"front": "A(BA)^k", "back": "C^l"}, symbols, canvas)
    a, b, c = sizes
    expected = set()
    for k, count in product(range(30), range(1, 60)):
        front, back = a + k * (a + b), count * c
        if (
            max(canvas / 3, canvas - tolerance) <= front <= canvas + tolerance
            and back <= canvas + tolerance
            and (back + front >= canvas - min(tolerance, 2 * canvas / 3))
        ):
            expected.add((k, count))
    found = {(fit.counters["k"], fit.counters["l"]) for fit in fits(made, tolerance)}
    assert found == expected


def failure(made) -> str:
    with pytest.raises(FacadeError) as caught:
        FittingWords(made, made.width, made.height).tolerances(1)
    return str(caught.value)


def test_what_cannot_fit_is_explained() -> None:
    assert "counter k has no bound" in failure(design({"wall": "Ae^k"}, "A = 1\ne = {}", 5.0))
    assert "more than 400 letters" in failure(design({"wall": "A^k"}, "A = 0.001", 5.0))
    assert "closest word is 40 m" in failure(design({"wall": "AA"}, "A = 20", 5.0))
    assert "alternatives" in failure(design({"wall": "(A|B)" * 9}, "A = 1\nB = 1", 9.0))


def test_patterns_that_contradict_each_other_are_named() -> None:
    told = failure(parse_design(APART))
    assert "contradict each other" in told
    assert "'A^k' over 12 m with k = 4 to 36" in told
    assert "'P^{10k}' over 30 m with k = 1 to 3" in told


def test_a_bound_of_a_counter_is_kept() -> None:
    made = design({"wall": "A^ke"}, "A = 1\ne = {}", 5.0, counters="k = { least = 2, most = 3 }")
    assert sorted(fit.counters["k"] for fit in fits(made, 5.0)) == [2, 3]


def test_negative_counters_reflect() -> None:
    made = design(
        {"wall": "A^3(BC)^k"}, "A = 1\nB = 1\nC = 1", 9.0, counters='k = { least = -2, reflection = "pivot-outer" }'
    )
    words = {fit.counters["k"]: text(fit.words["A^3(BC)^k"]) for fit in fits(made, 9.0)}
    assert words[-2] == "AAABCBCBCB"
    assert words[1] == "AAABC"


def test_of_too_many_combinations_those_that_fit_best_are_looked_at() -> None:
    """Five layers with separate counters: 21^5 combinations."""
    names = "abcdf"
    made = design(
        {f"layer {name}": f"(A)^{name}" for name in names}, "A = 1.0", 12.0,
        counters="".join(f"{name} = {{ least = 4, most = 24 }}\n" for name in names),
    )  # fmt: skip
    words = FittingWords(made, made.width, made.height)
    found = words.within(6.0)
    assert 0 < len(found) <= MOST_CANDIDATES
    assert all(fit.gap <= 6.0 for fit in found)
    assert dict(found[0].counters) == dict.fromkeys(names, 12)
    assert words.least_of_others(6.0) == 0.0
    house = residential()
    assert FittingWords(house, house.width, house.height).least_of_others(0.5) == math.inf
