"""Contradictions of designs, compared with all subsets of statements."""

from itertools import combinations

import pytest

import grammarlab.layers.layouts as layouts_module
from grammarlab.errors import FacadeError
from grammarlab.layers.conflicts import Statement, contradiction, in_words, relaxed, statements
from grammarlab.layers.design import Design
from grammarlab.layers.file import parse_design
from grammarlab.layers.layouts import layouts, may_fit
from tests.cases import some
from tests.layers.samples import residential


def made(symbols: str, *layers: tuple[str, str], width: float = 6.0, height: float = 3.0, more: str = "") -> Design:
    """Layers of x and y patterns, each in a separate group along x except the first two."""
    rows = "".join(
        f'[[layers]]\nx = "{x}"\ny = "{y}"\ngroup = {{ x = "{max(at - 1, 0)}" }}\n' for at, (x, y) in enumerate(layers)
    )
    return parse_design(
        f"canvas = {{ width = {width}, height = {height} }}\nsymbols = {{ {symbols}, Y = 3 }}\n{more}\n{rows}"
    )


DESIGNS = {
    "counter": (made("A = 1, P = 3", ("A^k", "P^{10k}"), width=12.0, height=30.0), "k has one value"),
    "size": (made("A = 20, B = 1", ("B^k", "Y"), ("AA", "Y")), "A is 20 m long"),
    "open": (made("B = 1, A = { size = 1, opaque = false }", ("A^k", "Y")), "A is not opaque"),
    "transparent": (made("A = { size = 1, transparent = true }", ("A^k", "Y")), "A is transparent"),
    "both axes": (made("A = 4", ("A", "A")), "A has one size along both axes"),
    "bound": (made("A = 1, B = 2", ("A^k", "Y"), ("B^k", "Y"), more="counters = { k = { most = 1 } }"), "A^k"),
}


@pytest.mark.parametrize("name", some(list(DESIGNS)))
def test_all_but_any_one_of_it_can_be(name: str) -> None:
    design, told = DESIGNS[name]
    found = contradiction(design, may_fit)
    assert found
    assert told in in_words(design, found)
    assert not may_fit(relaxed(design, found))
    for num in range(len(found)):
        for kept in combinations(found, num):
            assert may_fit(relaxed(design, kept)), kept


def test_the_message_says_what_contradicts_each_other() -> None:
    design, _ = DESIGNS["counter"]
    with pytest.raises(FacadeError) as caught:
        layouts(design, 12.0, 30.0)
    told = str(caught.value)
    for each in ("'A^k' fills 12 m along x", "A is 1 m long", "P is 3 m long", "k has one value in all patterns"):
        assert each in told


def test_a_contradiction_that_takes_more_steps_is_named_too(monkeypatch: pytest.MonkeyPatch) -> None:
    """A transparent letter of a size leaves a hole beside an opaque one, whatever the sizes are."""
    design = parse_design(
        "canvas = { width = 12, height = 5 }\n"
        "symbols = { A = 1, B = 1.5, O = 3, P = 2.5, v = { transparent = true }, w = { size = 1, transparent = true } }"
        '\n[[layers]]\nx = "v O v"\ny = "w P v"\nmask = { x = ["O"] }\n[[layers]]\nx = "A(BA)^k"\ny = "PP"\n'
    )
    monkeypatch.setattr(layouts_module, "_TIME_LIMIT_S", 1000.0)
    with pytest.raises(FacadeError, match="'v O v' fills 12 m along x; v is transparent"):
        layouts(design, 12.0, 5.0)


def test_what_fits_has_no_contradiction() -> None:
    assert contradiction(residential(), may_fit) == ()


def test_all_statements_are_the_design() -> None:
    """With all statements, a design has its own layouts; without any, it has one."""
    house = residential()
    whole, none = relaxed(house, statements(house)), relaxed(house, ())
    energies = [layouts(each, 6.0, 4.5)[0].energy for each in (house, whole, none)]
    assert energies == pytest.approx([energies[0], energies[0], 0.0])


@pytest.mark.parametrize("num", [0, 1, 2, 5])
def test_the_filter_finds_what_is_needed(num: int) -> None:
    """Of thirty statements, those that an artificial rule forbids together."""
    house = residential()
    given = [Statement("size", f"S{each}") for each in range(30)]
    needed = set(given[3 : 3 + 5 * num : 5])
    tried: list[int] = []
    names = [f"S{each}" for each in range(30)]
    design = Design("", 6.0, 4.5, dict.fromkeys(names, house.symbols["A"]), {}, house.patterns, (), {})

    def lets(less: Design) -> bool:
        tried.append(1)
        kept = {Statement("size", name) for name in names if less.symbols[name].size is not None}
        return bool(needed) and not needed <= kept

    found = contradiction(design, lets, given)
    assert set(found) == needed
    assert len(tried) < 120
