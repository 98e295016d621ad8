from hypothesis import given
from hypothesis import strategies as st

from grammarlab.evaluation.curves import Curve, Point, summarize

CURVES = st.lists(st.floats(0, 0.7), max_size=12).map(
    lambda values: Curve(tuple(Point(16 * (k + 1), js, 0.0, k) for k, js in enumerate(values)))
)


@given(CURVES, st.floats(0, 0.7))
def test_from_the_number_of_labels_where_a_curve_stays_below_no_round_is_above(curve, js):
    stays, first = curve.labels_until_below(js), curve.labels_to(js)
    above = [point.labels for point in curve.points if point.js > js]
    if stays is None:
        assert not curve.points or curve.points[-1].js > js
    else:
        assert first is not None
        assert first <= stays
        assert all(labels < stays for labels in above)
        assert above[-1:] in ([], [stays - 16])


@given(CURVES, st.floats(0, 0.7))
def test_the_first_round_that_is_close_is_found(curve, js):
    close = [point.labels for point in curve.points if point.js <= js]
    assert curve.labels_to(js) == (close[0] if close else None)


@given(st.lists(st.integers(0, 1), max_size=12), st.integers(1, 9))
def test_counting_from_the_first_liked_model_leaves_out_the_rounds_that_showed_none(liked, batch):
    points = [Point(batch * (k + 1), 0.1 / (k + 1), 0.0, sum(liked[: k + 1])) for k in range(len(liked))]
    curve = Curve(tuple(points))
    rounds_before = liked.index(1) if any(liked) else len(liked)
    later = curve.since_first_liked()
    assert [point.js for point in later.points] == [point.js for point in points[rounds_before:]]
    assert [point.labels for point in later.points] == [batch * (k + 1) for k in range(len(points) - rounds_before)]
    assert curve.labels_before_first_liked() == (batch * rounds_before if any(liked) else None)
    for js in (0.2, 0.05, 0.02):
        close = [point.labels - batch * rounds_before for point in points[rounds_before:] if point.js <= js]
        assert later.labels_to(js) == (close[0] if close else None)


def test_all_labels_of_the_round_that_shows_the_first_liked_model_count():
    curve = Curve((Point(8, 0.3, 0.0, 0), Point(16, 0.001, 0.9, 1)))
    assert (curve.labels_before_first_liked(), curve.since_first_liked().labels_to(), curve.labels_to()) == (8, 8, 16)
    assert curve.until(8).since_first_liked() == Curve(())


def test_a_person_who_never_saw_a_liked_model_reached_nothing_however_close_the_density():
    curve = Curve((Point(8, 0.0, 0.0, 0),))
    assert (curve.labels_to(), curve.labels_until_below()) == (8, 8)
    assert (curve.since_first_liked().labels_to(), curve.since_first_liked().labels_until_below()) == (None, None)


@given(CURVES, st.integers(0, 200))
def test_a_curve_is_a_staircase_that_begins_before_the_first_round(curve, labels):
    known = [point.js for point in curve.until(labels).points]
    assert curve.js_at(labels, before=0.3) == (known[-1] if known else 0.3)


def test_a_run_that_never_gets_there_counts_as_later_than_all_others():
    summary = summarize([48, None, 32])
    assert (summary.median, summary.lowest, summary.highest, summary.reached, summary.runs) == (48.0, 32, None, 2, 3)
    assert summarize([48, 32]).median == 40.0
    assert summarize([48, None]).median is None
    assert summarize([None]).lowest is None
    assert summarize([]).median is None
