"""Wires of templates as bars in rules."""

import numpy as np
import pytest

from grammarlab.derivation import derive
from grammarlab.language.grammar import Grammar
from grammarlab.matching.library import shipped
from grammarlab.matching.match_grammar import bar_rules, wire_bars
from grammarlab.matching.template import Template, points_along

BY_BASE = {template.base: template for template in shipped()}


@pytest.mark.parametrize("template", BY_BASE.values(), ids=BY_BASE)
def test_bars_lie_along_the_wires(template: Template) -> None:
    values = template.usual * 1.01
    attributes = [f"attr v{index} = {value:.9f}" for index, value in enumerate(values.tolist())]
    bars = wire_bars(template, [f"v{index}" for index in range(len(values))])
    forest = derive(Grammar.parse("\n".join([*attributes, f"Lot --> {bars} NIL", *bar_rules()])), 1, seed=0)
    leaves = forest.leaves
    middle = leaves.position + np.einsum("kij,kj->ki", forest.frames[leaves.frame], leaves.size / 2)
    wires = points_along(template, values)
    assert len(middle) == len(wires)
    apart = np.linalg.norm(wires.mean(axis=1)[:, None] - middle[None, :, :2], axis=2)
    assert apart.min(axis=1).max() < 1e-5
    assert np.sort(leaves.size[:, 0]) == pytest.approx(
        np.sort(np.linalg.norm(np.diff(wires, axis=1)[:, 0], axis=1)), abs=1e-5
    )


@pytest.mark.parametrize("rise", [0.0, 1e-6, -1e-6])
def test_an_arc_without_a_rise_is_the_straight_bar_between_its_ends(rise: float) -> None:
    ends = "1, 2, -1.5, 2"
    drawn = [
        derive(Grammar.parse("\n".join([f"Lot --> [ {bar} ] NIL", *bar_rules()])), 1, seed=0).leaves
        for bar in (f"Bar({ends})", f"ArcBar({ends}, {rise:.6f})")
    ]
    straight, arc = ((leaves.position, leaves.size) for leaves in drawn)
    assert np.array_equal(arc, straight)
