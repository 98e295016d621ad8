"""Sessions of random grammars, tastes, persons and numbers of scores: learning is not worse than not learning."""

from benchmarks.measure_law import WORSE, session
from tests.cases import some


def test_random_sessions_are_not_worse_for_what_was_learned():
    sessions = [session(number, num_models=300) for number in some(range(1, 21, 2))]
    assert all(each.ratio <= WORSE for each in sessions), "\n".join(map(str, sessions))
