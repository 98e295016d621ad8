"""Limits of the size of one tree, checked before memory is taken."""

from __future__ import annotations

import numpy as np

from grammarlab.arrays import Floats, Ints
from grammarlab.errors import UsageError
from grammarlab.trees.parameters import COLUMN, COLUMNS, HIGH, LOW

MAX_STEMS = 200_000
"""Most stems of one level of a tree, clones included."""
MAX_LEAVES = 1_000_000
"""Most leaves and blossoms of a tree."""
MAX_NODES = 2_000_000
"""Most nodes of one level of a tree: about 250 bytes each while they grow."""


def check_rows(rows: Floats) -> None:
    """Refuse parameters that are not numbers or that are out of their limits.

    Args:
        rows: [n, P] parameters of trees.

    Raises:
        UsageError: With the tree, the parameter and its limits.
    """
    if rows.ndim != 2 or rows.shape[1] != len(COLUMNS):
        raise UsageError(f"expected rows of {len(COLUMNS)} parameters, found an array of shape {rows.shape}.")
    invalid = ~((rows >= LOW) & (rows <= HIGH))
    if invalid.any():
        tree, column = np.argwhere(invalid)[0]
        raise UsageError(
            f"tree {tree}: {COLUMNS[column]} is {rows[tree, column]:g}; expected a number from "
            f"{LOW[column]:g} to {HIGH[column]:g}."
        )


def check_stems(rows: Floats, level: int, num: Floats | Ints) -> None:
    """Refuse trees with too many stems or nodes in a level.

    Args:
        rows: [n, P] parameters of the trees.
        level: the level.
        num: [n] stems of each tree in that level.

    Raises:
        UsageError: With the parameter that multiplies them most, and what to try.
    """
    nodes = num * (np.rint(rows[:, COLUMN[f"curve_res_{level}"]]) + 1.0)
    if (num <= MAX_STEMS).all() and (nodes <= MAX_NODES).all():
        return
    tree = int(np.argmax(np.maximum(num / MAX_STEMS, nodes / MAX_NODES)))
    factors = _factors(rows[tree], level)
    if num[tree] > MAX_STEMS:
        size = f"{num[tree]:.3g} stems of level {level}, but {MAX_STEMS:,}"
    else:
        size = f"{nodes[tree]:.3g} nodes in level {level}, but {MAX_NODES:,}"
        factors[f"curve_res_{level}"] = rows[tree, COLUMN[f"curve_res_{level}"]]
    raise UsageError(f"tree {tree} would have at least {size} are possible. {_advice(rows[tree], factors)}.")


def check_leaves(rows: Floats, num: Floats | Ints) -> None:
    """Refuse trees with too many leaves.

    Args:
        rows: [n, P] parameters of the trees.
        num: [n] leaves of each tree.

    Raises:
        UsageError: With what to try.
    """
    if (num <= MAX_LEAVES).all():
        return
    tree = int(np.argmax(num))
    factors = _factors(rows[tree], int(np.rint(rows[tree, COLUMN["levels"]])) - 1)
    factors["leaves"] = abs(rows[tree, COLUMN["leaves"]])
    raise UsageError(
        f"tree {tree} would have {num[tree]:.3g} leaves, but {MAX_LEAVES:,} are possible. "
        f"{_advice(rows[tree], factors)}, or a smaller leaf_quality, which draws fewer and larger leaves."
    )


def _factors(row: Floats, level: int) -> dict[str, float]:
    """What multiplies the stems of a level, by the name of the parameter."""
    factors = {f"branches_{n}": float(row[COLUMN[f"branches_{n}"]]) for n in range(1, level + 1)}
    factors["base_splits"] = 1.0 + row[COLUMN["base_splits"]]
    for n in range(level + 1):
        splits, segments = row[COLUMN[f"seg_splits_{n}"]], row[COLUMN[f"curve_res_{n}"]]
        factors[f"seg_splits_{n}"] = (1.0 + splits) ** (segments - 1.0)
    return factors


def _advice(row: Floats, factors: dict[str, float]) -> str:
    name = max(factors, key=lambda name: factors[name])
    return f"{name} = {row[COLUMN[name]]:g} multiplies them most: try a smaller value, or fewer levels"
