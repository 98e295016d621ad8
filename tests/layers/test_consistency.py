"""A symbol has one size and a counter one value, in all layers, axes and groups; columns end where all rows do."""

import numpy as np
import pytest

from grammarlab.layers.design import Design
from grammarlab.layers.file import load_design, parse_design
from grammarlab.layers.layouts import layouts
from grammarlab.layers.words import choices_of, make_instance
from tests.layers.samples import DESIGNS

SHARED = """
canvas = { width = 10.3, height = 7.4 }
[symbols]
A = 1.0
B = { size = 1.6, attached = true }
C = { size = 1.1, opaque = false }
D = { size = 1.3, unoccludable = true }
e = {}
[[layers]]
x = "ece; c := C"
y = "A(DA)^k"
[[layers]]
x = "D(AD)^{k + 1}"
y = "A(DA)^k"
group = { x = "apart" }
[[layers]]
x = "A(BA)^{k}"
y = "A(DA)^k"
"""
DESIGN = {
    "shared": parse_design(SHARED),
    "residential": load_design(DESIGNS / "residential.toml"),
    "apartment": load_design(DESIGNS / "apartment.toml"),
}


@pytest.mark.parametrize("design", DESIGN.values(), ids=DESIGN)
def test_sizes_counters_and_ends_agree_everywhere(design: Design) -> None:
    for layout in layouts(design, design.width, design.height, 3):
        counters = layout.candidate.counters
        rows: dict[tuple[int, str], int] = {}
        for layer in design.visible_layers:
            for axis, name in enumerate(layer.patterns):
                group = (axis, layer.groups[axis])
                row = rows[group] = rows.get(group, -1) + 1
                alignment = layout.alignments[group]
                placed = layout.sizing.placed[layout.groups.index(group)]
                word = [letter.symbol for letter in alignment.words[row]]
                possible = [
                    make_instance(design, name, counters, choices) for choices in choices_of(design.patterns[name])
                ]
                assert word in [[letter.symbol for letter in each.word] for each in possible if each is not None]
                lower, upper = placed.lower[row], placed.upper[row]
                sizes = np.array([layout.sizing.sizes[symbol] for symbol in word])
                assert upper - lower == pytest.approx(sizes, abs=1e-9)
                assert placed.ends[-1] == (design.width, design.height)[axis]
                for column, element in enumerate(alignment.cells[row]):
                    if element:
                        letters = [at for at, _ in element]
                        assert lower[letters[0]] <= placed.ends[column] + 1e-9
                        assert upper[letters[-1]] >= placed.ends[column + 1] - 1e-9
        assert layout.sizing.residual <= 1e-9
