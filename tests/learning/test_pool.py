import pytest

from grammarlab.evaluation.pool import MOST_WIDER, WIDER, pool_sizes


@pytest.mark.parametrize("size", [1, 4, 5, 250, 5_000, 25_000, 25_005, 100_000, 1_000_000])
def test_a_wider_pool_begins_with_the_other_one_and_is_bounded(size):
    narrow, wide = pool_sizes(size), pool_sizes(size, wide=True)
    assert sum(narrow) == size
    assert wide[0] == narrow[0]
    assert narrow[1] <= wide[1] <= max(narrow[1], MOST_WIDER)
    assert wide[1] >= min(WIDER * narrow[1], MOST_WIDER)
