"""Every candidate is its formula; prices are a prior; what is kept is varied and different."""

from __future__ import annotations

from collections import Counter

import numpy as np
import pytest

from grammarlab.arrays import MOST_COLUMNS
from grammarlab.derivation.derive import derive
from grammarlab.derivation.forest import Forest
from grammarlab.derivation.selection import join_forests
from grammarlab.features.expression import Expression
from grammarlab.features.patterns.counts import count
from grammarlab.features.patterns.pattern import Draw, Formula
from grammarlab.language.grammar import Grammar
from grammarlab.learning.chosen_candidates import chosen_candidates
from grammarlab.tastes import aggregates, language
from grammarlab.tastes.basic_quantities import Elements
from grammarlab.tastes.language import MAX_CANDIDATES, PRODUCTIONS, candidates, priced
from grammarlab.tastes.quantities import Quantities, blocks
from tests.tastes.grammars import GRAMMARS, READERS, elements_of, elements_of_long_names, forests_of


@pytest.mark.parametrize("name", PRODUCTIONS)
@pytest.mark.parametrize("grammar", GRAMMARS)
def test_the_columns_of_a_production_are_the_values_of_its_formulas(name, grammar):
    forests = forests_of(grammar)
    for block in PRODUCTIONS[name](elements_of(grammar)):
        formulas = [block.formula(index) for index in range(block.size)]
        expected = np.concatenate([count(forest, formulas) for forest in forests])
        np.testing.assert_allclose(block.values(), expected, rtol=1e-12, atol=1e-12)


def test_batches_change_nothing():
    whole = join_forests(list(forests_of("towers")))
    once, again = candidates(elements_of("towers")), candidates(Elements.of([whole], READERS))
    assert once.formulas == again.formulas
    np.testing.assert_array_equal(once.values, again.values)


@pytest.mark.parametrize("name", PRODUCTIONS)
def test_every_production_makes_something_of_some_grammar(name):
    assert any(block.size for grammar in GRAMMARS for block in PRODUCTIONS[name](elements_of(grammar)))


@pytest.mark.parametrize("grammar", GRAMMARS)
def test_formulas_of_candidates_are_parsed_from_their_texts(grammar):
    for formula in candidates(elements_of(grammar)).formulas:
        if isinstance(formula, Formula):
            assert Expression.parse(str(formula)).formula == formula


@pytest.mark.parametrize("length", [200, 700])
def test_candidates_about_choices_of_long_names_are_short_enough_to_be_read_back(length):
    elements = elements_of_long_names(length)
    scores = np.random.default_rng(0).uniform(0.0, 100.0, elements.num)
    made = [*candidates(elements).formulas, *(one.formula() for one in chosen_candidates(elements, scores))]
    formulas = [formula for formula in made if isinstance(formula, Formula)]
    assert all(Expression.parse(str(formula)).formula == formula for formula in formulas)
    assert any("ascending" in str(formula) for formula in formulas) == (length == 200)


@pytest.mark.parametrize("grammar", GRAMMARS)
def test_prices_are_the_logs_of_a_prior(grammar):
    """Over everything that the productions make, also what is left out as equal to something cheaper."""
    elements = elements_of(grammar)
    parts = [priced(list(make(elements)), len(PRODUCTIONS)) for make in PRODUCTIONS.values()]
    assert sum(block.size * np.exp(-price) for part in parts for block, price in part) <= 1.0
    kept = candidates(elements)
    assert np.exp(-kept.prices).sum() <= 1.0
    # What says the same has the prior of all of it.
    priors = dict.fromkeys(forms(kept.values), 0.0)
    for block, price in (each for part in parts for each in part):
        for form in forms(block.values()):
            priors[form] += np.exp(-price)
    np.testing.assert_allclose(np.exp(-kept.prices), list(priors.values()))


def forms(values):
    """Columns that vary, without their shifts and factors."""
    for column in values.T:
        centred = column - column.mean()
        size = np.abs(centred).max(initial=0.0)
        if size > 1e-9 * max(1.0, np.abs(column).max(initial=0.0)):
            scaled = np.round(centred / size, 7)
            yield tuple((scaled * np.sign(scaled[np.flatnonzero(scaled)[0]]) + 0.0).tolist())


