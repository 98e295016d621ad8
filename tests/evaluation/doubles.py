"""A small world for the protocol: rows of random bits, a score that two of them decide, a learner that remembers."""

from dataclasses import dataclass

import numpy as np

from grammarlab.evaluation.material import Material, Table
from grammarlab.evaluation.protocol import Learner
from grammarlab.preference.base import AbstractPreference, Prediction

LABELLED, POOL, BITS = 300, 192, 5


def world(num_factors=1, seed=0, weights=None):
    """A material whose paths of length 1 show all bits but the last, and longer ones show all."""
    random = np.random.default_rng(seed)
    labelled = random.integers(0, 2, (LABELLED, BITS)).astype(float)
    pool = random.integers(0, 2, (POOL, BITS)).astype(float)

    def scores(rows):
        all_scores = np.column_stack([100.0 * rows[:, 0] * (0.5 + 0.5 * rows[:, -1]), 40.0 + 60.0 * rows[:, 1]])
        return all_scores[:, :num_factors]

    def table(columns):
        shown = BITS - 1 if columns.path_length == 1 else BITS
        names = tuple(f"bit {k}" for k in range(shown))
        return Table(labelled[:, :shown], pool[:, :shown], np.arange(shown), names)

    return Material(
        tuple(f"factor {k}" for k in range(num_factors)),
        scores(labelled),
        np.ones(LABELLED) if weights is None else weights,
        scores(pool),
        np.ones(POOL),
        np.ones(POOL, bool),
        table,
        examples=lambda _indices: (),
        margins=lambda _bound: np.zeros(POOL),
    )


@dataclass(frozen=True)
class Remembers(AbstractPreference):
    """Predicts the mean score of the nearest rows."""

    rows: np.ndarray
    scores: np.ndarray
    num_columns: int

    def predict(self, rows):
        rows = np.asarray(rows)
        distance = np.abs(rows[:, None] - self.rows[None]).sum(axis=2)
        nearest = distance == distance.min(axis=1, keepdims=True)
        return Prediction((nearest * self.scores).sum(axis=1) / nearest.sum(axis=1), distance.min(axis=1))

    def explain(self, group_names):
        return []


def remember(rows, scores, groups, seed, warm):
    assert warm is None or warm.rows.shape[1] == rows.shape[1] == len(groups)
    return Remembers(rows, scores, rows.shape[1])


def choose_any(state, num_models, seed):
    free = np.setdiff1d(np.arange(len(state.pool)), state.asked)
    return np.random.default_rng(seed).permutation(free)[:num_models]


LEARNER = Learner(remember, choose_any, batch=16, path_length=2)
