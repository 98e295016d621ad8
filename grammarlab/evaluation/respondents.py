"""Respondents, the error models of simulated persons: exact, coarse scale, noise, blunders, or a taste that is not one.

For a taste that changes, and for two people who score by turns, the first and the last factor of a scenario are the two
tastes. Such persons give one score to a design. The target is the later taste, or the mean of both.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from scipy.special import ndtri

from grammarlab.arrays import Floats, Ints
from grammarlab.preference.base import MAX_SCORE
from grammarlab.randomness import derived_seed, fold, root_keys, uniforms

_LANE = 5
"""Lane below a person's seed for the draws of answers."""
CHANGE = 60
"""Number of scores before a taste changes."""
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
    voices: Literal["one", "change", "turns"] = "one"
    """Whether there is one taste, one that changes, or two that take turns of one score."""

    @property
    def has_one_voice(self) -> bool:
        """Whether there is one taste."""
        return self.voices == "one"

    def taste(self, scores: Floats) -> Floats:
        """The scores that are to be learned, without errors and on any scale: [n, K], or [n, 1] for two voices.

        Args:
            scores: [n, K] true scores by each factor, 0 to 100.
        """
        if self.voices == "one":
            return scores
        return scores[:, -1:] if self.voices == "change" else (scores[:, :1] + scores[:, -1:]) / 2.0

    def spoken(self, scores: Floats, numbers: Ints) -> Floats:
        """The scores that are meant by answers, without errors: [k, K], or [k, 1] for two voices.

        Args:
            scores: [k, K] true scores by each factor, 0 to 100.
            numbers: [k] number of each answer of the person, from 0.
        """
        if self.voices == "one":
            return scores
        is_last = numbers >= CHANGE if self.voices == "change" else numbers % 2 == 1
        return np.where(is_last, scores[:, -1], scores[:, 0])[:, None]

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
        *(Respondent(f"changing{name}", noise, voices="change") for name, noise in (("", 0.0), ("_sd10", 10.0))),
        *(Respondent(f"two{name}", noise, voices="turns") for name, noise in (("", 0.0), ("_sd10", 10.0))),
    )
}
"""All respondents, by name."""
EXACT = RESPONDENTS["exact"]
