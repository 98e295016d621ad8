"""The common subspace of several graphs."""

import numpy as np

from grammarlab.matching.paper_loop import laplacian, lowest, merged, similarity

BLOCKS = np.array(np.kron(np.eye(3), np.ones((4, 4))) + 0.05, dtype=np.float64)


def test_equal_graphs_have_their_own_subspace_in_common():
    alone, common = lowest(laplacian(BLOCKS), 3), merged(np.stack([BLOCKS, BLOCKS]), 3)
    assert np.allclose(alone @ alone.T, common @ common.T, atol=1e-8)


def test_a_graph_of_noise_does_not_hide_what_others_agree_in():
    noise = np.random.default_rng(0).uniform(size=(12, 12))
    near = similarity(merged(np.stack([BLOCKS, BLOCKS, (noise + noise.T) / 2]), 3))
    inside = np.kron(np.eye(3), np.ones((4, 4))) - np.eye(12) > 0
    assert near[inside].min() > near[~inside].max()
