"""Rows and scores to test with."""

from __future__ import annotations

import numpy as np


def counted_rows(num_rows: int, num_columns: int, seed: int = 0):
    """Small counts, as features have, and scores that depend on columns 0 and 1 alone."""
    rng = np.random.default_rng(seed)
    rows = rng.integers(0, 4, (num_rows, num_columns)).astype(float)
    scores = np.select([rows[:, 0] == 0, (rows[:, 0] == 1) & (rows[:, 1] > 1)], [70.0, 20.0], 0.0)
    return rows, scores


def toy_towers(num_matching: int, num_others: int, seed: int = 6):
    """Rows of the toy grammar's towers, and their scores for the two factors of 4.5.2.

    A tower has a bottom and a top block, each of one of three colours (orange, green, blue), one of three shapes (box,
    cylinder, star) and a height of 1 to 5: columns 0-2 and 3-5 say the colours, 6-8 and 9-11 the shapes, 12 and 13 the
    heights h1 and h2.

    Args:
        num_matching: towers of one colour.
        num_others: towers of any two colours.
        seed: of all that is left to chance.

    Returns:
        Rows [n, 14]; scores for colour, 100 for two orange blocks, 50 for two green or two blue ones, else 0; scores
        for geometry, 100 for a box below, 50 for a cylinder, 0 for a star.
    """
    rng = np.random.default_rng(seed)
    matching = np.repeat(np.arange(num_matching) % 3, 2).reshape(-1, 2)
    color = np.concatenate((matching, rng.integers(0, 3, (num_others, 2))))
    shape = rng.integers(0, 3, color.shape)
    heights = rng.uniform(1.0, 5.0, color.shape)
    one_hot = [np.eye(3)[column] for column in (*color.T, *shape.T)]
    same = color[:, 0] == color[:, 1]
    by_color = np.where(same, np.where(color[:, 0] == 0, 100.0, 50.0), 0.0)
    return np.concatenate((*one_hot, heights), axis=1), by_color, np.array([100.0, 50.0, 0.0])[shape[:, 0]]


def bits(num_rows: int, num_columns: int, seed: int = 0):
    """Rows of zeros and ones."""
    return np.random.default_rng(seed).integers(0, 2, (num_rows, num_columns)).astype(float)
