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
