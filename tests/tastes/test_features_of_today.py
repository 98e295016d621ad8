"""Every feature that the searches of `grammarlab.features.search` find has a candidate that says the same."""

from __future__ import annotations

import numpy as np
import pytest

from grammarlab.arrays import Floats
from grammarlab.features.columns.vocabulary import Options, extract
from grammarlab.features.patterns.counts import count
from grammarlab.features.patterns.pattern import Draw, Feature, HalfSpace, Pattern, Present, Sum, Threshold, Total
from grammarlab.features.patterns.pattern_text import parse
from grammarlab.features.search.equal_choices import find_equalities
from grammarlab.features.search.sums import find_sum
from grammarlab.features.search.thresholds import find_half_space, find_relations, find_thresholds
from grammarlab.features.search.totals import counted, find_totals, total_of
from grammarlab.features.search.tree_patterns import search_patterns
from grammarlab.tastes.language import Candidates, candidates
from tests.tastes.grammars import READERS, elements_of, forests_of

TOWERS = forests_of("towers")
DRAWS = ("storey", "plinth", "front")


def _values(*features: Feature) -> Floats:
    return np.concatenate([count(forest, features) for forest in TOWERS])


def _underlying(feature: Feature) -> Floats:
    """The column of which a feature is a level or a bound, if it is one."""
    match feature:
        case Threshold(site, _):
            return _values(Draw(site))[:, 0]
        case HalfSpace(sites, weights, _, logarithmic):
            total = _values(Sum.of(sites, weights, logarithmic))[:, 0]
            return np.asarray(np.exp(total), dtype=np.float64) if logarithmic else total
        case Sum(terms, True):
            return np.asarray(np.exp(_values(Sum(terms, True))[:, 0]), dtype=np.float64)
        case Present(inner):
            return _values(inner)[:, 0]
        case _:
            return _values(feature)[:, 0]


def _has(found: Candidates, column: Floats) -> bool:
    """Whether a candidate is a column up to a shift and a factor."""
    centred = column - column.mean()
    others = found.values - found.values.mean(axis=0)
    similar = np.abs(centred @ others) / (np.linalg.norm(centred) * np.linalg.norm(others, axis=0))
    return bool(similar.max() > 1.0 - 1e-9)


@pytest.fixture(scope="module")
def found() -> Candidates:
    return candidates(elements_of("towers"))


def _liked(pattern: str) -> Floats:
    return np.where(_values(parse(pattern))[:, 0] > 0.0, 100.0, 0.0)


def test_equal_choices(found: Candidates):
    first = [f"Lot[Tower@1:{number}, Tower@2:{number}]" for number in range(3)]
    scores = sum((_liked(pattern) for pattern in first), np.zeros(64))
    adjacent = sum((_values(parse(f"*[Tower:{n} + Tower:{n}]"))[:, 0] for n in range(3)), np.zeros(64))
    equalities = {equality for scored in (scores, 10.0 * adjacent) for equality in find_equalities(TOWERS, scored)[0]}
    assert len(equalities) >= 2
    assert all(_has(found, _underlying(equality)) for equality in equalities)


def test_relations_of_draws(found: Candidates):
    storey, plinth, front = _values(*map(Draw, DRAWS)).T
    relations = {
        relation
        for level in (storey - plinth, front / storey, front - plinth)
        for relation in find_relations(TOWERS, 100.0 * (level > np.median(level)), DRAWS)[0]
    }
    assert {relation.logarithmic for relation in relations} == {True, False}
    assert all(_has(found, _underlying(relation)) for relation in relations)


def test_bounds(found: Candidates):
    storey, plinth, _ = _values(*map(Draw, DRAWS)).T
    bounds = find_thresholds(TOWERS, 100.0 * (plinth > 2.0), DRAWS)
    space = find_half_space(TOWERS, storey + plinth < 5.5, DRAWS)
    assert bounds
    assert space is not None
    assert all(_has(found, _underlying(feature)) for feature in (*bounds, space))


def test_sums_of_draws_where_they_are_used(found: Candidates):
    used = _values(READERS["plinth"][0])[:, 0] > 0.0
    storey, plinth, front = _values(*map(Draw, DRAWS)).T
    for level in (storey + plinth * used, storey + plinth * used - front):
        scores = np.where(np.abs(level - np.median(level)) < 0.4, 100.0, 0.0)
        feature = find_sum(TOWERS, scores, DRAWS, READERS)
        assert feature is not None
        assert _has(found, _underlying(feature.sum))


def test_totals_of_two_counts(found: Candidates):
    table = extract(list(TOWERS), Options(repeats="count"))
    features, counts = counted(table)
    level = _values(parse("Tower:0"), parse("Roof:1")).sum(axis=1)
    totals = [total_of(features, total.weights) for total in find_totals(counts, 100.0 * (level >= 3))]
    named = [Total(((parse("Tower:0"), 1), (parse("Roof:1"), -1))), *(t for t in totals if len(t.terms) == 2)]
    assert all(_has(found, _underlying(total)) for total in named)


def test_patterns_of_two_choices(found: Candidates):
    patterns = [
        pattern
        for liked in ("Tower:0 >> Roof:1", "*[Tower:0 + Tower:1]")
        for pattern in search_patterns(TOWERS, _liked(liked), conditions=1)
        if _num_choices(pattern) <= 2
    ]
    assert any(_num_choices(pattern) == 2 for pattern in patterns)
    assert all(_has(found, _underlying(pattern)) for pattern in patterns)


def test_presence(found: Candidates):
    assert all(_has(found, _underlying(Present(parse(text)))) for text in ("Roof", "Tower:2", "Gable"))


def _num_choices(pattern: Pattern) -> int:
    inner = (below for condition in pattern.below for below in condition.run)
    return bool(pattern.branch) + sum(map(_num_choices, inner))
