"""Common parameters of elements by the paper's threshold: the eight rectangles of its Figure 5.2."""

import numpy as np

from grammarlab.matching.match_assembly import couplings, replicas

SIZES = np.array([[1.0, 1.5], [1.0, 1.5], [1.0, 1.9], [1.3, 1.9], [1.3, 1.9], [1.3, 1.5], [0.8, 2.2], [0.8, 1.5]])
THRESHOLD = 0.01


def test_parameters_are_coupled_exactly_where_they_are_shared():
    owner = np.zeros(8, dtype=np.int64)
    coupled = couplings(owner, SIZES, np.ones((1, 2)), THRESHOLD)
    for axis in (0, 1):
        shared = SIZES[:, None, axis] == SIZES[None, :, axis]
        assert np.array_equal(coupled[0, axis], shared & ~np.eye(8, dtype=bool))


def test_only_replicas_are_coupled_in_templates_that_they_do_not_use():
    owner = np.array([0, 0, 0, 1, 1, 1, 1, 1])
    coupled = couplings(owner, SIZES, np.ones((2, 2)), THRESHOLD)
    replica = replicas(owner, SIZES, THRESHOLD)
    assert replica.tolist() == [0, 0, 1, 2, 2, 3, 4, 5]
    same = (replica[:, None] == replica[None]) & ~np.eye(8, dtype=bool)
    for template, axis in np.ndindex(2, 2):
        beside = ~(owner[:, None] == template) | ~(owner[None] == template)
        assert np.array_equal(coupled[template, axis] * beside, same & beside)
