"""Symbols without a size that several layers share are named where they leave no layout."""

from typing import Any

import pytest

import grammarlab.layers.layouts as layouts_module
from grammarlab.errors import FacadeError
from grammarlab.layers.design import Design
from grammarlab.layers.design_notes import design_notes
from grammarlab.layers.file import parse_design
from grammarlab.layers.layouts import layouts, may_fit
from grammarlab.layers.shared_wildcards import shared_wildcards, told_apart
from grammarlab.layers.solving import solve

BANK = """canvas = {{ width = 10.0, height = 3.0 }}
[symbols]
w = 0.9
N = {{ size = 1.4, unoccludable = true }}
L = {{ size = 0.6, opaque = false }}
D = 2.3
g = {{}}
h = {{}}
F = 3.0
[patterns]
bays = "w(Nw)^n"
ends = "{ends}"
portal = "gdg; d := D"
[shapes]
w."*" = "wall"
[[layers]]
name = "portal"
x = "portal"
y = "F"
[[layers]]
name = "pilasters"
x = "ends"
y = "F"
[[layers]]
name = "house"
x = "bays"
y = "F"
"""


def bank(ends: str) -> Design:
    return parse_design(BANK.format(ends=ends))


def test_a_shared_symbol_that_leaves_no_layout_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    def hasty(*args: Any, effort: int = 0, **options: Any) -> Any:
        return solve(*args, effort=50_000, **options)

    monkeypatch.setattr(layouts_module, "solve", hasty)
    shared, apart = bank("lgl; l := L"), bank("lhl; l := L")
    assert layouts(apart, 10.0, 3.0)
    with pytest.raises(FacadeError, match=r"g is one symbol along x in the layers 'portal' and 'pilasters'.* a layout"):
        layouts(shared, 10.0, 3.0)


def test_told_apart_it_is_the_design_with_two_symbols() -> None:
    shared, apart = bank("lgl; l := L"), bank("lhl; l := L")
    (found,) = shared_wildcards(shared)
    assert (found.symbol, found.axis, found.layers) == ("g", 0, ("portal", "pilasters"))
    assert shared_wildcards(apart) == ()
    assert told_apart(apart, ()).patterns == apart.patterns
    renamed = told_apart(shared, (found,))
    assert shared_wildcards(renamed) == ()
    assert may_fit(renamed)
    assert [layer.masks for layer in renamed.layers] == [layer.masks for layer in shared.layers]


def test_what_is_hardly_meant_is_noted() -> None:
    assert design_notes(bank("lhl; l := L")) == ()
    (note,) = design_notes(bank("LgL"))
    assert "g in the pattern 'LgL' of the layer 'pilasters' has no size and no shape" in note
    unused = parse_design(BANK.format(ends="lhl; l := L").replace('x = "ends"', 'x = "portal"'))
    assert design_notes(unused) == ("the pattern 'ends' is in no layer.",)
