"""The paper's synthesis: alternation of majority labels and nearest neighbourhoods."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from grammarlab.facade.examples.label_grid import Labels
from grammarlab.facade.examples.labels.energy import distances, votes
from grammarlab.facade.examples.labels.problem import Problem

MOST_ITERATIONS = 100


@dataclass(frozen=True, slots=True)
class Trace:
    """Result of one run of expectation maximization."""

    labels: Labels
    """[rows, columns] labels."""
    history: tuple[int, ...]
    """Energy after each iteration; it never rises."""


def expectation_maximization(problem: Problem, seed: int, iterations: int = MOST_ITERATIONS) -> Trace:
    """Local optimum of the energy from random initial neighbourhoods.

    E step: each cell gets the majority label of the neighbourhoods over it, the lowest label of equally frequent ones.
    M step: each window gets the nearest neighbourhood (Eq. 2), the first of equally near ones. It ends when no
    neighbourhood changes.

    Args:
        problem: the windows, without borders for the paper's energy.
        seed: seed of the initial neighbourhoods.
        iterations: largest number of iterations.
    """
    generator = np.random.default_rng(seed)
    sizes = np.array([len(patches) for patches in problem.patches])
    nearest = np.where(problem.kind < 0, -1, generator.integers(0, sizes[problem.kind]))
    history: list[int] = []
    labels = nearest
    for _ in range(max(1, iterations)):
        labels = votes(problem, nearest).argmax(axis=2)
        found, differ = distances(problem, labels)
        history.append(int(differ.sum()))
        if np.array_equal(found, nearest):
            break
        nearest = found
    return Trace(labels, tuple(history))
