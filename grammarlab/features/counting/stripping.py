"""Forests without data that no feature needs, to keep many of them in memory."""

from __future__ import annotations

from dataclasses import fields, replace

import numpy as np
from numpy.typing import NDArray

from grammarlab.derivation.forest import Forest, Leaves, Reports
from grammarlab.derivation.values.materials import Materials


def without_geometry(forest: Forest) -> Forest:
    """Only the trees and draws of a forest: leaves, meshes and reported values take most of its memory."""
    reports = forest.reports
    return replace(
        forest,
        leaves=Leaves(**{each.name: _emptied(getattr(forest.leaves, each.name)) for each in fields(Leaves)}),
        reports=Reports(_emptied(reports.node), _emptied(reports.key), _emptied(reports.value), ()),
        frames=_emptied(forest.frames),
        meshes=forest.meshes.take(np.zeros(0, np.int64)),
        materials=Materials(_emptied(forest.materials.channels), ()),
        texture_maps=_emptied(forest.texture_maps),
    )


def _emptied(column: NDArray) -> NDArray:
    """No rows of a column; a copy, since a view would keep the rows."""
    return column[:0].copy()
