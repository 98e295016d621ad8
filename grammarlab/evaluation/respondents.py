"""How simulated persons answer: exactly, on a coarse scale, with noise, or now and then at random."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtri

from grammarlab.preference.base import MAX_SCORE
from grammarlab.randomness import derived_seed, fold, root_keys, uniforms

Floats = NDArray[np.float64]

_LANE = 5
"""Place below a person's seed that answers have their draws from."""
_HALF_STEP = 2.0**-54
"""Half of what lies between two uniform draws: added to them, none is 0 or 1."""


@dataclass(frozen=True, slots=True)
class Respondent:
    """How somebody with a preference scores models."""

    name: str
    noise: float = 0.0
    """Standard deviation of what is added to each score, in points, >= 0; the sum is clipped to 0-100."""
    step: float = 0.0
    """Scores are rounded to multiples of it, halves up; 0 for any score. It divides 100."""
    blunders: float = 0.0
    """Share of the scores, 0 to 1, that are drawn uniformly from 0-100 whatever the model."""

    def truth(self, scores: Floats) -> Floats:
        """What somebody means who likes models that much, on their scale: what there is to learn.

        Args:
            scores: 0 to 100, of any shape.
        """
        return np.floor(scores / self.step + 0.5) * self.step if self.step else scores

    def answers(self, scores: Floats, seed: int, first: int) -> Floats:
        """What is said about models, [k, K] for K factors.

        The draws of the n-th answer of a person are a function of (seed, n): asked about a model again, the person
        answers afresh, and a repeated run gets the same answers.

        Args:
            scores: [k, K] how much the models are liked, 0 to 100.
            seed: of the person, 0 <= seed < 2**64.
            first: how many answers the person has given before, >= 0.
        """
        num, factors = scores.shape
        keys = root_keys(derived_seed(seed, _LANE), np.arange(first, first + num))
        keys = fold(np.repeat(keys, factors), np.tile(np.arange(factors), num))
        noise, blunders, blunder = (uniforms(keys, site).reshape(scores.shape) for site in range(3))
        said = np.clip(scores + self.noise * ndtri(noise + _HALF_STEP), 0.0, MAX_SCORE)
        return self.truth(np.where(blunders < self.blunders, MAX_SCORE * blunder, said))


RESPONDENTS = {
    person.name: person
    for person in (
        Respondent("exact"),
        Respondent("stars", step=25.0),
        *(Respondent(f"sd{points}", noise=points) for points in (5, 10, 20)),
        *(Respondent(f"blunders{percent}", blunders=percent / 100) for percent in (5, 10)),
    )
}
"""All there are, by name."""
EXACT = RESPONDENTS["exact"]
