"""An example: an upright building, its walls with rows, columns and labels of their units, the main one in front."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from grammarlab.arrays import Flags, Floats, Ints
from grammarlab.errors import FacadeError
from grammarlab.facade.lattice import Lattice, lattice
from grammarlab.synthesis.analysis.panes import panes_of
from grammarlab.synthesis.analysis.unit_kinds import label_grid
from grammarlab.synthesis.analysis.wall_elements import WallElements, bare_of, elements_of
from grammarlab.synthesis.analysis.wall_openings import openings_of, tilt_of
from grammarlab.synthesis.analysis.walls import BEFORE, BEHIND, PIXELS, Wall, walls_of
from grammarlab.synthesis.label_grid import LabelGrid
from grammarlab.synthesis.mesh.bending import Bend, bend_of
from grammarlab.synthesis.mesh.building_files import ExampleMesh, without_sheets
from grammarlab.synthesis.mesh.surface import Surface
from grammarlab.synthesis.mesh.views import FRONT, SIDES, VIEWS, Z_UP, rotation, seen_from, turn_to_walls

_DEPTH_MARGIN_M = 0.05
"""Margin behind and in front of the visible part of a region, metres."""
_CLEARANCE_M = 0.01
"""Metres around the plane behind units without points, where there is such a place: faces in it would be cut."""
_COARSE_PIXELS = 40_000
"""Pixels of the maps that determine the vertical axis."""
_ENTRANCE_FACTOR = 1.5
"""Factor on the number of units of a wall with an entrance, for the choice of the main wall."""
_TILT_DIGITS = 4
"""Decimals of rotations, radians: less is the same one."""
_MAX_ROTATIONS = 3
"""Number of rotations of a building to walls that are not quite square to the others."""
_MIN_PANE_RATIO = 2
"""Ratio of panes to elements in relief from which panes are units."""
MOST_LINES = 200
"""Largest number of rows or columns."""
OUTSIDE = -2
"""Label of the neighbours of cells at a border."""
_ANY = -3
INSIDE = (_ANY, _ANY, _ANY, _ANY)
"""Neighbours of a cell at no border."""
_NEIGHBOUR_WEIGHTS, _BORDER_WEIGHTS = np.array([3, 3, 1, 1]), np.array([36, 9, 9, 9])
"""Weights of differing labels below, above, to the left and to the right, and of differing borders there: a border
weighs more than all labels, and the ground more than all other borders."""


@dataclass(frozen=True, eq=False)
class Region:
    """The part of a wall that consists of units, in the coordinates of the view from its side."""

    name: str
    side: int
    columns: Lattice
    rows: Lattice
    grid: LabelGrid
    plane: float
    """Depth of the wall, metres towards the viewer."""
    back: float
    """Least depth of the units, metres; geometry behind it is not part of them."""
    front: float
    elements: Floats
    """[E, 4] boxes of the elements, low and high corners, metres."""
    whole: Floats
    """[E, 4] boxes of the elements with the sills, frames and shutters that touch them, metres."""
    wall: Floats
    """[2, 2] low and high corner of the wall, metres."""
    noise: float
    """Deviation of points in the plane of the wall from it, metres."""

    @property
    def low(self) -> Floats:
        """[2] lower left corner, metres."""
        return np.array([self.columns.line[0], self.rows.line[0]])

    @property
    def high(self) -> Floats:
        """[2] upper right corner, metres."""
        return np.array([self.columns.line[-1], self.rows.line[-1]])

    def cell(self, row: int, column: int) -> tuple[Floats, Floats]:
        """Lower left and upper right corner [2] of a cell, in metres."""
        return (
            np.array([self.columns.line[column], self.rows.line[row]]),
            np.array([self.columns.line[column + 1], self.rows.line[row + 1]]),
        )

    def elements_in(self, row: int, column: int) -> Floats:
        """[K, 4] boxes of the elements in a cell."""
        return self.elements[self._members(row, column)]

    def whole_in(self, row: int, column: int) -> Floats:
        """[K, 4] boxes of the elements in a cell, with what touches them."""
        return self.whole[self._members(row, column)]

    def _members(self, row: int, column: int) -> Flags:
        """[E] whether an element is in a cell."""
        return (self.rows.member == row) & (self.columns.member == column)

    def source(self, label: int, around: tuple[int, int, int, int] = INSIDE) -> tuple[int, int]:
        """Row and column of the unit that represents a label: one with equal neighbours, near the middle of such units.

        The ground below is most important, so that no unit of the ground floor is repeated above it if an upper storey
        has the label; then other borders, and the labels below and above: bands, such as a cornice, run along rows.

        Args:
            label: the label.
            around: the labels below, above, to the left and to the right of the new cell; `OUTSIDE` beyond a border.
        """
        cells = np.argwhere(self.grid.labels == label)
        framed = np.pad(self.grid.labels, 1, constant_values=OUTSIDE)
        row, column = cells.T + 1
        neighbours = np.stack(
            [framed[row - 1, column], framed[row + 1, column], framed[row, column - 1], framed[row, column + 1]], axis=1
        )
        target = np.array(around)
        borders = ((neighbours == OUTSIDE) != (target == OUTSIDE)) @ _BORDER_WEIGHTS
        misses = borders + (neighbours != target) @ _NEIGHBOUR_WEIGHTS
        cells = cells[misses == misses.min()]
        return tuple(cells[np.abs(cells - cells.mean(axis=0)).sum(axis=1).argmin()].tolist())


@dataclass(frozen=True, eq=False)
class Example:
    """A building with y up whose main wall faces z."""

    mesh: ExampleMesh
    surface: Surface
    turn: Floats
    """[3, 3] rotation from the coordinates of the file, less `mesh.origin`, to those of the building; of a bent
    building, to its straightened coordinates."""
    regions: tuple[Region, ...]
    """Regions, the main one first."""
    notes: tuple[str, ...]
    bend: Bend | None = None
    """Arc of a bent building; its surface and its regions are straightened."""

    def bent(self, points: Floats) -> Floats:
        """[P, 3] points of a straightened building, bent back."""
        return points if self.bend is None else self.bend.bent(points @ self.turn)

    @property
    def main(self) -> Region:
        return self.regions[0]


def analyse(mesh: ExampleMesh, up: str = "") -> Example:
    """Walls, units and labels of a building; ground planes and backdrops are left out.

    Args:
        mesh: the building.
        up: `y` or `z`; if empty, the axis for which walls have more units, and y if both have equally many.

    Raises:
        FacadeError: If no wall has elements.
    """
    turns = {axis: turn for axis, turn in (("y", np.eye(3)), ("z", Z_UP)) if up in ("", axis)}
    bare = {axis: without_sheets(mesh, turn[1]) for axis, turn in turns.items()}
    example = _best_analysis(bare, turns)
    if not example.regions and any(notes for _, notes in bare.values()):
        example = _best_analysis(dict.fromkeys(turns, (mesh, ())), turns)
    if not example.regions:
        large = float(np.ptp(example.surface.points, axis=0).max())
        raise FacadeError(
            f"No wall of this building, {large:.3g} m large, has units, such as windows, at least 2 cm off its "
            "plane; give `up=` if it lies on its side, `unit=` if its coordinates are not in metres."
        )
    if example.bend is None:
        return example
    note = f"walls follow an arc of radius {example.bend.radius:.1f} m; rules and facades are straightened"
    return replace(example, notes=(*example.notes, note))


def _best_analysis(meshes: dict[str, tuple[ExampleMesh, tuple[str, ...]]], turns: dict[str, Floats]) -> Example:
    """The building with the up axis for which walls have most units, the first of equal ones, with its notes.

    Args:
        meshes: the building without the sheets that belong to each up axis, and notes.
        turns: [3, 3] rotation of each up axis to y.
    """
    buildings = {axis: _upright_building(mesh, turns[axis]) for axis, (mesh, _) in meshes.items()}
    best = max(buildings, key=lambda axis: buildings[axis].num_elements)
    mesh, notes = meshes[best]
    if len(meshes) > 1 and best == "z":
        notes = (*notes, "z is taken as the up axis, since walls have more units then")
    return replace(_analysed(mesh, buildings[best]), notes=notes)


def _walls(surface: Surface, patches: Ints, num_pixels: int = PIXELS) -> tuple[list[tuple[Wall, WallElements]], int]:
    """The walls of all sides, from maps of this many pixels, with their elements, and the number of openings.

    Openings are elements, and what is in relief around them; where no wall has openings, panes are if walls have hardly
    any relief, or if most elements in relief contain a pane near the plane of their wall.
    """
    walls: list[tuple[Wall, WallElements]] = []
    panes, openings = list[WallElements](), list[WallElements]()
    for side in range(len(SIDES)):
        corners = seen_from(side, surface.points)[surface.triangles]
        of_side = walls_of(surface, side, num_pixels)
        openings += openings_of(of_side, corners, patches)
        for wall in of_side:
            square, moved = wall.squared(corners)
            walls.append((wall, elements_of(square, moved)))
            panes.append(panes_of(square, moved, surface.triangles, walls[-1][1]))
    num_openings = sum(len(found.low) for found in openings)
    if num_openings:
        pairs = zip(walls, openings, strict=True)
        return [(wall, relief.with_openings(found)) for (wall, relief), found in pairs], num_openings
    num = sum(len(relief.low) for _, relief in walls)
    num_glazed = sum(int(relief.contains_any(flat).sum()) for (_, relief), flat in zip(walls, panes, strict=True))
    if sum(len(flat.low) for flat in panes) <= _MIN_PANE_RATIO * num and (not num or 2 * num_glazed < num):
        return walls, 0
    return [(wall, relief.with_panes(flat)) for (wall, relief), flat in zip(walls, panes, strict=True)], 0


@dataclass(frozen=True, eq=False)
class _UprightBuilding:
    """A building made upright, straightened and rotated to its walls."""

    surface: Surface
    turn: Floats
    """[3, 3] rotation."""
    bend: Bend | None
    num_elements: int
    """Number of elements on the walls of all sides, on coarse maps."""
    num_openings: int
    """Number of those that are openings."""
    tilt: float
    """Rotation that makes the wall with most elements exactly square to its view, radians."""

    @property
    def rank(self) -> tuple[int, int]:
        """Order of rotations, the best one last: walls seen askew have few openings, but much relief."""
        return self.num_openings, self.num_elements


def _upright_building(mesh: ExampleMesh, stand: Floats) -> _UprightBuilding:
    """The upright building; if it is not quite rectangular, rotated square to the wall with units."""
    surface = mesh.surface.moved(mesh.surface.points @ stand.T)
    bend = bend_of(surface)
    if bend is not None:
        surface = surface.moved(bend.straight(surface.points))
        stand = np.eye(3)
    turn = turn_to_walls(surface) @ stand
    straight = mesh.surface if bend is None else surface
    best, tilts = _rotated(straight, mesh.patches, turn, bend)
    for _ in range(_MAX_ROTATIONS if bend is None else 0):
        others = [_rotated(straight, mesh.patches, rotation(tilt) @ best.turn, bend) for tilt in tilts]
        other, tilts = max(others, key=lambda candidate: candidate[0].rank, default=(best, []))
        if other.rank < best.rank or other is best:
            break
        best = other
    if bend is not None or best.tilt == 0.0:
        return best
    turn = rotation(best.tilt) @ best.turn
    return replace(best, surface=straight.moved(straight.points @ turn.T), turn=turn, tilt=0.0)


def _rotated(straight: Surface, patches: Ints, turn: Floats, bend: Bend | None) -> tuple[_UprightBuilding, list[float]]:
    """The rotated building, and further rotations, radians, that would make some of its walls square to a view."""
    surface = straight.moved(straight.points @ turn.T)
    walls, num_openings = _walls(surface, patches, _COARSE_PIXELS)
    tilts = {round(wall.tilt(), _TILT_DIGITS) for wall, _ in walls}
    for side in range(len(SIDES)):
        corners = seen_from(side, surface.points)[surface.triangles]
        of_side = [wall for wall, _ in walls if wall.side == side]
        tilts |= {round(tilt_of(wall, corners, patches), _TILT_DIGITS) for wall in of_side}
    tilts = sorted(tilts - {0.0})
    num_elements = sum(len(elements.low) for _, elements in walls)
    first = max(walls, key=lambda pair: len(pair[1].low), default=None)
    tilt = 0.0 if first is None else first[0].tilt(0.0)
    return _UprightBuilding(surface, turn, bend, num_elements, num_openings, tilt), tilts


def _analysed(mesh: ExampleMesh, stood: _UprightBuilding) -> Example:
    """The building with its units."""
    surface, turn, bend = stood.surface, stood.turn, stood.bend
    regions = _regions(surface, mesh.patches)
    if not regions:
        return Example(mesh, surface, turn, (), (), bend)
    if bend is not None:
        # Flat walls of polygons become round: as far as a column is from its arc, that is no noise.
        regions = [
            replace(region, noise=max(0.0, region.noise - region.columns.pitch**2 / (8.0 * bend.radius)))
            for region in regions
        ]
    main = max(regions, key=lambda region: (_weight(region), -region.side))
    if main.side != FRONT:
        # One transform from the file, to lose no digits, unless the building was straightened in between.
        points = mesh.surface.points if bend is None else surface.points @ turn
        turn = VIEWS[main.side] @ turn
        surface = surface.moved(points @ turn.T)
        regions = [replace(region, side=(region.side - main.side) % len(SIDES)) for region in regions]
    regions.sort(key=lambda region: (region.side, -_weight(region)))
    names = [SIDES[region.side] for region in regions]
    numbered = [
        name if names.index(name) == index else f"{name}:{names[:index].count(name)}"
        for index, name in enumerate(names)
    ]
    regions = [replace(region, name=name) for region, name in zip(regions, numbered, strict=True)]
    return Example(mesh, surface, turn, tuple(regions), (), bend)


def _weight(region: Region) -> float:
    """Score of a wall for the choice of the main one: units, and entrances."""
    entered = any(name.startswith(("door", "shop")) for name in region.grid.names)
    return len(region.elements) * (_ENTRANCE_FACTOR if entered else 1.0)


def _regions(surface: Surface, patches: Ints) -> list[Region]:
    regions = []
    for wall, elements in _walls(surface, patches)[0]:
        if not len(elements.low):
            continue
        square, _ = wall.squared(np.zeros((0, 3, 3)))
        low, high = bare_of(square)
        low, high = (
            np.minimum(low, elements.whole[:, 0].min(axis=0)),
            np.maximum(high, elements.whole[:, 1].max(axis=0)),
        )
        columns, rows = (
            lattice(elements.whole[:, 0, axis], elements.whole[:, 1, axis], low[axis], high[axis]) for axis in (0, 1)
        )
        if max(len(columns), len(rows)) > MOST_LINES:
            continue
        back, front = _depths(wall, columns, rows)
        back = _clear_depth(seen_from(wall.side, surface.points)[:, 2], back)
        regions.append(
            Region(
                name="",
                side=wall.side,
                columns=columns,
                rows=rows,
                grid=label_grid(square, elements, columns, rows),
                plane=wall.depth,
                back=back,
                front=front,
                elements=np.hstack([elements.low, elements.high]),
                whole=elements.whole.reshape(-1, 4),
                wall=np.stack([wall.low, wall.high]),
                noise=wall.noise,
            )
        )
    return regions


def _depths(wall: Wall, columns: Lattice, rows: Lattice) -> tuple[float, float]:
    """Least and largest depth of the units."""
    part = wall.map.rows(rows.line[0], rows.line[-1]), wall.map.columns(columns.line[0], columns.line[-1])
    depth = wall.map.depth[part][wall.mask[part]]
    depth = depth[(depth >= wall.depth - BEHIND) & (depth <= wall.depth + BEFORE)]
    return float(depth.min(initial=wall.depth)) - _DEPTH_MARGIN_M, float(
        depth.max(initial=wall.depth)
    ) + _DEPTH_MARGIN_M


def _clear_depth(depths: Floats, depth: float) -> float:
    """The given depth if no point has it; else the middle of the widest gap between points just behind it."""
    near = depths[(depths >= depth - _DEPTH_MARGIN_M) & (depths <= depth + _CLEARANCE_M)]
    if not (near >= depth - _CLEARANCE_M).any():
        return depth
    ends = np.unique(np.concatenate([near[near <= depth], [depth - _DEPTH_MARGIN_M, depth]]))
    widest = int(np.diff(ends).argmax())
    return float(ends[widest : widest + 2].mean())
