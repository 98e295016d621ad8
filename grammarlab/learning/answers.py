"""What somebody said about designs, whoever it was."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from grammarlab.errors import UsageError
from grammarlab.learning.addresses import Address
from grammarlab.preference.labels import Labels

MAX_DESIGNS = 20_000
"""Different designs that labels may be about."""


@dataclass(frozen=True)
class Answers:
    """Scores of designs for one factor, in the order in which they were given."""

    factor: str
    designs: tuple[Address, ...]
    """[n] they may repeat."""
    scores: NDArray[np.float64]
    """[n] 0 to 100."""

    @property
    def is_liked(self) -> bool:
        """Whether anything has a score above 0."""
        return bool(np.any(self.scores > 0.0))

    def __add__(self, other: Answers) -> Answers:
        return replace(self, designs=self.designs + other.designs, scores=np.append(self.scores, other.scores))


def answers_of(labels: Labels, hashes: tuple[str, str]) -> tuple[Answers, ...]:
    """Labels as answers, one for each factor.

    Args:
        labels: of designs of a space, or of its proposal.
        hashes: `AbstractDesignSpace.hashes` of what they should be about.

    Raises:
        UsageError: when there are none, they are about too many designs or another grammar, or nothing is liked; says
            how to go on.
    """
    if not len(labels):
        raise UsageError("there are no labels: score some models first, such as with grammarlab label.")
    foreign = [label.grammar for label in labels if label.grammar not in hashes]
    if foreign:
        raise UsageError(
            f"{len(foreign):,} of {len(labels):,} labels are about another grammar: expected {hashes[0][:16]}…, found "
            f"{foreign[0][:16]}…. The rule file has changed since the models were scored, or it is another one. Learn "
            "from the rule file that was scored (the beginning of its SHA-256 tells it), or score models of this one "
            "anew."
        )
    total = len({label.address for label in labels})
    if total > MAX_DESIGNS:
        raise UsageError(f"the labels are about {total:,} models; {MAX_DESIGNS:,} can be learned from. Split the file.")
    if not labels.scores.any():
        raise UsageError(
            f"all {len(labels):,} scores of {', '.join(map(repr, labels.factors))} are 0, so nothing is liked and "
            "there is nothing to sample: score at least one model above 0."
        )
    return tuple(_of_factor(factor, labels.of(factor), hashes) for factor in labels.factors)


def _of_factor(factor: str, labels: Labels, hashes: tuple[str, str]) -> Answers:
    return Answers(factor, tuple(Address.of(label, hashes) for label in labels), labels.scores)
