"""Edges of lots that shapes remember: what ``street.front`` and its kin find behind a wall.

A shape has a map from the world to the plan of its lot (`texture_maps`), and a set of edges in that plan. The map moves
with the shape, so a wall stays on its edge however it is cut, moved or scaled; only operations that move edges
themselves, such as ``setback``, give shapes other sets. Both are ids in `Shapes.state`, which has them only in
grammars that use these selectors, on lots whose streets are known.
"""

from __future__ import annotations

from typing import cast

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import Floats, offsets_from_counts
from grammarlab.derivation.state.shapes import Ids, Shapes
from grammarlab.geometry.edges_behind import EdgeSets

PLAN, OUTLINE = "street:plan", "street:outline"
"""Names in `Shapes.state` of the ids of maps to the plan of the lot, and of sets of edges; no attribute can have them.
"""


class StreetOutlines:
    """Edges and directions of the lots of one derivation, and the sets of edges that operations made of them."""

    def __init__(self, outlines: EdgeSets, front: Floats, extent: Floats, model_lot: Ids, is_known: NDArray) -> None:
        """The initial sets, one per footprint.

        Args:
            outlines: F sets of edges in the plan of each footprint, labelled by their sides.
            front: [F, 2] direction of the front.
            extent: [F] metres of the longer side.
            model_lot: [N] footprint of each model.
            is_known: [F] whether anything is known of the streets of a footprint.
        """
        self._parts = [outlines]
        self._used = len(outlines.offsets) - 1
        self.front, self.extent = front, extent
        self.model_lot, self.is_known = model_lot, is_known

    def known(self, shapes: Shapes) -> NDArray[np.bool_]:
        """[N] whether anything is known of the streets of the lots of shapes."""
        return self.is_known[self.model_lot[shapes.model]]

    def add(self, outlines: EdgeSets) -> Ids:
        """Ids [O] of new sets."""
        first = self._used
        self._parts.append(outlines)
        self._used += len(outlines.offsets) - 1
        return np.arange(first, self._used, dtype=np.int32)

    @property
    def outlines(self) -> EdgeSets:
        """All sets, in the order of their ids."""
        if len(self._parts) > 1:
            parts = self._parts
            counts = np.concatenate([np.diff(part.offsets) for part in parts])
            joined = EdgeSets(
                np.concatenate([part.start for part in parts]),
                np.concatenate([part.end for part in parts]),
                np.concatenate([part.label for part in parts]),
                offsets_from_counts(counts),
            )
            self._parts = [joined]
        return self._parts[0]


def outline_ids(shapes: Shapes) -> Ids:
    """[N] the sets of edges of shapes."""
    return cast("Ids", shapes.state[OUTLINE])


def plan_ids(shapes: Shapes) -> Ids:
    """[N] the maps of shapes to the plans of their lots, `texture_maps.NONE` for geometry that is not of the lot."""
    return cast("Ids", shapes.state[PLAN])


def with_outlines(shapes: Shapes, ids: Ids) -> Shapes:
    """The same shapes with other sets of edges [N]."""
    return shapes._replace(state={**shapes.state, OUTLINE: ids})
