"""What trees are grown for: the evidence of parts of some scores."""

from __future__ import annotations

from typing import Protocol, Self

from grammarlab.arrays import Floats, Ints
from grammarlab.preference.person import Person


class Evidence(Protocol):
    """Evidence of parts of n scores, for a person with known errors."""

    @property
    def scores(self) -> Floats:
        """[n] 0-100."""
        ...

    @property
    def person(self) -> Person:
        """The errors."""
        ...

    @property
    def terms(self) -> Floats:
        """[n, W] terms of the scores, whose sums over a part give its evidence."""
        ...

    def of_sums(self, sums: Floats) -> Floats:
        """[...] log-evidence of parts from the sums [..., W] of their terms; an empty part has 0."""
        ...

    def of_labels(self, labels: Ints) -> float:
        """Log-evidence of the scores of some labels."""
        ...

    def best_possible(self, labels: Ints) -> float:
        """Upper bound on the evidence of divisions of some labels."""
        ...

    def for_person(self, person: Person) -> Self:
        """Evidence of the same scores for another person."""
        ...
