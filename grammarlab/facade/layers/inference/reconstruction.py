"""How much of a facade another one shows: area with the right label, and elements in their places."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import shapely

from grammarlab.facade.layers.inference.elements import backdrop_of
from grammarlab.facade.tree import Facade, Floats, X, Y

_MATCH = 0.5
"""Rectangles that share more than this part of their union match: of those that do not overlap, one at most does."""


@dataclass(frozen=True, slots=True)
class Reconstruction:
    """What a facade shares with an original of the same size."""

    area: float
    """0 to 1, of the original where the labels are the same."""
    iou: float
    """0 to 1, intersection over union, mean over elements: each with the one of its label that it shares most with."""
    quality: float
    """0 to 1, panoptic quality: IoU of all elements that match, over the mean number of elements of both."""
    elements: int
    """Of the original: leaves that are not its wall."""
    found: int
    """Elements of the other one."""


def compare(original: Facade, other: Facade) -> Reconstruction:
    """What a facade shares with an original."""
    boxes, others = _boxes(original), _boxes(other)
    pairs = shapely.STRtree(shapely.box(*others.T)).query(shapely.box(*boxes.T))
    one, two = boxes[pairs[0]], others[pairs[1]]
    shared = np.maximum(np.minimum(one[:, 2:], two[:, 2:]) - np.maximum(one[:, :2], two[:, :2]), 0.0).prod(axis=1)
    names = [
        np.array([each.name_of(leaf) for leaf in each.leaves.tolist()], dtype=object) for each in (original, other)
    ]
    same = names[0][pairs[0]] == names[1][pairs[1]]
    backdrop = backdrop_of(original)
    element, found = (each != backdrop for each in names)
    union = (one[:, 2:] - one[:, :2]).prod(axis=1) + (two[:, 2:] - two[:, :2]).prod(axis=1) - shared
    iou = np.where(same, shared / union, 0.0)
    best = np.zeros(len(boxes))
    np.maximum.at(best, pairs[0], iou)
    best = best[element]
    matched = float(best[best > _MATCH].sum())
    total = 0.5 * float(element.sum() + found.sum())
    return Reconstruction(
        area=min(float(shared[same].sum()) / (original.width * original.height), 1.0),
        iou=float(best.mean()) if len(best) else 1.0,
        quality=matched / total if total else 1.0,
        elements=int(element.sum()),
        found=int(found.sum()),
    )


def _boxes(facade: Facade) -> Floats:
    """[L, 4] left, bottom, right, top of leaves."""
    low = facade.position[facade.leaves]
    return np.concatenate([low, low + facade.size[facade.leaves]], axis=1)[:, [X, Y, 2, 3]]
