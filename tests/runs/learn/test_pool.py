"""The pool that a preference is looked at on, as it is and widened for rare models."""

from pathlib import Path

import numpy as np
import pytest

from grammarlab.evaluation.preparation import Source, prepare
from grammarlab.evaluation.scenario import parse as parse_scenario
from grammarlab.features.vocabulary import Options, extract
from grammarlab.language.grammar import Grammar
from grammarlab.runs.learn.pool import Pool

RULES = """
Lot --> extrude(6) split(y) { ~1 : Block | ~1 : Block }
Block --> 90% : Box else : Round
Box --> 50% : color("#ff0000") Red else : set(material.opacity, rand(0.2, 1)) Clear
"""
SEED, SIZE = 5, 600


def pool(**options):
    return Pool.of(Grammar.parse(RULES), None, SEED, SIZE, **options)


def test_a_pool_that_is_widened_later_is_the_one_that_was_wide_from_the_beginning():
    told = []
    narrow, wide = pool(), pool(wide=True)
    later = pool(wide=True, known=narrow, on_progress=lambda done, total: told.append((done, total)))
    assert sum(narrow.sizes) == SIZE < sum(wide.sizes) == sum(later.sizes)
    assert later.forests[: len(narrow.forests)] == narrow.forests
    assert np.array_equal(later.weights, wide.weights)
    tables = [extract(models.forests, Options(2, draws=True)) for models in (wide, later)]
    assert tables[0].names == tables[1].names
    assert np.array_equal(tables[0].rows(), tables[1].rows())
    assert told[-1] == (sum(wide.sizes), sum(wide.sizes))
    assert sorted(told) == told
    assert told[0][0] > SIZE


@pytest.mark.parametrize("wide", [False, True])
def test_the_weights_are_those_of_the_protocol(wide):
    text = f'name = "n"\ntitle = "t"\ngrammar = "toy"\nnum_models = {SIZE}\nseed = {SEED}\npreference = "{{Round}}"\n'
    material = prepare(Source(parse_scenario(text), Grammar.parse(RULES), Path(), wide=wide))
    assert np.array_equal(pool(wide=wide).weights, material.pool_weights)
    assert pool(wide=wide).weights.mean() == pytest.approx(1.0, abs=0.2)
