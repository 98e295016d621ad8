"""Similarity of two facades: area with equal labels, and matched elements."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import shapely

from grammarlab.arrays import Floats
from grammarlab.facade.tree import Facade, X, Y
from grammarlab.layers.covers import backdrop_of

_MATCH_IOU = 0.5
"""Rectangles whose IoU is above this value match; among rectangles without overlaps, at most one does."""


@dataclass(frozen=True, slots=True)
class Reconstruction:
    """Similarity of a facade and an original of the same size."""

    area: float
    """0 to 1, share of the original's area with equal labels."""
    iou: float
    """0 to 1, intersection over union, mean over elements: each with the element of its label with the largest IoU."""
    quality: float
    """0 to 1, panoptic quality: sum of the IoU of matched elements, over the mean number of elements of both."""
    elements: int
    """Number of elements of the original: leaves that are not its wall."""
    other_elements: int
    """Number of elements of the other facade."""


def compare(original: Facade, other: Facade) -> Reconstruction:
    """Similarity of a facade and an original."""
    boxes, others = _boxes(original), _boxes(other)
    pairs = shapely.STRtree(shapely.box(*others.T)).query(shapely.box(*boxes.T))
    first, second = boxes[pairs[0]], others[pairs[1]]
    low, high = np.maximum(first[:, :2], second[:, :2]), np.minimum(first[:, 2:], second[:, 2:])
    shared = np.maximum(high - low, 0.0).prod(axis=1)
    names = [
        np.array([facade.name_of(leaf) for leaf in facade.leaves.tolist()], dtype=object)
        for facade in (original, other)
    ]
    same = names[0][pairs[0]] == names[1][pairs[1]]
    backdrop = backdrop_of(original)
    element, other_element = (labels != backdrop for labels in names)
    union = (first[:, 2:] - first[:, :2]).prod(axis=1) + (second[:, 2:] - second[:, :2]).prod(axis=1) - shared
    iou = np.where(same, shared / union, 0.0)
    best = np.zeros(len(boxes))
    np.maximum.at(best, pairs[0], iou)
    best = best[element]
    matched = float(best[best > _MATCH_IOU].sum())
    total = 0.5 * float(element.sum() + other_element.sum())
    return Reconstruction(
        area=min(float(shared[same].sum()) / (original.width * original.height), 1.0),
        iou=float(best.mean()) if len(best) else 1.0,
        quality=matched / total if total else 1.0,
        elements=int(element.sum()),
        other_elements=int(other_element.sum()),
    )


def _boxes(facade: Facade) -> Floats:
    """[L, 4] left, bottom, right, top of leaves."""
    low = facade.position[facade.leaves]
    return np.concatenate([low, low + facade.size[facade.leaves]], axis=1)[:, [X, Y, 2, 3]]
