"""Changes of a design in its text, against the design that is read from it."""

from __future__ import annotations

from dataclasses import replace

import pytest

from grammarlab.errors import LanguageError
from grammarlab.layers.file import parse_design
from grammarlab.pages.layers.text_edits import FLAGS, with_canvas, with_flag, with_mask, with_switch
from tests.layers.samples import DESIGNS, RESIDENTIAL

TEXTS = [path.read_text(encoding="utf-8") for path in sorted(DESIGNS.glob("*.toml"))]
INLINE = (
    "canvas = { width = 6.0, height = 3.0 }\nsymbols = { A = 1.0, P = { size = 3.0 } } # all\n"
    'layers = [{ x = "A", y = "P" }, { x = "AA", y = "P", mask = { x = ["A"] } }]\n'
)


@pytest.mark.parametrize("text", [*TEXTS, INLINE])
def test_what_is_changed_is_all_that_changes(text: str):
    before = parse_design(text)
    assert parse_design(with_canvas(text, 7.125, before.height)) == replace(before, width=7.125)
    for number, layer in enumerate(before.layers[-4:], start=max(0, len(before.layers) - 4)):
        layers = [*before.layers]
        layers[number] = replace(layer, on=False)
        if any(each.on for each in layers):
            assert parse_design(with_switch(text, number, on=False)) == replace(before, layers=tuple(layers))
        for axis, pattern in enumerate(layer.patterns):
            symbols = before.patterns[pattern].symbols()
            for seen in (None, symbols[:1]):
                masks = [*layer.masks]
                masks[axis] = None if seen is None else frozenset(seen)
                layers[number] = replace(layer, masks=(masks[0], masks[1]))
                assert parse_design(with_mask(text, number, axis, seen)) == replace(before, layers=tuple(layers))
    for symbol in [*before.symbols.values()][:3]:
        for flag in FLAGS:
            value = not getattr(symbol, flag)
            changed = replace(symbol, **{flag: value})
            expected = replace(before, symbols={**before.symbols, symbol.name: changed})
            assert parse_design(with_flag(text, symbol.name, flag, value=value)) == expected


def test_comments_and_all_other_lines_stay():
    text = with_flag(with_switch(RESIDENTIAL, 1, on=False), "A", "attached", value=True)
    before, after = RESIDENTIAL.splitlines(), text.splitlines()
    assert [line for line in before if line not in after] == ["A = { size = 1.0 }                     # wall"]
    assert sum("# wall" in line for line in after) == 1
    back = with_flag(with_switch(text, 1, on=True), "A", "attached", value=False)
    assert parse_design(back) == parse_design(RESIDENTIAL)


def test_a_design_without_a_layer_that_is_on_is_refused():
    text = INLINE.partition("layers")[0] + 'layers = [{ x = "A", y = "P" }]\n'
    with pytest.raises(LanguageError, match="a layer that is on"):
        with_switch(text, 0, on=False)
