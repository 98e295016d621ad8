"""Branches that are left out: rare ones below which nothing is liked, and the rest sums to 1."""

from __future__ import annotations

import re

import numpy as np
import pytest

from grammarlab.density.exact.compile import compile_density
from grammarlab.density.grammar_skeleton import Chance, TreeGrammar
from grammarlab.derivation.derive import derive
from grammarlab.features.patterns.counts import count
from grammarlab.features.patterns.pattern_text import parse
from grammarlab.language.grammar import Grammar
from grammarlab.preference.base import LIKED_SHARE

STREET = Grammar.parse(
    """
attr age = 96% : 1 3% : 2 else : 3
@StartRule
Street --> 1% : House Barn 60% : House House else : Barn Barn
House --> case geometry.nVertices > 4 : Wing else : Wing
Wing --> 90% : Brick. 4% : Glass. else : 10% : Straw. else : Stone.
Barn --> 99.5% : Wood. else : Straw.
"""
)
READS = [parse(text) for text in ("House", "Barn", "Glass.", "Straw.")]
FOREST = derive(STREET, 20_000, 1)
VALUES = count(FOREST, READS)


def graded(seed):
    """A function of counts from 0 to 1 in the order of sizes, most of it below the limit for what is liked."""
    weights = np.random.default_rng(seed).normal(0.0, 1.5, len(READS))
    scale = np.exp(VALUES @ weights).max()
    return lambda values: np.minimum(np.exp(values @ weights) / scale, 1.0)


def learned(preference, min_share):
    return compile_density(STREET, READS, preference, forest=FOREST, min_share=min_share)


@pytest.mark.parametrize("seed", range(6))
def test_what_is_liked_keeps_its_trees_and_the_rest_loses_little(seed):
    preference = graded(seed)
    exact, trimmed = learned(preference, 0.0), learned(preference, 0.01)
    before, after = exact.ratio(FOREST), trimmed.ratio(FOREST)
    liked = preference(VALUES) >= LIKED_SHARE * preference(VALUES).max()
    assert (after[liked] > 0.0).all()
    assert (before[after > 0.0] > 0.0).all()
    # At most five choices of a tree lose a few branches of less than 1 % each.
    assert before[after == 0.0].sum() / before.sum() < 0.1
    assert trimmed.rules_after <= exact.rules_after
    assert after.mean() == pytest.approx(before.mean(), abs=0.05)


@pytest.mark.parametrize("seed", range(6))
def test_written_probabilities_sum_to_one_and_their_samples_agree(seed):
    trimmed = learned(graded(seed), 0.02)
    tree = TreeGrammar.of(trimmed.grammar)
    for body in tree.bodies.values():
        if isinstance(body, Chance):
            assert sum(body.probabilities or ()) == pytest.approx(1.0, abs=1e-12)
            assert all(probability > 0.0 for probability in body.probabilities or ())
    shares = count(trimmed.sample(10_000, 2), READS).mean(axis=0)
    weights = trimmed.ratio(FOREST)
    assert shares == pytest.approx(weights @ VALUES / weights.sum(), abs=0.08)


def test_no_branch_of_a_small_share_is_written():
    def brick(values):
        return np.where(values[:, 2] + values[:, 3] > 0, 0.001, 1.0)

    exact, trimmed = learned(brick, 0.0), learned(brick, 0.01)
    assert re.search(r"\b0\.0\d+% :", exact.text)
    assert not re.search(r"\b0\.\d+% :", trimmed.text)
    # Rare as it is in the original, a mixed street is liked as much as others.
    assert "House_" in trimmed.text or "House Barn" in trimmed.text
    mixed = (VALUES[:, 0] == 1) & (VALUES[:, 1] == 1) & (brick(VALUES) == 1.0)
    assert mixed.any()
    assert (trimmed.ratio(FOREST)[mixed] > 0.0).all()


def test_rules_that_are_equal_without_rare_branches_are_one():
    lots = Grammar.parse(
        "@StartRule\nLot --> 50% : High Porch 30% : Low Porch else : Wide Porch\nPorch --> 40% : Open. else : Shut."
    )
    reads = [parse(text) for text in ("Lot:0", "Lot:1", "Porch:1")]
    closed = (1e-4, 2e-4, 1.0)

    def score(values):
        kind = np.where(values[:, 0] > 0, 0, np.where(values[:, 1] > 0, 1, 2))
        return np.where(values[:, 2] > 0, np.array(closed)[kind], 1.0)

    exact, trimmed = (compile_density(lots, reads, score, min_share=share) for share in (0.0, 0.01))
    assert {name for name, _ in trimmed.grammar.rules} == {"Lot", "Porch", "Porch_open"}
    assert len(exact.grammar.rules) == 4
    assert "High Porch_open" in trimmed.text
    assert "Low Porch_open" in trimmed.text
