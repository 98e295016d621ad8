from __future__ import annotations

import itertools
from collections import Counter

import numpy as np
import pytest

from grammarlab.preference import blended
from grammarlab.preference.cells import box_search
from grammarlab.preference.cells.box_search import find_boxes
from grammarlab.preference.cells.partition import fit
from grammarlab.preference.growth.splits import Split, Value
from grammarlab.preference.queries import Situation, propose
from tests.cases import takes_turns

CONTINUOUS = np.ones(12, dtype=bool)


def conjunction(rows: np.ndarray) -> np.ndarray:
    """Five of twelve columns, seven bounds: one design in thirty."""
    liked = (rows[:, 0] > 0.5) & (rows[:, 1] < 0.6) & (rows[:, 2] > 0.2) & (rows[:, 2] < 0.7) & (rows[:, 3] > 0.3)
    return liked & (rows[:, 4] < 0.8) & (rows[:, 4] > 0.3)


def labelled(seed: int, num: int) -> tuple[np.ndarray, np.ndarray]:
    """Labels of which a third are liked, as if questions had been asked near liked designs."""
    rows = np.random.default_rng(seed).random((40 * num, 12))
    liked = conjunction(rows)
    chosen = np.concatenate([np.flatnonzero(liked)[: num // 3], np.flatnonzero(~liked)[: num - num // 3]])
    return rows[chosen], 100.0 * liked[chosen]


@takes_turns
def test_chains_draw_boxes_in_proportion_to_their_posterior(monkeypatch: pytest.MonkeyPatch):
    """All boxes of two columns and three slots are enumerated."""
    monkeypatch.setattr(box_search, "_NUM_SLOTS", 3)
    columns = np.array([[0.0, 5.0], [1.0, 1.0], [3.0, 4.0], [7.0, 0.0]])
    gains = np.array([1.5, -1.0, 0.7, -1.2], dtype=np.float32)
    places = box_search._Places.of(columns, np.array([1.0, 3.0]))
    chain, counts = box_search._Chain(places, np.random.default_rng(1)), Counter[frozenset]()
    num = 40_000
    for _ in range(num):
        chain.step(gains)
        counts[frozenset((*name, _place(places, name[0], bound)) for name, bound in chain.faces.items())] += 1
    odds = dict[frozenset, float]()
    faces = [(column, upper, place) for column in range(2) for upper in (False, True) for place in range(3)]
    for size in range(4):
        for chosen in itertools.combinations(faces, size):
            if len({face[:2] for face in chosen}) < size:
                continue
            inside = np.ones(4, dtype=bool)
            for column, upper, place in chosen:
                above = columns[:, column] > places.low[column, place]
                inside &= ~above if upper else above
            prior = sum(float(places.log_prior[column, place]) for column, _, place in chosen)
            # The faces may be in any slots.
            orders = {0: 1, 1: 3, 2: 6, 3: 6}[size]
            odds[frozenset(chosen)] = orders * np.exp(float(gains[inside].sum()) + prior)
    total = sum(odds.values())
    assert set(counts) <= set(odds)
    distance = sum(abs(counts[box] / num - share / total) for box, share in odds.items()) / 2.0
    assert distance < 0.03


def _place(places: box_search._Places, column: int, bound: float) -> int:
    return int(np.flatnonzero((places.low[column] <= bound) & (bound < places.high[column]))[0])


def test_boxes_hold_the_liked_labels_only():
    rows, scores = labelled(1, 150)
    boxes = find_boxes(rows, scores, CONTINUOUS, np.random.default_rng(0))
    inside = np.array([((rows > box.low) & (rows <= box.high)).all(axis=1) for box in boxes])
    wrong = (inside != (scores > 50.0)).mean(axis=1)
    assert len(boxes) == 36
    assert np.median(wrong) < 0.02
    fresh = np.random.default_rng(5).random((4000, 12))
    share = np.mean([((fresh > box.low) & (fresh <= box.high)).all(axis=1) for box in boxes], axis=0)
    assert share[conjunction(fresh)].mean() > 0.9
    assert share[~conjunction(fresh)].mean() < 0.03


def test_a_box_is_a_tree_with_its_bounds():
    rows, scores = labelled(2, 90)
    for box in find_boxes(rows, scores, CONTINUOUS, np.random.default_rng(0), num_chains=1):
        tree = box.tree(rows)
        number, cells = tree.cell_of(rows)
        inside = ((rows > box.low) & (rows <= box.high)).all(axis=1)
        assert len(np.unique(number[inside])) <= 1
        assert set(np.concatenate(list(tree.cells()))) == set(range(len(rows)))
        # Whoever is inside shares the cell of the innermost node.
        if inside.any():
            assert np.array_equal(cells[number[inside][0]], np.flatnonzero(inside))
        bounds = {
            Split(Value(column), (bound,))
            for end in (box.low, box.high)
            for column, bound in enumerate(end.tolist())
            if np.isfinite(bound)
        }
        assert {node.split for node in tree.nodes() if node.split} <= bounds


@takes_turns
@pytest.mark.parametrize("deviation", [0.0, 10.0])
def test_cells_learn_conjunctions_of_many_columns(deviation: float):
    rows, scores = labelled(3, 210)
    random = np.random.default_rng(7)
    noisy = np.clip(scores + deviation * random.normal(size=len(scores)), 0.0, 100.0)
    cells = fit(rows, noisy, continuous=CONTINUOUS)
    fresh = random.random((6000, 12))
    predicted, liked = cells.predict(fresh).mean, conjunction(fresh)
    assert predicted[liked].mean() > 90.0
    assert predicted[~liked].mean() < 2.5
    assert cells.noise == pytest.approx(max(deviation, 0.5), rel=0.35)
    # Its boxes disagree near bounds only.
    shares, values = cells.opinions(fresh)
    assert shares.sum() == pytest.approx(1.0)
    away = shares @ (values - shares @ values) ** 2
    assert np.mean(away > 400.0) < 0.06


def test_few_columns_or_equal_scores_have_no_boxes():
    rows, scores = labelled(4, 60)
    random = np.random.default_rng(0)
    assert find_boxes(rows, scores, np.arange(12) < 7, random) == []
    wide = np.column_stack([rows, np.round(rows)]).astype(np.float64)
    assert find_boxes(wide, scores, np.arange(24) < 12, random) == []
    assert find_boxes(rows, np.full(60, 50.0), CONTINUOUS, random) == []
    assert find_boxes(rows[:0], scores[:0], CONTINUOUS, random) == []
    assert random.random() == np.random.default_rng(0).random()


def situation_of(rows: np.ndarray, scores: np.ndarray) -> tuple[Situation, blended.BlendedPreference]:
    """Labels and 3,000 other models."""
    pool = np.concatenate([rows, np.random.default_rng(9).random((3000, 12))])
    preference = blended.fit(rows, scores, continuous=CONTINUOUS)
    return Situation(pool, np.ones(len(pool), dtype=bool), np.arange(len(rows)), scores, preference), preference


@takes_turns
def test_questions_are_about_what_boxes_dispute():
    wrong = list[float]()
    for seed in (5, 7):
        rows, scores = labelled(seed, 120)
        situation, preference = situation_of(rows, scores)
        asked = propose("default", situation, 16, seed=1)
        assert len(np.unique(asked)) == 16
        assert not np.isin(asked, situation.scored).any()
        x = situation.pool
        clauses = [x[:, 0] > 0.5, x[:, 1] < 0.6, x[:, 2] > 0.2, x[:, 2] < 0.7]
        clauses += [x[:, 3] > 0.3, x[:, 4] < 0.8, x[:, 4] > 0.3]
        wrong.append(np.sum(~np.array(clauses), axis=0)[asked].mean())
        shares, values = preference.partition.opinions(x[asked])
        assert np.mean(np.abs(shares @ values - 50.0) < 35.0) > 0.7
    # Models at random have 2.2 wrong clauses; the others are nearly liked, or liked, and nobody knows it.
    assert np.mean(wrong) < 1.6


def test_while_nothing_is_liked_questions_about_continuous_columns_are_random():
    rows = np.random.default_rng(2).random((40, 12))
    situation, _ = situation_of(rows, np.zeros(40))
    asked = np.concatenate([propose("default", situation, 50, seed=seed) for seed in range(8)])
    # The most unlike models would be in the corners.
    extreme = ((situation.pool - 0.5) ** 2).sum(axis=1)
    assert extreme[asked].mean() == pytest.approx(extreme.mean(), rel=0.03)
    assert not np.isin(asked, situation.scored).any()
