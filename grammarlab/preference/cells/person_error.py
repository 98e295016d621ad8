"""The error of a person, found together with trees by evidence from several starts.

Trees found under much noise stay small, trees found under little noise explain the noise.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from grammarlab.arrays import Floats
from grammarlab.preference.cells.cells import ScoreCells, grid_of, levels_of
from grammarlab.preference.cells.split_columns import SplitColumns
from grammarlab.preference.cells.tree_growth import Tree, TreeGrowth, posterior_shares
from grammarlab.preference.person import PERSONS, START_PERSONS, Intervals, Person

_MAX_PERSONS = 3
"""Largest number of times that errors are improved and trees grown again."""

_HOPELESS = 12.0
"""Loss in nats by less noise with which even less is not tried."""


class Found(NamedTuple):
    """Trees with the errors that they were grown for."""

    cells: ScoreCells
    """The labels and the errors."""
    trees: list[Tree]
    """The most likely one first."""

    @property
    def log_evidence(self) -> float:
        """Evidence of all trees together, less the price of the errors, in nats."""
        return float(np.logaddexp.reduce([tree.log_posterior for tree in self.trees])) - self.cells.person.price

    def with_levels(self) -> ScoreCells:
        """The labels, and the values that cells seem to have."""
        shares = posterior_shares(self.trees).tolist()
        divisions = [(share, tuple(tree.cells())) for share, tree in zip(shares, self.trees, strict=True)]
        return replace(self.cells, levels=levels_of(self.cells, divisions))


def find_error(
    columns: SplitColumns,
    scores: Floats,
    intervals: Intervals | None,
    rows: Floats,
    candidates: Sequence[Tree] = (),
) -> ScoreCells:
    """The labels with the most likely person, and the values that cells seem to have.

    Args:
        columns: what the labels may be split by.
        scores: [n] 0-100.
        intervals: [n] intervals of the labels, if they are not scores.
        rows: [n, F] rows of the labels.
        candidates: trees of the labels that were found otherwise.
    """
    first = ScoreCells(scores, grid_of(scores), *START_PERSONS[0], intervals=intervals)

    def sketched(person: Person) -> Found:
        growth = TreeGrowth(columns, first.for_person(person))
        return Found(growth.cells, growth.sketches(candidates, rows))

    best = sketched(START_PERSONS[0])
    for person in START_PERSONS[1:]:
        found = sketched(person)
        # Trees found under less noise would only be larger.
        if found.log_evidence < best.log_evidence - _HOPELESS:
            break
        best = max(best, found, key=lambda item: item.log_evidence)
    tried = set[Person]()
    for _ in range(_MAX_PERSONS):
        likely = _most_likely(best)
        if likely in tried:
            break
        tried.add(likely)
        growth = TreeGrowth(columns, first.for_person(likely))
        best = max(best, Found(growth.cells, growth.trees(candidates, rows)), key=lambda item: item.log_evidence)
    return best.with_levels()


def _most_likely(found: Found) -> Person:
    """The person with the highest posterior for all trees together."""
    cells, trees = found
    divisions = [list(tree.cells()) for tree in trees]
    # Trees share cells, whose evidence is found once.
    different = {cell.tobytes(): cell for parts in divisions for cell in parts}
    place = {key: index for index, key in enumerate(different)}
    members = [np.array([place[cell.tobytes()] for cell in parts]) for parts in divisions]
    inside = np.zeros((len(different), len(cells.scores)), dtype=np.float32)
    for row, cell in zip(inside, different.values(), strict=True):
        row[cell] = 1.0
    of_cells = cells.log_evidence(inside)
    of_splits = [tree.log_posterior - of_cells[index].sum() for tree, index in zip(trees, members, strict=True)]

    def posterior(person: Person) -> float:
        evidence = cells.for_person(person).log_evidence(inside)
        of_trees = [prior + evidence[index].sum() for prior, index in zip(of_splits, members, strict=True)]
        return float(np.logaddexp.reduce(of_trees)) - person.price

    return max(PERSONS, key=posterior)
