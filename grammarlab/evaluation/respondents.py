"""Respondents, the error models of simulated persons: exact, coarse scale, noise, or blunders."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.special import ndtri

from grammarlab.arrays import Floats
from grammarlab.preference.base import MAX_SCORE
from grammarlab.randomness import derived_seed, fold, root_keys, uniforms

_LANE = 5
"""Lane below a person's seed for the draws of answers."""
_HALF_STEP = 2.0**-54
"""Half of the step of uniform draws; with it added, none is 0 or 1."""


@dataclass(frozen=True, slots=True)
class Respondent:
    """Error model of scores."""

    name: str
    noise: float = 0.0
    """Standard deviation of the noise of each score, in points, >= 0; the sum is clipped to 0-100."""
    step: float = 0.0
    """Scores are rounded to multiples of it, halves up; 0 for any score. It divides 100."""
    blunders: float = 0.0
    """Share of the scores, 0 to 1, that are drawn uniformly from 0-100 for any model."""

    def truth(self, scores: Floats) -> Floats:
        """Scores on the scale of the respondent without errors: the target of learning.

        Args:
            scores: 0 to 100, of any shape.
        """
        return np.floor(scores / self.step + 0.5) * self.step if self.step else scores

    def answers(self, scores: Floats, seed: int, first: int) -> Floats:
        """Scores of models with errors, [k, K] for K factors.

        The draws of the n-th answer of a person are a function of (seed, n): a second answer about a model has new
        noise, and a repeated run gets the same answers.

        Args:
            scores: [k, K] true scores of the models, 0 to 100.
            seed: seed of the person, 0 <= seed < 2**64.
            first: number of earlier answers of the person, >= 0.
        """
        num, factors = scores.shape
        keys = root_keys(derived_seed(seed, _LANE), np.arange(first, first + num))
        keys = fold(np.repeat(keys, factors), np.tile(np.arange(factors), num))
        noise, blunders, blunder = (uniforms(keys, site).reshape(scores.shape) for site in range(3))
        noisy = np.clip(scores + self.noise * ndtri(noise + _HALF_STEP), 0.0, MAX_SCORE)
        return self.truth(np.where(blunders < self.blunders, MAX_SCORE * blunder, noisy))


RESPONDENTS = {
    person.name: person
    for person in (
        Respondent("exact"),
        Respondent("stars", step=25.0),
        *(Respondent(f"sd{points}", noise=points) for points in (5, 10, 20)),
        *(Respondent(f"blunders{percent}", blunders=percent / 100) for percent in (5, 10)),
    )
}
"""All respondents, by name."""
EXACT = RESPONDENTS["exact"]
