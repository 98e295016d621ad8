"""The errors of a person, found together with trees by evidence from several starts.

Trees found under much noise stay small, trees found under little noise explain the noise.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from typing import Generic, TypeVar

import numpy as np

from grammarlab.arrays import FEW, Ints
from grammarlab.preference.base import HOPELESS
from grammarlab.preference.growth.part_evidence import Evidence
from grammarlab.preference.growth.split_columns import SplitColumns
from grammarlab.preference.growth.tree_growth import Others, Tree, TreeGrowth
from grammarlab.preference.person import PERSONS, Person

E = TypeVar("E", bound=Evidence)


@dataclass(frozen=True, eq=False)
class Found(Generic[E]):
    """Trees with the errors that they were grown for."""

    evidence: E
    """The scores and the errors."""
    trees: list[Tree]
    """The most likely one first."""
    growth: TreeGrowth
    """What they grew from, which has the best cuts of their nodes."""

    @property
    def log_evidence(self) -> float:
        """Evidence of all trees together, less the price of the errors, in nats."""
        return float(np.logaddexp.reduce([tree.log_posterior for tree in self.trees])) - self.evidence.person.price


def search(columns: SplitColumns, evidence: E, persons: Sequence[Person], others: Others | None = None) -> Found[E]:
    """The trees of some scores with the most likely person.

    Args:
        columns: what the scores may be split by.
        evidence: the scores, for any person.
        persons: errors that the search starts with, those with more noise first.
        others: trees that were found otherwise.
    """

    @cache
    def growth_of(person: Person) -> TreeGrowth:
        # Sketches and trees of one person share most of their nodes.
        return TreeGrowth(columns, evidence.for_person(person))

    def sketched(person: Person) -> Found[E]:
        return Found(evidence.for_person(person), growth_of(person).sketches(others), growth_of(person))

    best = sketched(persons[0])
    for person in persons[1:]:
        found = sketched(person)
        # Trees found under less noise would only be larger.
        if found.log_evidence < best.log_evidence - HOPELESS:
            break
        best = max(best, found, key=lambda item: item.log_evidence)
    tried = set[Person]()
    for _ in range(FEW):
        likely = _most_likely(best)
        if likely in tried:
            break
        tried.add(likely)
        found = Found(evidence.for_person(likely), growth_of(likely).trees(others), growth_of(likely))
        best = max(best, found, key=lambda item: item.log_evidence)
    return best


def _most_likely(found: Found[E]) -> Person:
    divisions = [list(tree.cells()) for tree in found.trees]
    of_splits = [
        tree.log_posterior - sum(found.evidence.of_labels(cell) for cell in cells)
        for tree, cells in zip(found.trees, divisions, strict=True)
    ]
    return most_likely(found.evidence, divisions, of_splits)


def most_likely(evidence: Evidence, divisions: Sequence[Sequence[Ints]], of_splits: Sequence[float]) -> Person:
    """The person with the highest posterior for some trees together.

    Args:
        evidence: the scores, for any person.
        divisions: the labels of each cell of each tree.
        of_splits: log-prior of the splits of each tree, in nats.
    """
    # Trees share cells, whose evidence is found once.
    different = {cell.tobytes(): cell for cells in divisions for cell in cells}
    place = {key: index for index, key in enumerate(different)}
    members = [np.array([place[cell.tobytes()] for cell in cells]) for cells in divisions]
    inside = np.zeros((len(different), len(evidence.scores)))
    for row, cell in zip(inside, different.values(), strict=True):
        row[cell] = 1.0

    def posterior(person: Person) -> float:
        erring = evidence.for_person(person)
        of_cells = erring.of_sums(inside @ erring.terms)
        of_trees = [prior + of_cells[index].sum() for prior, index in zip(of_splits, members, strict=True)]
        return float(np.logaddexp.reduce(of_trees)) - person.price

    return max(PERSONS, key=posterior)
