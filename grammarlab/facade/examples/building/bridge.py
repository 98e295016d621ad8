"""A wall with its units as a facade: boxes of the elements in its cells, and the grid of the cells."""

from __future__ import annotations

import numpy as np

from grammarlab.errors import FacadeError
from grammarlab.facade.boxes.annotation import annotate
from grammarlab.facade.boxes.assembling import assemble
from grammarlab.facade.examples.analysis.example import Region
from grammarlab.facade.examples.building.assembly import Tiling, plane_of_view
from grammarlab.facade.examples.building.stretching import Stretch
from grammarlab.facade.examples.mesh.surface import Floats
from grammarlab.facade.examples.mesh.views import plane_of
from grammarlab.facade.tree import Facade


def facade_of(region: Region) -> Facade:
    """The wall of an example."""
    boxes, names = [], []
    for row, column in np.ndindex(region.grid.labels.shape):
        found = region.elements_in(row, column)
        boxes.append(found)
        names += [_plain(region.grid.names[int(region.grid.labels[row, column])])] * len(found)
    return _facade(np.concatenate(boxes), names, region.wall)


def facade_of_tiling(tiling: Tiling, stretch: Stretch) -> Facade:
    """The wall of a new building."""
    region, boxes, names = tiling.region, [], []
    for row, column in np.ndindex(tiling.grid.labels.shape):
        label = int(tiling.grid.labels[row, column])
        number, *source = tiling.sources[row, column].tolist()
        low, high = tiling.walls[number].cell(*source)
        new_low, new_high = tiling.cell(row, column)
        part = (tiling.walls[number].elements_in(*source).reshape(-1, 2, 2) - low) / (high - low)
        boxes.append((new_low + part * (new_high - new_low)).reshape(-1, 4))
        names += [_plain(tiling.grid.names[label])] * len(boxes[-1])
    wall = np.array(
        [
            [
                plane_of_view(region.side, axis, float(stretch.along(plane.axis, np.array([plane.at]))[0]))
                for axis, plane in ((axis, plane_of(region.side, axis, float(corner[axis]))) for axis in (0, 1))
            ]
            for corner in region.wall
        ]
    )
    return _facade(np.concatenate(boxes), names, wall)


def _plain(name: str) -> str:
    """The name of a label without its distinguishing number."""
    head, _, number = name.rpartition("-")
    return head if head and number.isdigit() else name


def _facade(boxes: Floats, names: list[str], wall: Floats) -> Facade:
    low = np.minimum(wall[0], boxes.reshape(-1, 2).min(axis=0, initial=np.inf))
    high = np.maximum(wall[1], boxes.reshape(-1, 2).max(axis=0, initial=-np.inf))
    bounds = np.stack([np.zeros(2), high - low])
    everything = np.vstack([[0.0, 0.0, *(high - low)], boxes - np.tile(low, 2)])
    annotation = annotate(everything, ["wall", *names], "metres", bounds=bounds)
    try:
        return assemble(annotation, split=True).facade
    except FacadeError:
        # Elements that no straight cut divides: each is shown without the rest of its tree.
        return assemble(annotate(everything[:1], ["wall"], "metres", bounds=bounds)).facade
