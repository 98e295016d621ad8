"""Learning is never worse than not learning: the grammar is kept as far as scores have no pattern."""

from dataclasses import dataclass

import numpy as np
import pytest

from grammarlab.arrays import Floats
from grammarlab.learning.targets.divergence import agreement
from grammarlab.preference import blended
from tests.cases import some

NUM_COLUMNS = 8
NUM_DESIGNS = 400


@dataclass(frozen=True)
class Case:
    """Scores of a person with a random taste."""

    designs: Floats
    values: Floats
    rows: Floats
    scores: Floats

    @classmethod
    def of(cls, seed: int) -> "Case":
        randomness = np.random.default_rng(seed)
        designs = (randomness.random((NUM_DESIGNS, NUM_COLUMNS)) < randomness.uniform(0.2, 0.8, NUM_COLUMNS)).astype(
            np.float64
        )
        parts = randomness.permutation(NUM_COLUMNS)[: randomness.integers(1, 4)]
        points = randomness.uniform(20.0, 100.0 / len(parts), len(parts))
        sums, all_of_them = designs[:, parts] @ points, points.sum() * designs[:, parts].min(axis=1)
        values = (sums, all_of_them, points.sum() * (designs[:, parts].sum(axis=1) % 2))[seed % 3]
        asked = randomness.permutation(NUM_DESIGNS)[
            : randomness.integers(1, 65) if seed % 2 else randomness.integers(1, 17)
        ]
        noise = (0.0, 10.0)[seed // 3 % 2] * randomness.normal(size=len(asked))
        return cls(designs, values, designs[asked], np.clip(values[asked] + noise, 0.0, 100.0))

    def ratio(self) -> float:
        """Divergence of the learned density from the true one, divided by that of the grammar."""
        weights = np.ones(NUM_DESIGNS)
        learned = blended.fit(self.rows, self.scores).for_density(self.designs, weights).predict(self.designs).mean
        same = np.ones(NUM_DESIGNS)
        return agreement(self.values, learned, weights).js / agreement(self.values, same, weights).js


def test_19_of_20_learned_densities_are_at_most_a_twentieth_farther_than_the_grammar():
    ratios = np.array([Case.of(seed).ratio() for seed in some(range(25))])
    assert np.count_nonzero(ratios > 1.05) <= max(0.05 * len(ratios), 1.0), ratios.round(2)
    assert np.count_nonzero(ratios < 0.5) >= len(ratios) // 4


@pytest.mark.parametrize("num", some([12, 40]))
def test_scores_without_a_pattern_keep_the_grammar(num):
    kept = []
    for seed in range(10):
        case = Case.of(seed)
        randomness = np.random.default_rng(100 + seed)
        asked = randomness.permutation(NUM_DESIGNS)[:num]
        scores = randomness.permutation(case.values[asked])
        if np.ptp(scores) > 0.0:
            kept.append(blended.fit(case.designs[asked], scores).unexplained)
    assert min(kept) > 0.5, kept
    assert np.median(kept) > 0.95
