"""The paper's synthesis: labels by majority and nearest neighbourhoods in turn."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from grammarlab.facade.examples.label_grid import Labels
from grammarlab.facade.examples.labels.energy import distances, votes
from grammarlab.facade.examples.labels.problem import Problem

MOST_ITERATIONS = 100


@dataclass(frozen=True, slots=True)
class Trace:
    """Where one run of expectation maximization ended."""

    labels: Labels
    """[rows, columns]"""
    history: tuple[int, ...]
    """Energy after each iteration; it never rises."""


def expectation_maximization(problem: Problem, seed: int, iterations: int = MOST_ITERATIONS) -> Trace:
    """Local optimum of the energy from neighbourhoods drawn at random.

    E step: each cell gets the label that most of the neighbourhoods over it have there, the lowest label of equally
    frequent ones. M step: each window gets the nearest neighbourhood (Eq. 2), the first of equally near ones. It ends
    when no neighbourhood changes.

    Args:
        problem: the windows, without borders for the paper's energy.
        seed: of the neighbourhoods drawn first.
        iterations: at most.
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
