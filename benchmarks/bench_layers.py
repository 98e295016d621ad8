"""Layered facades: alignment of words, proven optimal, and whole layouts of the shipped designs.

Targets on one core: 5 ms for the residential house (3 layers), 100 ms for 4 layers of up to 40 letters, 1 s for 26
layers (the concert hall), 0.5 s for words of 31, 31 and 59 letters on a canvas of 60 m.
"""

from __future__ import annotations

from pathlib import Path

import pytest

from grammarlab.layers.alignment.align import alignments
from grammarlab.layers.design import Weights
from grammarlab.layers.file import load_design
from grammarlab.layers.layouts import layouts
from tests.layers.matrices import word

SIZES = {"A": 0.8, "B": 1.2, "C": 1.0, "G": 2.0, "I": 0.5, "J": 3.5, "K": 0.6, "L": 3.35, "M": 0.7, "N": 3.3}


def aligned(benchmark, words, canvas, tolerance):
    (best,) = benchmark(alignments, words, canvas, Weights(), tolerance=tolerance)
    assert best.proven


def test_residential_house(benchmark):
    sizes = {"A": 1.0, "B": 1.6, "C": 1.1, "D": 1.0}
    rows = [word("fDf", sizes, transparent="f"), word("CeC", sizes, transparent="e", partial="C"), word("ABABA", sizes)]
    aligned(benchmark, rows, 6.0, 0.5)


def test_31_31_and_59_letters(benchmark):
    rows = [word("K" + "LK" * 15, SIZES), word("I" + "JI" * 15, SIZES), word("GCA" + "BA" * 27 + "CG", SIZES)]
    aligned(benchmark, rows, 60.0, 1.0)


def test_4_layers_of_up_to_40_letters(benchmark):
    rows = [
        word("fDf", {"D": 1.2}, transparent="f"),
        word("CeC", SIZES, transparent="e", partial="C"),
        word("M" + "NM" * 8, SIZES),
        word("A" + "BA" * 16, SIZES),
    ]
    aligned(benchmark, rows, 33.0, 1.0)


@pytest.mark.parametrize("name", ["residential", "apartment", "concert_hall"])
def test_layouts(benchmark, name):
    design = load_design(Path(__file__).parents[1] / "grammars" / "facades" / f"{name}.toml")
    (best,) = benchmark(layouts, design, design.width, design.height)
    assert best.proven