@pytest.mark.parametrize("grammar", GRAMMARS)
def test_kept_columns_vary_and_no_two_are_equal_up_to_a_shift_and_a_factor(grammar):
    values = candidates(elements_of(grammar)).values
    centred = values - values.mean(axis=0)
    length = np.linalg.norm(centred, axis=0)
    assert (length > 0.0).all()
    similar = np.abs(centred.T @ centred) / np.outer(length, length)
    np.fill_diagonal(similar, 0.0)
    assert similar.max(initial=0.0) < 1.0 - 1e-15


@pytest.mark.parametrize("grammar", GRAMMARS)
def test_repeats_change_nothing(grammar):
    once, again = candidates(elements_of(grammar)), candidates(elements_of(grammar))
    assert once.formulas == again.formulas
    np.testing.assert_array_equal(once.values, again.values)
    np.testing.assert_array_equal(once.prices, again.prices)


def read(formula):
    return formula.features if isinstance(formula, Formula) else (formula,)


def test_of_too_many_candidates_each_production_keeps_its_cheapest(monkeypatch):
    monkeypatch.setattr(language, "MAX_CANDIDATES", 40)
    columns = np.random.default_rng(0).normal(size=(30, 3, 50))
    cheap, costly, few = (Quantities([Draw(str(i))] * 50, columns[:, i]) for i in range(3))
    made = {
        "cheap": lambda _: blocks(lambda do, a: do("abs", a), [cheap], np.arange(50)[:, None]),
        "costly": lambda _: blocks(lambda do, a: do("exp", do("abs", a)), [costly], np.arange(50)[:, None]),
        "few": lambda _: blocks(lambda do, a: do("sqrt", do("exp", do("abs", a))), [few], np.arange(4)[:, None]),
    }
    elements = Elements.of_columns({}, 30)
    made_of = [part for formula in candidates(elements, made).formulas for part in read(formula)]
    assert Counter(map(str, made_of)) == {"0": 18, "1": 18, "2": 4}
    monkeypatch.setattr(language, "MAX_CANDIDATES", 104)
    assert len(candidates(elements, made).formulas) == 104


def test_parts_of_many_wholes_are_boundedly_many():
    rows = np.random.default_rng(0).uniform(1.0, 2.0, (41, 5))
    draws = {f"{chr(ord('a') + i // 2) * 3} {i}": row for i, row in enumerate(rows[:40])} | {"aaa mast": rows[40]}
    made = list(aggregates.parts_of_wholes(Elements.of_columns(draws, 5)))
    assert MOST_COLUMNS < sum(block.size for block in made) <= 2 * MOST_COLUMNS
    # Of those that are declared far away, what is called alike is kept.
    texts = {str(block.formula(index)) for block in made for index in range(block.size)}
    assert "$aaa mast / ($aaa 0 + $aaa 1)" in texts
    assert "$aaa mast / ($bbb 2 + $bbb 3)" not in texts


@pytest.mark.parametrize(("num_rules", "num_draws"), [(1, 3), (6, 30)])
def test_a_large_grammar_has_boundedly_many_candidates(num_rules, num_draws):
    rules = "\n".join(f"R{i} --> 50% : A{i} else : B{i} B{i}" for i in range(40 * num_rules))
    draws = "\n".join(f"attr d{i} = rand(1, 2)" for i in range(num_draws))
    start = "Lot --> " + " ".join(f"R{i}" for i in range(40 * num_rules))
    forest = derive(Grammar.parse(f"{draws}\n{start}\n{rules}"), 30, seed=1)
    found = candidates(Elements.of([forest]))
    assert len(found.formulas) <= MAX_CANDIDATES


def test_models_that_are_all_alike_have_no_candidates():
    forest: Forest = derive(Grammar.parse("Lot --> A B"), 5, seed=1)
    for forests in ([], [forest], [derive(Grammar.parse("Lot --> A B"), 0, seed=1)]):
        found = candidates(Elements.of(forests))
        assert not found.formulas
        assert found.values.shape == (sum(forest.num_models for forest in forests), 0)
        assert found.prices.shape == (0,)
