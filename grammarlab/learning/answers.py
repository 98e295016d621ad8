"""Answers of any respondent: labels of designs."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from grammarlab.errors import UsageError
from grammarlab.learning.designs.addresses import Address
from grammarlab.preference.labels import COMPARISONS, Kind, Labels

MAX_DESIGNS = 20_000
"""Largest number of different labelled designs."""


@dataclass(frozen=True)
class Answers:
    """Answers for one factor, in the order of the labels."""

    factor: str
    designs: tuple[Address, ...]
    """[n] labelled designs, with repeats."""
    scores: NDArray[np.float64]
    """[n] 0 to 100."""
    kinds: tuple[Kind, ...] = ()
    """[n] kind of each label; none if all are scores of 0 to 100."""
    others: tuple[Address | None, ...] = ()
    """[n] the other designs of comparisons; none without kinds."""

    @property
    def is_liked(self) -> bool:
        """Whether anything has a score above 0 or is preferred to something."""
        return any(score > 0.0 and kind != "tie" for _, score, kind, _ in self._rows())

    @property
    def scored(self) -> Answers:
        """The answers about single designs."""
        if not self.kinds:
            return self
        is_single = np.array([kind not in COMPARISONS for kind in self.kinds], dtype=bool)
        designs = tuple(design for design, single in zip(self.designs, is_single.tolist(), strict=True) if single)
        return Answers(self.factor, designs, self.scores[is_single])

    @property
    def mentioned(self) -> tuple[Address, ...]:
        """All designs with answers."""
        return self.designs + tuple(other for other in self.others if other is not None)

    def since(self, number: int) -> Answers:
        """The answers from a number on, 0 for all."""
        designs, scores = self.designs[number:], self.scores[number:]
        return replace(self, designs=designs, scores=scores, kinds=self.kinds[number:], others=self.others[number:])

    def __add__(self, other: Answers) -> Answers:
        both = replace(self, designs=self.designs + other.designs, scores=np.append(self.scores, other.scores))
        if not self.kinds and not other.kinds:
            return both
        rows = (*self._rows(), *other._rows())
        return replace(both, kinds=tuple(row[2] for row in rows), others=tuple(row[3] for row in rows))

    def _rows(self) -> Iterator[tuple[Address, float, Kind, Address | None]]:
        num = len(self.designs)
        kinds: tuple[Kind, ...] = self.kinds or ("score",) * num
        others: tuple[Address | None, ...] = self.others or (None,) * num
        return zip(self.designs, self.scores.tolist(), kinds, others, strict=True)


def answers_of(labels: Labels, hashes: tuple[str, str]) -> tuple[Answers, ...]:
    """Labels as answers, one for each factor.

    Args:
        labels: scores and comparisons of designs of a space, or of its proposal.
        hashes: `AbstractDesignSpace.hashes` of what they should be about.

    Raises:
        UsageError: If there are none, they belong to too many designs or another grammar, or nothing is liked; it says
            how to go on.
    """
    if not len(labels):
        raise UsageError("there are no labels: score some models first, such as with grammarlab label.")
    addresses = [address for label in labels for address in (label.address, label.other_address) if address is not None]
    foreign = [address[0] for address in addresses if address[0] not in hashes]
    if foreign:
        raise UsageError(
            f"{len(foreign):,} of {len(labels):,} labels are about another grammar: expected {hashes[0][:16]}…, found "
            f"{foreign[0][:16]}…. The file has changed since the models were scored, it is another one, or they "
            "were scored with another start rule, style, library or other values of attributes. Learn from the "
            "file that was scored (the beginning of its SHA-256 tells it), or score models of this one anew."
        )
    total = len(set(addresses))
    if total > MAX_DESIGNS:
        raise UsageError(f"the labels are about {total:,} models; {MAX_DESIGNS:,} can be learned from. Split the file.")
    answers = tuple(answers_for(factor, labels, hashes) for factor in labels.factors)
    if not any(factor_answers.is_liked for factor_answers in answers):
        scored = sum(len(factor_answers.scored.scores) for factor_answers in answers)
        every = f"scores of {', '.join(map(repr, labels.factors))} are 0" if scored else "comparisons are ties"
        raise UsageError(
            f"all {scored or len(labels):,} {every}, so nothing is liked and there is nothing to sample: score at "
            "least one model above 0."
        )
    return answers


def answers_for(factor: str, labels: Labels, hashes: tuple[str, str]) -> Answers:
    """Answers from labels for one factor, even if nothing is liked; see `answers_of`."""
    labels = labels.of(factor)
    answers = Answers(factor, tuple(Address.of(label, hashes) for label in labels), labels.scores)
    if all(label.kind == "score" for label in labels):
        return answers
    others = tuple(Address.of_other(label, hashes) for label in labels)
    return replace(answers, kinds=tuple(label.kind for label in labels), others=others)
