"""What can end, against the definition of it."""

from hypothesis import given
from hypothesis import strategies as st

from grammarlab.language.checking.flow import _grow

KEYS = [(name, 0) for name in "abcdef"]
ways = st.lists(st.frozensets(st.sampled_from([*KEYS, ("elsewhere", 0)]), max_size=3), min_size=1, max_size=3)


@given(st.dictionaries(st.sampled_from(KEYS), st.lists(ways, min_size=1, max_size=2)))
def test_a_definition_can_end_when_all_that_one_way_needs_can(needs):
    found = set()
    _grow(found, needs)
    expected, before = set(), None
    while before != expected:
        before = set(expected)
        expected |= {
            key
            for key, choices in needs.items()
            if any({other for other in way if other in needs} <= before for ways in choices for way in ways)
        }
    assert found == expected
