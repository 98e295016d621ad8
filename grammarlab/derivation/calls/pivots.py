"""Positions of the pivots of shapes.

A pivot is the coordinate system that a scope is placed in: ``scope.t`` and ``scope.r`` count from it. Its axes are a
column of every shape; its position is kept in `Shapes.state`, as the attributes ``pivot.p``, if the grammar reads it.
"""

from __future__ import annotations

import numpy as np

from grammarlab.derivation.state.shapes import Floats, Ids, Shapes, number_column
from grammarlab.derivation.state.workspace import Workspace

PIVOT_POSITION = ("pivot.px", "pivot.py", "pivot.pz")
"""Metres along the axes of the initial shape, from its origin."""


def pivot_position(shapes: Shapes, workspace: Workspace) -> Floats:
    """[N, 3] positions of the pivots, from the origin of positions; on an initial shape, its scope's origin."""
    roots = workspace.roots
    offset = np.stack([number_column(shapes.state.get(name, 0.0), shapes.num) for name in PIVOT_POSITION], axis=1)
    return roots.position[shapes.model] + workspace.frames.to_world(roots.frame[shapes.model], offset)


def with_pivot(shapes: Shapes, position: Floats, frame: Ids, workspace: Workspace) -> Shapes:
    """The same shapes with pivots at positions [N, 3], with the axes of frames [N]."""
    shapes = shapes._replace(pivot=frame)
    if PIVOT_POSITION[0] not in workspace.state_names:
        return shapes
    roots = workspace.roots
    offset = workspace.frames.to_local(roots.frame[shapes.model], position - roots.position[shapes.model])
    return shapes._replace(state={**shapes.state, **dict(zip(PIVOT_POSITION, offset.T.copy(), strict=True))})
