"""An example: a building upright, its walls with rows, columns and labels of their units, the main one in front."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from grammarlab.errors import FacadeError
from grammarlab.facade.examples.analysis.elements import bare_of, elements_of
from grammarlab.facade.examples.analysis.kinds import label_grid
from grammarlab.facade.examples.analysis.lattice import Lattice, lattice
from grammarlab.facade.examples.analysis.walls import BEFORE, BEHIND, Wall, walls_of
from grammarlab.facade.examples.label_grid import LabelGrid
from grammarlab.facade.examples.mesh.bending import Bend, bend_of
from grammarlab.facade.examples.mesh.reading import ExampleMesh
from grammarlab.facade.examples.mesh.surface import Floats, Surface
from grammarlab.facade.examples.mesh.views import FRONT, SIDES, VIEWS, Z_UP, seen_from, turn_to_walls

_SLACK = 0.05
"""Metres behind and before what is seen of a region."""
_COARSE = 40_000
"""Pixels of the maps that tell which axis is up."""
_ENTERED = 1.5
"""How many units without an entrance count as much as one of a wall that has one."""
MOST_LINES = 200
"""Rows or columns."""


@dataclass(frozen=True, eq=False)
class Region:
    """The part of a wall that is made of units, in the coordinates of the view from its side."""

    name: str
    side: int
    columns: Lattice
    rows: Lattice
    grid: LabelGrid
    plane: float
    """Metres towards the viewer, of the wall."""
    back: float
    """Metres: what lies behind is not part of the units."""
    front: float
    elements: Floats
    """[E, 4] metres, boxes of what was found, low and high corners."""
    wall: Floats
    """[2, 2] metres, low and high corner of the wall."""
    noise: float
    """Metres by which what lies in the plane of the wall deviates from it."""

    @property
    def low(self) -> Floats:
        """[2] metres."""
        return np.array([self.columns.line[0], self.rows.line[0]])

    @property
    def high(self) -> Floats:
        """[2] metres."""
        return np.array([self.columns.line[-1], self.rows.line[-1]])

    def cell(self, row: int, column: int) -> tuple[Floats, Floats]:
        """Lower left and upper right corner [2] of a cell, in metres."""
        return (
            np.array([self.columns.line[column], self.rows.line[row]]),
            np.array([self.columns.line[column + 1], self.rows.line[row + 1]]),
        )

    def elements_in(self, row: int, column: int) -> Floats:
        """[K, 4] boxes of what stands in a cell."""
        return self.elements[(self.rows.member == row) & (self.columns.member == column)]

    def source(
        self, label: int, borders: tuple[bool, bool, bool, bool] = (False, False, False, False)
    ) -> tuple[int, int]:
        """Row and column of the unit that stands for a label: one at the same borders, near the middle of such units.

        Args:
            label: the label.
            borders: whether the unit will stand at the bottom, the top, the left and the right.
        """
        places = np.argwhere(self.grid.labels == label)
        rows, columns = self.grid.labels.shape
        ends = np.array([[0, rows - 1, 0, columns - 1]])
        misses = ((places[:, [0, 0, 1, 1]] == ends) != np.array(borders)).sum(axis=1)
        places = places[misses == misses.min()]
        return tuple(places[np.abs(places - places.mean(axis=0)).sum(axis=1).argmin()].tolist())


@dataclass(frozen=True, eq=False)
class Example:
    """A building with y up whose main wall faces z."""

    mesh: ExampleMesh
    surface: Surface
    turn: Floats
    """[3, 3] what took the coordinates of the file, less `mesh.origin`, to those of the building; if it is bent, those
    of the building laid out straight."""
    regions: tuple[Region, ...]
    """The main one first."""
    notes: tuple[str, ...]
    bend: Bend | None = None
    """The arc that the building stands along; its surface and its regions are laid out straight."""

    def bent(self, points: Floats) -> Floats:
        """[P, 3] points of a building like this one as they stand."""
        return points if self.bend is None else self.bend.bent(points @ self.turn)

    @property
    def main(self) -> Region:
        return self.regions[0]


def analyse(mesh: ExampleMesh, up: str = "") -> Example:
    """Walls, units and labels of a building.

    Args:
        mesh: the building.
        up: `y` or `z`; where empty, the one with which more units are found on walls, and y if none has more.

    Raises:
        FacadeError: where no wall has anything on it.
    """
    ways = {"y": np.eye(3), "z": Z_UP}
    if not up:
        # A coarse look is enough to tell walls from roofs.
        scores = {each: _num_elements(_turned(mesh, turn)[0]) for each, turn in ways.items()}
        up = "z" if scores["z"] > scores["y"] else "y"
        notes = ("z is taken to be up, since more units stand on walls then",) if up == "z" else ()
    else:
        notes: tuple[str, ...] = ()
    example = _upright(mesh, ways[up])
    if not example.regions:
        large = float(np.ptp(example.surface.points, axis=0).max())
        raise FacadeError(
            f"No wall of this building, {large:.3g} m large, has units on it, such as windows, that differ from its "
            "plane by 3 cm or more; give --up if it lies on its side, --unit if its coordinates are no metres."
        )
    if example.bend is not None:
        notes += (f"walls stand along an arc of {example.bend.radius:.1f} m; rules and facades are laid out straight",)
    return replace(example, notes=notes)


def _num_elements(surface: Surface) -> int:
    """Elements on the walls of all sides, about."""
    found = 0
    for side in range(len(SIDES)):
        corners = seen_from(side, surface.points)[surface.triangles]
        found += sum(len(elements_of(wall, corners).low) for wall in walls_of(surface, side, _COARSE))
    return found


def _turned(mesh: ExampleMesh, stand: Floats) -> tuple[Surface, Floats, Bend | None]:
    """The building stood up, laid out straight and turned to its walls; [3, 3] the rotation, and the arc if any."""
    surface = mesh.surface.moved(mesh.surface.points @ stand.T)
    bend = bend_of(surface)
    if bend is not None:
        surface = surface.moved(bend.straight(surface.points))
        turn = turn_to_walls(surface)
        return surface.moved(surface.points @ turn.T), turn, bend
    turn = turn_to_walls(surface) @ stand
    return mesh.surface.moved(mesh.surface.points @ turn.T), turn, None


def _upright(mesh: ExampleMesh, stand: Floats) -> Example:
    """The building with its units, when so turned."""
    surface, turn, bend = _turned(mesh, stand)
    regions = [each for side in range(len(SIDES)) for each in _regions(surface, side)]
    if not regions:
        return Example(mesh, surface, turn, (), (), bend)
    main = max(regions, key=lambda each: (_weight(each), -each.side))
    if main.side != FRONT:
        # From the file in one step, to lose no digits, unless it was laid out straight in between.
        points = mesh.surface.points if bend is None else surface.points @ turn
        turn = VIEWS[main.side] @ turn
        surface = surface.moved(points @ turn.T)
        regions = [replace(each, side=(each.side - main.side) % len(SIDES)) for each in regions]
    regions.sort(key=lambda each: (each.side, -_weight(each)))
    names = [SIDES[each.side] for each in regions]
    numbered = [
        name if names.index(name) == place else f"{name}:{names[:place].count(name)}"
        for place, name in enumerate(names)
    ]
    regions = [replace(each, name=name) for each, name in zip(regions, numbered, strict=True)]
    return Example(mesh, surface, turn, tuple(regions), (), bend)


def _weight(region: Region) -> float:
    """How much speaks for a wall to be the main one: units, and entrances."""
    entered = any(name.startswith(("door", "shop")) for name in region.grid.names)
    return len(region.elements) * (_ENTERED if entered else 1.0)


def _regions(surface: Surface, side: int) -> list[Region]:
    corners = seen_from(side, surface.points)[surface.triangles]
    found = []
    for wall in walls_of(surface, side):
        elements = elements_of(wall, corners)
        if not len(elements.low):
            continue
        low, high = bare_of(wall)
        low, high = np.minimum(low, elements.low.min(axis=0)), np.maximum(high, elements.high.max(axis=0))
        columns, rows = (
            lattice(elements.low[:, axis], elements.high[:, axis], low[axis], high[axis]) for axis in (0, 1)
        )
        if max(len(columns), len(rows)) > MOST_LINES:
            continue
        back, front = _depths(wall, columns, rows)
        found.append(
            Region(
                name="",
                side=side,
                columns=columns,
                rows=rows,
                grid=label_grid(wall, elements, columns, rows),
                plane=wall.depth,
                back=back,
                front=front,
                elements=np.hstack([elements.low, elements.high]),
                wall=np.stack([wall.low, wall.high]),
                noise=wall.noise,
            )
        )
    return found


def _depths(wall: Wall, columns: Lattice, rows: Lattice) -> tuple[float, float]:
    """Between which depths the units lie."""
    part = wall.map.rows(rows.line[0], rows.line[-1]), wall.map.columns(columns.line[0], columns.line[-1])
    depth = wall.map.depth[part][wall.seen[part]]
    depth = depth[(depth >= wall.depth - BEHIND) & (depth <= wall.depth + BEFORE)]
    return float(depth.min(initial=wall.depth)) - _SLACK, float(depth.max(initial=wall.depth)) + _SLACK
