"""Cells: evidence and posterior beside sums over all values, and what other cells tell."""

import numpy as np
import pytest

from grammarlab.preference.cells.cells import ScoreCells, grid_of, levels_of
from grammarlab.preference.cells.splits import Splits
from grammarlab.preference.person import log_likelihood

ROWS = np.array([[0.0, 1.0], [0.0, 2.0], [1.0, 1.0], [1.0, 3.0], [0.0, 3.0], [1.0, 2.0]])
SCORES = np.array([0.0, 0.0, 62.0, 60.0, 3.0, 57.0])


def cells_of(noise=5.0, levels=None):
    splits = Splits.of(ROWS, np.array([0, 1]), np.zeros(2, dtype=bool), SCORES)
    return ScoreCells(splits, SCORES, grid_of(SCORES), noise, 0.05, levels)


def prior_of(cells):
    """[G] where there are no levels: one quarter at 0, the rest over the even grid and the scores.

    Of those below 1.5 standard deviations of the noise nine tenths go to 0.
    """
    even = np.isin(cells.grid, np.arange(0.0, 101.0, 4.0))
    prior = 0.75 * (0.8 * even / even.sum() + 0.2 / len(cells.grid))
    prior[0] += 0.25
    for place, value in enumerate(cells.grid.tolist()):
        if 0.0 < value < 1.5 * cells.noise:
            prior[0] += 0.9 * prior[place]
            prior[place] *= 0.1
    return prior


@pytest.mark.parametrize("cell", [[0], [2, 3, 5], [0, 2], [0, 1, 2, 3, 4, 5]])
def test_evidence_and_posterior_are_sums_over_all_values(cell):
    cells, cell = cells_of(), np.array(cell)
    terms = prior_of(cells) * np.exp(log_likelihood(SCORES[cell], cells.grid, 5.0, 0.05).astype(float).sum(axis=0))
    assert cells.of_cell(cell) == pytest.approx(np.log(terms.sum()), abs=1e-4)
    np.testing.assert_allclose(cells.posterior(cell), terms / terms.sum(), atol=1e-5)


def test_a_prior_is_a_distribution():
    assert prior_of(cells_of()).sum() == pytest.approx(1.0)


def test_each_way_to_divide_has_the_evidence_of_its_parts():
    cells, every = cells_of(), np.arange(len(SCORES))
    ranked = cells.ranked(every)
    assert ranked is not None
    seen = set()
    for way, number in zip(ranked.member.tolist(), ranked.group.tolist(), strict=True):
        split = cells.splits.drawn(np.array([way]), np.random.default_rng(0))
        parts = cells.splits.parts[split]
        evidence = sum(cells.of_cell(every[parts == part]) for part in np.unique(parts))
        assert ranked.log_posterior[number] - ranked.log_mass[number] == pytest.approx(evidence, abs=1e-3)
        seen.add(number)
    assert seen == set(range(len(ranked.log_mass)))


def test_a_look_ahead_divides_each_part_once_more_where_this_gains():
    randomness = np.random.default_rng(4)
    style = randomness.integers(0, 3, 18)
    rows = np.column_stack([np.eye(3)[style], randomness.integers(0, 2, (18, 3)).astype(float)])
    scores = np.where(rows[:, 3] == (style == 1), 90.0, randomness.choice([0.0, 30.0], 18))
    splits = Splits.of(rows, np.array([0, 0, 0, 1, 2, 3]), np.zeros(6, dtype=bool), scores)
    cells, every = ScoreCells(splits, scores, grid_of(scores), 3.0, 0.03), np.arange(18)
    ranked, alone = cells.ranked(every, ahead=True), cells.ranked(every)
    assert ranked is not None
    assert alone is not None

    def left_or_divided(part):
        found = [cells.of_cell(part)]
        for side, price in zip(splits.halves[:, part], splits.log_mass, strict=True):
            found.append(price + sum(cells.of_cell(half) for half in (part[side], part[~side]) if len(half)))
        return max(found)

    assert len(splits.many) == 1
    for way, number in zip(ranked.member.tolist(), ranked.group.tolist(), strict=True):
        part_of = splits.parts[splits.drawn(np.array([way]), randomness)]
        after_two = sum(left_or_divided(every[part_of == part]) for part in np.unique(part_of))
        expected = max(alone.log_posterior[number], ranked.log_mass[number] + after_two)
        assert ranked.log_posterior[number] == pytest.approx(expected, abs=2e-3)
    assert (ranked.log_posterior > alone.log_posterior + 1.0).any()


def test_ways_to_divide_that_are_one_have_all_their_mass():
    cells = cells_of()
    ranked = cells.ranked(np.arange(len(SCORES)))
    assert ranked is not None
    assert np.exp(ranked.log_mass).sum() == pytest.approx(np.exp(cells.splits.log_prior).sum(), abs=1e-6)
    assert np.exp(cells.splits.log_prior).sum() == pytest.approx(1.0)


def test_what_others_are_worth_makes_a_value_likely_and_a_cell_does_not_tell_itself():
    before = cells_of(noise=10.0)
    liked, disliked = np.array([2, 3]), np.array([0, 1, 4])
    levels = levels_of(before, [(1.0, [liked, disliked, np.array([5])])])
    after = cells_of(noise=10.0, levels=levels)
    # The sixth score is like those of another cell, which makes it likelier; without that cell nothing changes.
    assert after.of_cell(np.array([5])) > before.of_cell(np.array([5])) + 0.1
    alone = cells_of(noise=10.0, levels=levels_of(before, [(1.0, [np.array([5])])]))
    assert alone.of_cell(np.array([5])) == pytest.approx(before.of_cell(np.array([5])), abs=1e-4)
