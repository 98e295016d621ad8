import numpy as np
import pytest

from grammarlab.derivation.derive import derive
from grammarlab.language.grammar import Grammar
from grammarlab.learning.designs.flattening import flattened

TEXT = """
attr h = 5%: rand(1, 2) else: rand(2, 9)
const odd = 30
A --> 90%: B B  9%: case h < 2: C else: 1%: B else: C
      else: C
B --> 98%: NIL  2%: X.  else: Y.
C --> odd%: X.  else: 97%: NIL 3%: A
"""


def test_weights_bring_a_flattened_sample_back_to_the_grammar():
    grammar = Grammar.parse(TEXT)
    flat = flattened(grammar)
    forest = derive(flat.program, 40_000, 1)
    weights = np.exp(flat.log_ratio(forest))
    assert weights.mean() == pytest.approx(1, abs=0.05)
    shapes = np.bincount(forest.nodes.model[forest.nodes.symbol == forest.symbols.index("X.")], minlength=40_000)
    truth = derive(grammar, 40_000, 2)
    expected = np.bincount(truth.nodes.model[truth.nodes.symbol == truth.symbols.index("X.")], minlength=40_000)
    assert np.average(shapes, weights=weights) == pytest.approx(expected.mean(), rel=0.1)
    assert shapes.mean() > 3 * expected.mean()


def test_the_ratio_is_that_of_the_densities_on_every_model():
    grammar = Grammar.parse(TEXT)
    flat = flattened(grammar)
    # Equal text and equal seeds address equal draws, so the models that agree in every choice can be compared.
    original, proposal = derive(grammar, 2000, 3), derive(flat.program, 2000, 3)
    same = [k for k in range(2000) if _choices(original, k) == _choices(proposal, k)]
    assert len(same) > 50
    expected = original.log_probability()[same] - proposal.log_probability()[same]
    assert np.allclose(flat.log_ratio(proposal)[same], expected)
    assert np.allclose(flat.log_ratio(original)[same], expected)


def _choices(forest, model):
    rows = forest.nodes.model[forest.draws.node] == model
    return list(zip(forest.draws.site[rows], forest.draws.value[rows], strict=True))


def test_alternatives_are_equally_likely_and_impossible_ones_stay_impossible():
    forest = derive(flattened(Grammar.parse(TEXT)).program, 20_000, 5)
    site = next(k for k, s in enumerate(forest.sites) if s.definition == "B")
    taken = np.bincount(forest.draws.value[forest.draws.site == site].astype(int), minlength=3)
    assert taken[0] / taken.sum() == pytest.approx(0.5, abs=0.02)
    assert taken[2] == 0


def test_only_the_definitions_asked_for_change():
    grammar = Grammar.parse(TEXT)
    flat = flattened(grammar, {"B"})
    changed = {flat.program.sites[k].definition for k in np.flatnonzero(np.isfinite(flat.log_original).any(axis=1))}
    assert changed == {"B"}
    nothing = flattened(grammar, set())
    forest, same = derive(grammar, 200, 9), derive(nothing.program, 200, 9)
    assert np.array_equal(forest.nodes.rule, same.nodes.rule)
    assert not nothing.log_ratio(same).any()
