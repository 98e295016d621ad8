"""Candidates of spaces have the values that the space gives their formulas."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from grammarlab.features.patterns.pattern import Formula
from grammarlab.language.grammar import Grammar
from grammarlab.learning.designs.addresses import Address
from grammarlab.learning.designs.design_space import AbstractDesignSpace
from grammarlab.learning.designs.grammar_space import GrammarSpace
from grammarlab.learning.designs.species_space import SpeciesSpace
from grammarlab.trees.species_file import parse
from tests.cases import takes_turns
from tests.learning.bits import BitsSpace

GRAMMARS = Path(__file__).parents[3] / "grammars"
OAK, SKYSCRAPER = ((GRAMMARS / name).read_text(encoding="utf-8") for name in ("species/oak.toml", "skyscraper.cga"))
SPACES = {
    "grammar": GrammarSpace(Grammar.parse(SKYSCRAPER), GRAMMARS / "assets"),
    "species": SpeciesSpace(parse(OAK, "oak"), OAK),
}


@takes_turns
@pytest.mark.parametrize("space", SPACES.values(), ids=SPACES)
def test_candidates_have_the_values_of_their_formulas(space: AbstractDesignSpace[Any]):
    designs = [space.make([Address(False, 3, number) for number in range(24)]), *space.sample(True, 8, 5)]
    found = space.candidates(designs)
    assert any(isinstance(formula, Formula) for formula in found.formulas)
    some = np.random.default_rng(0).permutation(len(found.formulas))[:200]
    formulas = [found.formulas[index] for index in some.tolist()]
    space.check(formulas)
    np.testing.assert_allclose(space.values(designs, formulas), found.values[:, some], rtol=1e-9, atol=1e-12)


def test_a_space_without_a_language_has_no_candidates():
    space = BitsSpace()
    found = space.candidates([*space.sample(False, 5, 0)])
    assert found.formulas == ()
    assert found.values.shape == (5, 0)
