"""A new building as rules: rows and columns of units, which are meshes, and the rest as one mesh.

The rules make the building without stitching, accurate to the millimetre. Units and the rest of closed examples are
closed solids: cuts have faces, so that neighbours touch without gaps.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from manifold3d import Manifold, Mesh64

from grammarlab.arrays import Floats, Ints
from grammarlab.facade.grammar.rule_text import RuleNames, front_of_box, number, rule_name
from grammarlab.synthesis.analysis.example import Example, Region
from grammarlab.synthesis.assembly import Tiling, unit_in
from grammarlab.synthesis.mesh.solids import solid_of, surface_of
from grammarlab.synthesis.mesh.surface import Color, Surface, sliced
from grammarlab.synthesis.mesh.views import VIEWS, placed_from, seen_from
from grammarlab.synthesis.units import SNAP, BuildingCut, Stretch, UnitStock

_CUT = 1_000_000_000
"""Material of the faces of cuts, until they get a material of their piece."""
_CORNERS = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=np.float64)
_SIDES = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
_FACES = np.array([triangle for a, b, c, d in _SIDES for triangle in ((a, b, c), (a, c, d))], dtype=np.uint64)
"""[12, 3] triangles of a box, rows of `_CORNERS`, seen from outside."""
_DIGITS = 6
"""Decimal digits of lengths: micrometres."""


@dataclass(frozen=True, eq=False)
class BuildingParts:
    """Units and the rest of a building; closed if the examples are."""

    stock: UnitStock
    solids: tuple[Manifold, ...]
    """For each wall, all of its units as one solid; none if an example is open."""
    rest: Surface
    """The rest of the first example, in the coordinates of the building."""

    def cell(self, wall: int, row: int, column: int) -> Surface:
        """The unit in a cell of a wall, in the coordinates of its view."""
        if not self.solids:
            return self.stock.cut.cells[wall][row][column]
        region = self.stock.walls[wall]
        low, high = region.cell(row, column)
        surface = _painted(self.solids[wall] ^ _box_before(region, low, high))
        return surface.moved(seen_from(region.side, surface.points))


@dataclass(frozen=True, slots=True)
class Terminal:
    """A mesh of one material that rules insert."""

    name: str
    """File name."""
    surface: Surface


@dataclass(frozen=True, slots=True)
class BuildingRules:
    """Rules and the meshes they insert."""

    text: str
    terminals: tuple[Terminal, ...]


def parts_of(examples: Sequence[Example], stock: UnitStock) -> BuildingParts:
    """The units and the rest: as solids if all examples are closed, else open where they were cut."""
    solids: list[Manifold] = []
    rest, num_colors = stock.cut.rest, 0
    for index, example in enumerate(examples):
        solid = solid_of(replace(example.surface, material=example.surface.material + num_colors))
        num_colors += len(example.mesh.colors)
        if solid is None:
            return BuildingParts(stock, (), stock.cut.rest)
        for region in example.regions if index == 0 else [example.main]:
            units, solid = solid.split(_box_before(region, region.low, region.high))
            solids.append(units)
        if index == 0:
            rest = _painted(solid)
    return BuildingParts(stock, tuple(solids), rest)


def halves(surface: Surface, axis: int, position: float) -> list[Surface]:
    """The parts of a surface on both sides of a plane across an axis; closed if the surface is."""
    low, high = surface.points.min(axis=0), surface.points.max(axis=0)
    if not low[axis] + SNAP < position < high[axis] - SNAP:
        return [surface]
    solid = solid_of(surface)
    if solid is None:
        surface = sliced(surface, axis, position, SNAP)
        below = surface.points[surface.triangles, axis].mean(axis=1) < position
        return [surface.part(below), surface.part(~below)]
    low, high = low - 1.0, high + 1.0
    low[axis] = position
    return [_painted(half) for half in solid.split(_box(low, high)) if not half.is_empty()]


def building_rules(
    cut: BuildingCut,
    tilings: Sequence[Tiling],
    stretch: Stretch,
    colors: Sequence[Color],
    title: str,
) -> BuildingRules:
    """The rules of one building; its lowest corner lies at the corner of the lot."""
    rest = stretch.moved(cut.rest)
    origin = rest.points.min(axis=0) if len(rest) else np.zeros(3)
    names, terminals = RuleNames(), []
    start, rules = [], []
    if len(rest):
        start.append(f"[ {names.new('Rest')} ]")
        body = inserted_parts(
            "rest", rest, lambda low, high: (_list(low - origin), _list(high - low)), colors, terminals
        )
        rules.append(f"Rest -->\n{body}")
    for tiling in tilings:
        rule = names.new(rule_name(tiling.region.name))
        low = np.array([tiling.columns[0], tiling.rows[0], tiling.plane]) @ VIEWS[tiling.region.side] - origin
        size = np.array([tiling.columns[-1] - tiling.columns[0], tiling.rows[-1] - tiling.rows[0], 1.0])
        turn = f" r(0, {90 * tiling.region.side}, 0)" if tiling.region.side else ""
        start.append(f"[ t({_list(low)}){turn} t(0, 0, -1) {front_of_box(_list(size), rule)} ]")
        rules += _rows(rule, cut, tiling, names, colors, terminals)
    head = f'// {title}\nversion "2023.0"\n\n@StartRule\nLot -->\n    ' + "\n    ".join([*start, "NIL"])
    return BuildingRules("\n\n".join([head, *rules]) + "\n", tuple(terminals))


def inserted_parts(
    file: str,
    surface: Surface,
    placement: Callable[[Floats, Floats], tuple[str, str]],
    colors: Sequence[Color],
    terminals: list[Terminal],
) -> str:
    """CGA that inserts a surface, one mesh per material.

    Args:
        file: name of its files, without the start and the end that all share.
        surface: the surface.
        placement: the CGA of the position and size in the scope of a box, given by its low and high corner [3].
        colors: colors of materials.
        terminals: meshes so far.
    """
    lines = []
    used = np.unique(surface.material).tolist()
    for part_index, material in enumerate(used):
        part = surface.part(surface.material == material)
        name = f"unit-{file}{f'-{part_index}' if len(used) > 1 else ''}.glb"
        terminals.append(Terminal(name, part))
        position, size = placement(part.points.min(axis=0), part.points.max(axis=0))
        lines.append(f'    [ color("{_hex(colors[material])}") t({position}) s({size}) i("{name}") Mesh. ]')
    return "\n".join([*lines, "    NIL"])


@dataclass(frozen=True, slots=True)
class UnitScope:
    """The cell whose scope a unit fills."""

    file: str
    """Middle of the names of its files."""
    low: Floats
    """[2] lower left corner in the coordinates of the view, metres."""
    high: Floats
    """[2] upper right corner, metres."""
    plane: float
    """Depth of the wall, metres."""


def unit_body(surface: Surface, scope: UnitScope, colors: Sequence[Color], terminals: list[Terminal]) -> str:
    """CGA that makes a unit in the scope of its cell; its meshes are added to the terminals.

    Args:
        surface: the unit, in the coordinates of the view.
        scope: its cell.
        colors: colors of materials.
        terminals: meshes so far.
    """
    if not len(surface):
        return "    NIL"
    corner, cell = np.array([*scope.low, scope.plane]), scope.high - scope.low

    def placement(start: Floats, end: Floats) -> tuple[str, str]:
        offset, size = start - corner, end - start
        return (
            _list([*(offset[:2] / cell), offset[2]], ("scope.sx * ", "scope.sy * ", "")),
            _list([*(size[:2] / cell), size[2]], ("'", "'", "")),
        )

    return inserted_parts(scope.file, surface, placement, colors, terminals)


def _painted(solid: Manifold) -> Surface:
    """The surface of a piece; faces of cuts get the material of most of its other area."""
    surface = surface_of(solid)
    cut = surface.material == _CUT
    if not cut.any():
        return surface
    a, b, c = surface.corners().swapaxes(0, 1)
    area = np.where(cut, 0.0, np.linalg.norm(np.cross(b - a, c - a), axis=1))
    usual = np.bincount(np.where(cut, 0, surface.material), weights=area).argmax()
    return replace(surface, material=np.where(cut, usual, surface.material))


def _box_before(region: Region, low: Floats, high: Floats) -> Manifold:
    """The box of a rectangle in a wall, as deep as its units."""
    ends = placed_from(region.side, np.array([[*low, region.back], [*high, region.front]]))
    return _box(ends.min(axis=0), ends.max(axis=0))


def _box(low: Floats, high: Floats) -> Manifold:
    points = low + _CORNERS * (high - low)
    return Manifold(Mesh64(points, _FACES, face_id=np.full(len(_FACES), _CUT, dtype=np.uint64)))


def _hex(color: Color) -> str:
    return "#" + "".join(f"{round(255 * channel):02X}" for channel in color[:3])


def _list(values: Sequence[float] | Floats, before: Sequence[str] = ("", "", "")) -> str:
    texts = (number(float(value), _DIGITS) for value in values)
    return ", ".join(f"{head}{text}" if text != "0" else text for head, text in zip(before, texts, strict=True))


def _rows(
    rule: str,
    cut: BuildingCut,
    tiling: Tiling,
    names: RuleNames,
    colors: Sequence[Color],
    terminals: list[Terminal],
) -> list[str]:
    """The rules of one wall: its rows, each different row, each unit of a size."""
    shape = tiling.grid.labels.shape
    heights, widths = np.diff(tiling.rows), np.diff(tiling.columns)
    sizes = np.stack(np.broadcast_arrays(widths, heights[:, None]), axis=2).round(_DIGITS)
    keys = np.concatenate([tiling.sources, sizes], axis=2).reshape(-1, 5)
    units, first, inverse = np.unique(keys, axis=0, return_index=True, return_inverse=True)
    cell_units: Ints = inverse.reshape(shape)
    unit = []
    for wall, row, column in units[:, :3].astype(np.int64).tolist():
        grid = tiling.walls[wall].grid
        unit.append(names.new(f"{rule}{rule_name(grid.names[grid.labels[row, column]])}"))
    kinds: dict[tuple[int, ...], str] = {}
    lines = [tuple(int(unit_index) for unit_index in line) for line in cell_units]
    for line in lines:
        if line not in kinds:
            kinds[line] = names.new(f"{rule}Row{len(kinds) + 1}")
    parts = [(float(height), kinds[line]) for height, line in zip(heights, lines, strict=True)]
    rules = [f"{rule} -->\n    split(y) {{ {_split(parts)} }}"]
    for row, name in kinds.items():
        split = _split([(float(width), unit[index]) for width, index in zip(widths, row, strict=True)])
        rules.append(f"{name} -->\n    split(x) {{ {split} }}")
    for index, (name, cell) in enumerate(zip(unit, first.tolist(), strict=True)):
        row, column = divmod(cell, shape[1])
        file = f"{tiling.region.name.replace(':', '-')}-{index}"
        scope = UnitScope(file, *tiling.cell(row, column), tiling.plane)
        rules.append(f"{name} -->\n{unit_body(unit_in(cut, tiling, row, column), scope, colors, terminals)}")
    return rules


def _split(parts: list[tuple[float, str]]) -> str:
    return " | ".join(f"{number(size, _DIGITS)} : {name}" for size, name in parts)
