"""Groups of things that refer to each other."""

from hypothesis import given
from hypothesis import strategies as st

from grammarlab.language.call_order import groups

GRAPHS = st.integers(1, 9).flatmap(
    lambda n: st.lists(st.lists(st.integers(0, n - 1), max_size=n), min_size=n, max_size=n)
)


@given(GRAPHS)
def test_a_group_holds_what_leads_to_each_other_and_comes_after_what_it_leads_to(lists):
    calls = dict(enumerate(lists))
    reached = {key: {key, *callees} for key, callees in calls.items()}
    for middle in calls:
        for key in calls:
            if middle in reached[key]:
                reached[key] |= reached[middle]
    found = groups(calls)
    assert sorted(key for group in found for key in group) == sorted(calls)
    for place, group in enumerate(found):
        together = {key for key in calls if key in reached[group[0]] and group[0] in reached[key]}
        assert list(group) == sorted(together)
        before = {key for earlier in found[:place] for key in earlier}
        assert {callee for key in group for callee in calls[key]} <= before | together


def test_a_chain_as_long_as_a_large_grammar_needs_no_recursion():
    assert groups({i: [i + 1] if i < 20_000 else [] for i in range(20_001)})[0] == (20_000,)
