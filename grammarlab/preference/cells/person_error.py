"""The error of a person, found by evidence from several starts.

Trees found under much noise stay small, trees found under little noise explain the noise.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from grammarlab.arrays import Floats, Ints
from grammarlab.preference.base import MANY_LABELS
from grammarlab.preference.cells.cells import ScoreCells, grid_of, levels_of
from grammarlab.preference.cells.splits import Splits
from grammarlab.preference.cells.tree_growth import Growth, Tree, grow, replanted
from grammarlab.preference.person import (
    PERSONS,
    PRICE_OF_BLUNDERS,
    START_BLUNDERS,
    START_NOISES,
    USUAL_BLUNDERS,
    Intervals,
    Person,
)

_LARGE_NOISE = 7.5
"""Noise of many labels in points, found from other beginnings, from which the smallest beginning is left out: its
trees explain all noise, are large, and are then unlikely. With few labels, only it finds some tastes, such as parity.
"""
_MAX_ROUNDS = 3
"""Largest number of rounds per start, in which trees and error model are improved in turns."""
_NUM_SKETCHES = 4
"""Number of trees per round."""
_NUM_BESIDE = 2
"""Number of trees per round beside trees that were found otherwise."""
_GUIDE = Person(START_NOISES[0], USUAL_BLUNDERS)
"""The person of the first guide."""
LOW_TEMPERATURE = 0.5
"""Low temperature of draws of splits."""
_TEMPERATURE = 3.0
"""Shares of trees are their posteriors to the power of one over this, since the found trees are only some of all."""


class Start(NamedTuple):
    """The best of several starts."""

    cells: ScoreCells
    """The labels and the error model."""
    guides: tuple[ScoreCells, ...]
    """Labels and error models with more noise, which guide the draws of splits."""
    tree: Tree
    """The most likely tree."""

    def refined(self, splits: Splits, rows: Floats) -> Start:
        """The same with other splits of the same rows [n, F], among them those of the tree."""
        cells, *guides = (replace(cells, splits=splits) for cells in (self.cells, *self.guides))
        return Start(cells, tuple(guides), replanted(cells, self.tree, rows, self.tree.labels))


def find_error(
    splits: Splits,
    scores: Floats,
    intervals: Intervals | None,
    randomness: np.random.Generator,
    rows: Floats,
    candidates: Sequence[Tree] = (),
) -> Start:
    """The most likely error model with its most likely tree.

    Args:
        splits: splits of the labelled rows.
        scores: [n] 0-100.
        intervals: [n] intervals of the labels, if they are not scores.
        randomness: draws splits.
        rows: [n, F] rows of the labels.
        candidates: trees of the labels that were found otherwise.
    """
    grid, every = grid_of(scores), np.arange(len(scores))
    first = ScoreCells(
        splits=splits, scores=scores, grid=grid, noise=START_NOISES[0], blunders=START_BLUNDERS, intervals=intervals
    )
    guides = guides_of(first)
    best, highest, most_likely = guides[0], -np.inf, Tree(every, -np.inf)
    visited, many = set[Person](), len(scores) > MANY_LABELS
    for noise in START_NOISES:
        if many and noise == START_NOISES[-1] and best.noise >= _LARGE_NOISE:
            break
        cells, visited = replace(first, noise=noise), visited if many else set[Person]()
        for _ in range(enough(_MAX_ROUNDS, scores)):
            growths = sketching(guides)[: _NUM_BESIDE if candidates else None]
            trees = [grow(cells, every, growth, randomness) for growth in growths]
            trees += [replanted(cells, tree, rows, every) for tree in candidates]
            tree = max(trees, key=lambda tree: tree.log_posterior)
            posterior = tree.log_posterior - PRICE_OF_BLUNDERS * cells.blunders
            if posterior > highest:
                best, highest, most_likely = cells, posterior, tree
            divisions = [
                (float(share), tuple(tree.cells())) for share, tree in zip(posterior_shares(trees), trees, strict=True)
            ]
            likely = _most_likely(cells, divisions)
            if likely in visited:
                break
            visited.add(likely)
            cells = replace(cells, noise=likely.noise, blunders=likely.blunders, levels=levels_of(cells, divisions))
    return Start(best, guides, most_likely)


def _most_likely(cells: ScoreCells, divisions: Sequence[tuple[float, Sequence[Ints]]]) -> Person:
    """The person with the highest posterior for the two most likely divisions."""
    top = sorted(divisions, key=lambda item: -item[0])[:2]
    every = np.arange(len(cells.scores))
    members = []
    for share, parts in top:
        inside = np.zeros((len(parts), len(every)), dtype=np.float32)
        for row, cell in enumerate(parts):
            inside[row, cell] = 1.0
        members.append((share, inside))

    def posterior(person: Person) -> float:
        candidate = replace(cells, noise=person.noise, blunders=person.blunders)
        evidence = sum(share * float(candidate.log_evidence(inside, every).sum()) for share, inside in members)
        return evidence / sum(share for share, _ in members) - person.price

    return max(PERSONS, key=posterior)


def guides_of(cells: ScoreCells) -> tuple[ScoreCells, ...]:
    """The same labels with more noise, which prefers parts that differ in their mean.

    With the spread of the scores as noise, all parts are worth dividing that are not yet of one value: the first of
    several splits, after which liked and disliked designs are still mixed, has little evidence with less noise.
    """
    spread = float(cells.scores.std())
    noises = (_GUIDE.noise, spread) if spread > _GUIDE.noise else (_GUIDE.noise,)
    return tuple(replace(cells, noise=noise, blunders=_GUIDE.blunders) for noise in noises)


def enough(num: int, scores: Floats) -> int:
    """Number of trees or rounds for a number of scores."""
    return num if len(scores) <= MANY_LABELS else num - num // 3


def sketching(guides: Sequence[ScoreCells]) -> list[Growth]:
    """Options of a few trees, one of them of the best splits."""
    return [Growth(1e-2)] + [Growth(LOW_TEMPERATURE, 0.0, guides)] * (_NUM_SKETCHES - 1)


def posterior_shares(trees: Sequence[Tree]) -> Floats:
    """[trees] the weight of each tree; all sum to 1."""
    posterior = np.array([tree.log_posterior for tree in trees])
    shares = np.exp((posterior - posterior.max()) / _TEMPERATURE)
    return shares / shares.sum()
