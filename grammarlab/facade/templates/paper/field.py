"""The objective of labelling: Equation 5.3 of paper 001."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from grammarlab.facade.templates.elements import Floats, Ints


@dataclass(frozen=True, eq=False)
class Field:
    """N elements, L labels."""

    data: Floats
    """[N, L] data costs, >= 0."""
    weight: Floats
    """[N, N] weights, >= 0, symmetric, 0 on the diagonal."""
    distance: Floats
    """[L, L] distances of labels, a metric."""
    owner: Ints
    """[L] template of each label."""
    cost: Floats
    """[T] cost of each used template, >= 0."""


def energy(field: Field, labels: Ints) -> float:
    """Equation 5.3 for labels [N]."""
    data = field.data[np.arange(len(labels)), labels].sum()
    smooth = (field.weight * field.distance[np.ix_(labels, labels)]).sum() / 2.0
    return float(data + smooth + field.cost[np.unique(field.owner[labels])].sum())
