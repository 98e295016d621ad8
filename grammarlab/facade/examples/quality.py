"""Similarity of a grid of labels and its examples, in numbers."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from grammarlab.facade.examples.label_grid import LabelGrid, Labels

_WINDOW = 3


@dataclass(frozen=True, slots=True)
class Quality:
    """Similarity of a grid and its examples; each value from 0 to 1."""

    patch_similarity: float
    """Bidirectional: mean share of equal cells of a window and the nearest one of the other side, from the grid to the
    examples and from the examples to the grid; 1 if each has every window of the other."""
    cooccurrence: float
    """Total variation distance of pairs of adjacent labels, horizontal and vertical; 0 for equal frequencies."""
    histogram: float
    """Total variation distance of the labels; 0 for equal frequencies."""
    novelty: float
    """Share of the grid's windows that are in no example."""


def quality_of(grid: Labels, examples: Sequence[LabelGrid]) -> Quality:
    """The quality of a grid.

    Windows have 3 rows and 3 columns, or fewer if a grid has fewer. Holes match any label.

    Args:
        grid: [rows, columns] labels.
        examples: examples with the same numbering of labels.
    """
    height = min(_WINDOW, grid.shape[0], *(example.rows for example in examples))
    width = min(_WINDOW, grid.shape[1], *(example.columns for example in examples))
    own = np.unique(_windows(grid, height, width), axis=0, return_counts=True)
    theirs = np.unique(
        np.concatenate([_windows(e.labels, height, width) for e in examples]), axis=0, return_counts=True
    )
    differ = _differences(own[0], theirs[0])
    forth = float(np.average(differ.min(axis=1), weights=own[1]))
    back = float(np.average(differ.min(axis=0), weights=theirs[1]))
    return Quality(
        patch_similarity=1.0 - (forth + back) / (2 * height * width),
        cooccurrence=_distance([grid], [example.labels for example in examples], pairs=True),
        histogram=_distance([grid], [example.labels for example in examples], pairs=False),
        novelty=float(np.average(differ.min(axis=1) > 0, weights=own[1])),
    )


def _windows(labels: Labels, height: int, width: int) -> Labels:
    """The windows of a grid, [windows, height * width]."""
    views = np.lib.stride_tricks.sliding_window_view(labels, (height, width))
    return views.reshape(-1, height * width)


def _differences(one: Labels, other: Labels) -> Labels:
    """[len(one), len(other)] number of differing labels."""
    found = np.zeros((len(one), len(other)), dtype=np.int64)
    for here, there in zip(one.T, other.T, strict=True):
        found += (here[:, None] != there) & (here[:, None] >= 0) & (there >= 0)
    return found


def _distance(one: Sequence[Labels], other: Sequence[Labels], pairs: bool) -> float:
    """Total variation distance of labels, or of pairs of neighbours, with horizontal and vertical pairs apart."""
    tables = []
    for grids in (one, other):
        keys: dict[tuple[int, ...], float] = {}
        for labels in grids:
            for key in _keys(labels, pairs):
                keys[key] = keys.get(key, 0.0) + 1.0
        total = sum(keys.values())
        tables.append({key: often / total for key, often in keys.items()})
    mine, theirs = tables
    if not mine or not theirs:  # a single cell has no neighbours
        return float(bool(mine) != bool(theirs))
    return sum(abs(mine.get(key, 0.0) - theirs.get(key, 0.0)) for key in {*mine, *theirs}) / 2.0


def _keys(labels: Labels, pairs: bool) -> list[tuple[int, ...]]:
    if not pairs:
        return [(label,) for label in labels[labels >= 0].tolist()]
    found = []
    for axis in (0, 1):
        view = labels if axis else labels.T
        left, right = view[:, :-1].ravel(), view[:, 1:].ravel()
        known = (left >= 0) & (right >= 0)
        found += [(axis, *pair) for pair in zip(left[known].tolist(), right[known].tolist(), strict=True)]
    return found
