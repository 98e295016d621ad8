"""What chance decided about a building, in lines."""

from __future__ import annotations

from grammarlab.derivation.derive import derive
from grammarlab.language.grammar import Grammar
from grammarlab.pages.city.rule_words import decisions

TOWN = Grammar.parse(
    """
attr height = rand(3, 9)
Lot --> 50% : Low else : High
Low --> extrude(height) split(x) { 1 : Part | ~1 : Part }
High --> extrude(2 * height) comp(f) { side : Part | top : X. }
Part --> 50% : color("#ff0000") X. else : Y. Z.
"""
)


def test_each_choice_is_one_line_and_alike_ones_are_counted():
    for seed in range(8):
        forest = derive(TOWN, 1, seed=seed)
        lines = decisions(forest)
        symbols = [forest.symbols[symbol] for symbol in forest.nodes.symbol]
        assert lines[0] == ("Lot → Low (line 3)" if "Low" in symbols else "Lot → High (line 3)")
        parts = [line for line in lines if line.startswith("Part → ")]
        counts = [int(line.partition(" × ")[2] or 1) for line in parts]
        assert {line.partition(" × ")[0] for line in parts} <= {"Part → X. (line 6)", "Part → Y., Z. (line 6)"}
        assert sum(counts) == symbols.count("Part")
        (drawn,) = forest.draws.value[[forest.sites[site].kind == "uniform" for site in forest.draws.site]].tolist()
        assert lines[-1] == f"height = {drawn:.2f}"
