"""Composed columns: what scores need is found in the language, whatever kind it is, and nothing else."""

from pathlib import Path

import numpy as np
import pytest

from grammarlab.derivation import derive
from grammarlab.features.expression import Expression
from grammarlab.features.patterns.counts import count
from grammarlab.features.patterns.pattern import Draw
from grammarlab.features.patterns.pattern_text import parse
from grammarlab.language.grammar import Grammar
from grammarlab.learning.composed_columns import _same, composed_columns
from grammarlab.learning.designs.grammar_space import GrammarSpace
from grammarlab.learning.settings import FeatureOptions
from grammarlab.preference.judge.labelled_columns import MAX_LABELS, selected
from tests.cases import takes_turns

PARTS = [f"Part{number}" for number in range(5)]
HOUSE = Grammar.parse(
    f"""
attr width = rand(1, 9)
attr depth = rand(1, 9)
attr storey = rand(2, 4)
Lot --> s(width, 9, depth) Storeys {" ".join(PARTS)}
Storeys --> 30% : Floor Floor 30% : Floor Floor Floor else : Floor Floor Floor Floor
Floor --> 50% : Brick. else : Render.
"""
    + "".join(f"{part} --> 40% : Gilded{part} else : Plain{part}\n" for part in PARTS)
)
SPACE = GrammarSpace(HOUSE, Path())
OPTIONS = FeatureOptions(2, ("paths", "symbols", "draws"))
FOREST = derive(HOUSE, 96, 1)
WIDTH, DEPTH, STOREY = SPACE.values([FOREST], [Draw("width"), Draw("depth"), Draw("storey")]).T
FLOORS, BRICK, *GILDED = count(
    FOREST, [parse(text) for text in ("Floor", "Floor:0", *(f"{part}:0" for part in PARTS))]
).T


def found(value, noise=0.0):
    """Composed columns for scores of a value, and their values."""
    errors = noise * np.random.default_rng(0).normal(size=96)
    scores = np.clip(np.asarray(value, dtype=np.float64) + errors, 0.0, 100.0).round()
    features = list(composed_columns(SPACE, [FOREST], scores, OPTIONS))
    return features, SPACE.values([FOREST], features)


def says(column, value):
    """Whether a column orders designs as a value does, or the other way round."""
    first, second = (np.unique(numbers, return_inverse=True)[1].reshape(-1) for numbers in (column, value))
    return np.array_equal(first, second) or np.array_equal(first.max() - first, second)


@takes_turns
@pytest.mark.parametrize("noise", [0.0, 10.0])
@pytest.mark.parametrize(
    ("quantity", "scores"),
    [
        (WIDTH - DEPTH, 100.0 * (WIDTH > DEPTH)),
        (WIDTH / DEPTH, 100.0 * (WIDTH > 1.6 * DEPTH)),
        (FLOORS * STOREY, 100.0 * (np.abs(FLOORS * STOREY - 9.0) < 2.0)),
        (2.0 * WIDTH - 1.4 * DEPTH, 100.0 * (2.0 * WIDTH - 1.4 * DEPTH > 4.0)),
        (FLOORS * STOREY / WIDTH, 100.0 * (FLOORS * STOREY < 1.5 * WIDTH)),
        (np.sum(GILDED, axis=0) % 2, 90.0 * (np.sum(GILDED, axis=0) % 2)),
        (BRICK / FLOORS, 90.0 * (BRICK / FLOORS > 0.6)),
    ],
    ids=["comparison", "ratio", "height", "weighted sum", "slenderness", "odd number", "share"],
)
def test_what_scores_need_is_found(quantity, scores, noise):
    features, values = found(scores, noise)
    assert features
    assert any(says(column, quantity) for column in values.T) or explains(values, scores)


def test_a_band_of_a_sum_of_computed_sizes_is_found_and_read_back():
    spare = FLOORS * STOREY - WIDTH
    features, values = found(100.0 * (np.abs(spare - 4.0 * GILDED[0] - 2.0) < 2.0))
    liked, (feature, *_) = np.abs(spare - 4.0 * GILDED[0] - 2.0) < 2.0, features
    low, high = values[liked, 0].min(), values[liked, 0].max()
    assert np.mean(((values[:, 0] >= low) & (values[:, 0] <= high)) == liked) > 0.93
    assert Expression.parse(str(feature)).formula == feature


def explains(values, scores):
    """Whether equal scores are on one side of a bound on one of the columns, but for a few designs near it."""
    liked = scores > 0.0
    for column in values.T:
        ranks = np.argsort(np.argsort(column, kind="stable"), kind="stable")
        sides = [np.mean(liked == (ranks >= bound)) for bound in range(len(ranks))]
        if max(*sides, *(1.0 - side for side in sides)) > 0.96:
            return True
    return False


@pytest.mark.parametrize(
    "scores",
    [
        90.0 * GILDED[2],
        100.0 * (WIDTH > 5.0),
        np.random.default_rng(0).permutation(100.0 * (WIDTH > DEPTH)),
        np.full(96, 40.0),
    ],
    ids=["a choice", "a bound", "shuffled", "equal"],
)
def test_scores_that_known_columns_explain_need_nothing(scores):
    assert found(scores)[0] == []


def test_each_column_has_its_price():
    prices = composed_columns(SPACE, [FOREST], 100.0 * (WIDTH > DEPTH), OPTIONS)
    assert all(price > np.log(2.0) for price in prices.values())


def test_of_many_labels_an_even_selection_by_score_is_judged():
    scores = np.random.default_rng(0).uniform(0.0, 100.0, 3 * MAX_LABELS)
    indices = selected(scores)
    assert len(indices) == MAX_LABELS
    assert (np.diff(indices) > 0).all()
    assert np.quantile(scores[indices], [0.1, 0.5, 0.9]) == pytest.approx(np.quantile(scores, [0.1, 0.5, 0.9]), abs=1.0)
    assert selected(scores[:5]).tolist() == [0, 1, 2, 3, 4]


@pytest.mark.parametrize("num", [1, 2, 5, 40])
def test_columns_that_order_designs_alike_are_those_whose_pairs_all_do(num):
    randomness = np.random.default_rng(num)
    known = randomness.integers(0, 3, (num, 6)).astype(np.float64)
    columns = np.concatenate(
        [known[:, :3] ** 3, 1.0 - known[:, 3:], randomness.integers(0, 3, (num, 30)).astype(np.float64)], axis=1
    )

    def pairs(column):
        return np.sign(column[:, None] - column)

    alike = [
        any(np.array_equal(pairs(column), sign * pairs(other)) for other in known.T for sign in (1.0, -1.0))
        for column in columns.T
    ]
    assert _same(columns, known).tolist() == alike
    assert alike[:6] == [True] * 6
