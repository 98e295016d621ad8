import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from grammarlab.learning.questions import between


@given(st.integers(0, 2**32 - 1), st.integers(1, 40), st.integers(0, 12), st.integers(0, 8))
def test_models_are_new_and_lie_between_the_scored_ones_nearest_to_the_bound(seed, pool, num_asked, num):
    random = np.random.default_rng(seed)
    margins = random.integers(-5, 6, pool) + random.choice([0.5, 0.25], pool)
    asked = random.permutation(pool)[:num_asked]
    chosen = between(margins, asked, num)
    assert len(chosen) == len(set(chosen)) <= num
    assert not set(chosen) & set(asked)
    known = margins[asked]
    for index in chosen:
        assert not ((known < 0) & (known >= margins[index])).any()
        assert not ((known >= 0) & (known <= margins[index])).any()


def test_a_bound_is_narrowed_by_a_constant_factor_each_round():
    values = np.random.default_rng(1).permutation(np.linspace(0, 1, 10_000))
    truth, asked = 0.31415, np.array([values.argmin(), values.argmax()])
    for number in range(1, 6):
        inside = values[asked] < truth
        low, high = values[asked[inside]].max(), values[asked[~inside]].min()
        assert high - low < 1.1 * 0.2 ** (number - 1) + 3e-4
        asked = np.concatenate([asked, between(values - (low + high) / 2, asked, 4)])
