"""The page of how many scores persons need, from curves of an evaluation."""

import math

from docs.gen.persons import PAGE, PERSONS, divergence, left, needed, page, row
from grammarlab.evaluation.curves import Curve, Point
from grammarlab.runs.evaluate.curve_store import CurveRecord


def record(scenario: str, person: str, *divergences: float) -> CurveRecord:
    points = tuple(Point(8 * (index + 1), js, 0.0, 0) for index, js in enumerate(divergences))
    return CurveRecord(f"{scenario} {person}", scenario, "default", 0, 128, 0.5, Curve(points), person)


def test_a_taste_is_learned_from_where_no_more_than_a_tenth_is_left():
    good, bad = record("a", "exact", 0.5, 0.2, 0.05, 0.04), record("b", "exact", 0.5, 0.6, 0.6)
    lost = record("c", "exact", 0.5, 0.01, 0.6, 0.04)
    assert (needed(good), needed(lost), needed(bad)) == (24, 32, math.inf)
    assert (divergence(good, 24), divergence(good, 31), left(bad, 16)) == (0.05, 0.05, 1.2)
    assert row("exact", [good, bad]).endswith("| 0.6000 (b) | 1 of 2 |")


def test_the_page_tells_of_every_person_and_of_all_tastes():
    text = page({person: [record("a", person, 0.1, 0.01), record("b", person, 0.5, 0.6)] for person in PERSONS})
    for person in PERSONS:
        assert f"(`{person}`) needs more than 128 scores in the middle of 2 tastes; 1 of them are learned" in text
        assert f"| {person} | 0.5000 |" in text
    assert "evaluate a,b" in text
    assert PAGE.read_text().startswith(text.partition("![")[0])
