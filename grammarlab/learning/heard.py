"""Which answers of a person count, and with which scores: their order may show a change of taste, or two people.

After a change of taste, the later answers count. If two people score by turns, each design counts with the mean of its
score and of what the other one gives to such designs: the taste that both of them have together.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from grammarlab.arrays import Floats
from grammarlab.learning.answers import Answers
from grammarlab.preference.judge.labelled_columns import selected
from grammarlab.preference.judge.voices import Division, two_voices
from grammarlab.preference.labels import COMPARISONS


@dataclass(frozen=True)
class Heard:
    """What is learned from the answers for one factor."""

    answers: Answers
    num_answers: int
    """Number of all answers."""
    division: Division | None = None
    """Two voices in the scores; None for one."""

    def __str__(self) -> str:
        """A sentence about two voices; empty for one."""
        if self.division is None:
            return ""
        if self.division.kind == "change":
            return f"Your scores before no. {self.division.number + 1} contradict the later ones; the later ones count."
        return "These scores look like those of two people who disagree; what is learned is between them."


def heard(answers: Answers, rows: Floats, prices: Floats) -> Heard:
    """What is learned from answers for one factor.

    Args:
        answers: all answers, in the order in which they were given, at least one of them about a single design.
        rows: [n, F] rows of the designs of those about single designs.
        prices: [C] description length of each of the last columns in nats; those before are known.
    """
    scored, num = answers.scored, len(answers.designs)
    chosen = selected(scored.scores)
    columns, varies = rows[chosen], np.ptp(rows[chosen], axis=0) > 0.0
    known = np.full(rows.shape[1] - len(prices), np.log(max(np.count_nonzero(varies), 1)))
    every_price = np.log(2.0) + np.append(known, prices)
    found = two_voices(columns[:, varies], every_price[varies], scored.scores[chosen])
    if found is None:
        return Heard(answers, num)
    if found.division.kind == "turns":
        scores = scored.scores.copy()
        scores[chosen] = found.agreed
        return Heard(replace(scored, scores=scores), num, found.division)
    number = int(chosen[found.division.number])
    singles = [
        index for index, kind in enumerate(answers.kinds or ("score",) * len(scored.designs)) if kind not in COMPARISONS
    ]
    later = answers.since(singles[number])
    # Nothing can be learned from a voice that likes nothing.
    return Heard(later, num, Division.at(number, len(scored.scores))) if later.is_liked else Heard(answers, num)
