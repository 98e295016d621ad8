"""A new building as a stochastic grammar: buildings of other sizes with the rows and columns of its walls.

Positions are CGA expressions: each axis grows between two planes with the size of the main wall.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from grammarlab.arrays import Flags, Floats
from grammarlab.facade.grammar.bands import Repeat, repeated_runs
from grammarlab.facade.grammar.family import HEIGHT, WIDTH, Around, Range, WrittenFamily
from grammarlab.facade.grammar.rule_text import RuleNames, front_of_box, number, rule_name, split_body
from grammarlab.facade.grammar.storeys import Storeys, storeys_of
from grammarlab.facade.grammar.walks import KindSequence
from grammarlab.facade.looks import THICKNESS
from grammarlab.synthesis.assembly import Tiling
from grammarlab.synthesis.building_grammar import (
    BuildingParts,
    BuildingRules,
    Terminal,
    UnitScope,
    halves,
    inserted_parts,
    unit_body,
)
from grammarlab.synthesis.grid_grammar import Units, label_pattern, write_label_family
from grammarlab.synthesis.mesh.surface import Color, Surface
from grammarlab.synthesis.mesh.views import VIEWS
from grammarlab.synthesis.units import SNAP, Knots, Stretch, cell_knots

_DIGITS, _RATE_DIGITS = 6, 9
"""Decimal digits of lengths, metres, and of lengths per metre of growth."""
_NARROWEST = 0.75
"""Width of a cell in the narrowest wall with one column more than there is room for, as a share of its usual width."""


@dataclass(frozen=True, slots=True)
class Growth:
    """Growth along an axis: what is between two planes is stretched, what is beyond the higher one moves."""

    axis: int
    low: float
    """Coordinates of the planes in the building that the family is made from, metres."""
    high: float
    attribute: str
    """Attribute with the size of the main wall."""
    usual: float
    """Size of the main wall in that building, metres."""

    def rate(self, position: float) -> float:
        """Movement of a position per metre of growth, 0 to 1."""
        return min(max((position - self.low) / (self.high - self.low), 0.0), 1.0)


@dataclass(frozen=True, slots=True)
class BuildingGrowth:
    """Growth of a building relative to the lower left corner of its main wall."""

    corner: Floats
    """[3] metres."""
    growths: tuple[Growth, ...]

    def position(self, point: Floats) -> tuple[str, str, str]:
        """CGA of a point [3], relative to the corner."""
        x, y, z = (
            self._text(axis, float(point[axis] - self.corner[axis]), self._rate(axis, point)) for axis in range(3)
        )
        return x, y, z

    def size(self, low: Floats, high: Floats) -> tuple[str, str, str]:
        """CGA of the distances [3] between two points."""
        x, y, z = (
            self._text(axis, float(high[axis] - low[axis]), self._rate(axis, high) - self._rate(axis, low))
            for axis in range(3)
        )
        return x, y, z

    def _rate(self, axis: int, point: Floats) -> float:
        return next((growth.rate(float(point[axis])) for growth in self.growths if growth.axis == axis), 0.0)

    def _text(self, axis: int, value: float, rate: float) -> str:
        factor = number(rate, _RATE_DIGITS)
        if factor == "0":
            return number(value, _DIGITS)
        growth = next(axis_growth for axis_growth in self.growths if axis_growth.axis == axis)
        start = number(value - rate * growth.usual, _DIGITS)
        return f"{start} + {'' if factor == '1' else f'{factor} * '}{growth.attribute}"


def building_family(
    parts: BuildingParts, tilings: Sequence[Tiling], stretch: Stretch, widths: Range, heights: Range
) -> tuple[WrittenFamily, BuildingRules]:
    """The family of a building, and the same rules with the meshes that they insert.

    The main wall gets other rows and columns; the other walls get as many as fit, and the rest is stretched with them.

    Args:
        parts: units and the rest of the examples.
        tilings: walls of the building, the main one first.
        stretch: stretch of the rest.
        widths: least and largest width of the main wall, metres.
        heights: least and largest height, metres.

    Raises:
        FacadeError: If no building of the family has such a size.
    """
    writer = _Writer(parts, stretch.moved(parts.rest))
    main = tilings[0]

    def around(rows: KindSequence) -> Around:
        growth = _building_growth(main, rows, storeys_of(rows, *heights))
        return writer.around(tilings, growth)

    family = write_label_family(main.grid, writer.units(main), widths, heights, around)
    return family, BuildingRules(family.text, tuple(writer.terminals))


class _Unit(NamedTuple):
    """A unit in a cell of another size."""

    surface: Surface
    """The unit, in the coordinates of the view."""
    scope: UnitScope
    """The cell."""
    cuts: Floats
    """[S] positions between walls and elements that keep their width, metres; none if all of the unit is scaled."""
    is_rigid: Flags
    """[S + 1] whether the strips between them keep their width."""


@dataclass
class _Writer:
    """The rules around the main wall, and all meshes."""

    parts: BuildingParts
    rest: Surface
    """The rest of the building that the family is made from."""
    names: RuleNames = field(default_factory=RuleNames)
    terminals: list[Terminal] = field(default_factory=list)
    strips: list[str] = field(default_factory=list)
    """Rules of the strips of units in cells of about their width."""

    @property
    def colors(self) -> Sequence[Color]:
        return self.parts.stock.colors

    def units(self, tiling: Tiling, *, fits: bool = False) -> Units:
        """The units of a wall, made for the width of their kind of column and the height of their kind of row.

        Args:
            tiling: the wall.
            fits: whether cells have only about this width, as in walls with as many columns as fit.
        """
        sources, source = np.unique(tiling.sources.reshape(-1, 3), axis=0, return_inverse=True)
        by_source = Units(
            np.diff(tiling.columns),
            np.diff(tiling.rows),
            ("",) * len(sources),
            source.reshape(tiling.grid.labels.shape),
        )
        pattern, _ = label_pattern(tiling.grid, by_source)
        widths, heights = (
            np.array([lines.size[kind] for kind in lines.kind]) for lines in (pattern.columns, pattern.rows)
        )
        sizes = np.stack(np.broadcast_arrays(widths, heights[:, None]), axis=2)
        keys = np.concatenate([tiling.sources, sizes.round(_DIGITS)], axis=2).reshape(-1, 5)
        distinct, unit = np.unique(keys, axis=0, return_inverse=True)
        make = self._fitting_unit if fits else self._unit
        bodies = tuple(make(self._unit_in(tiling, index, key)) for index, key in enumerate(distinct))
        return Units(widths, heights, bodies, unit.reshape(tiling.grid.labels.shape))

    def _unit_in(self, tiling: Tiling, index: int, key: Floats) -> _Unit:
        """A unit for a cell.

        Args:
            tiling: the wall.
            index: number of the unit in the wall.
            key: [5] wall, row and column of its source, and width and height of the cell in metres.
        """
        wall, row, column = key[:3].astype(np.int64).tolist()
        region = tiling.walls[wall]
        low = region.cell(row, column)[0]
        scope = UnitScope(f"family-{tiling.region.name.replace(':', '-')}-{index}", low, low + key[3:], region.plane)
        x, y = cell_knots(region, row, column, low, scope.high)
        surface = self.parts.cell(wall, row, column)
        if len(surface):
            depths = np.array([region.plane, region.plane + 1.0])
            surface = Stretch((x, y, Knots(depths, depths))).moved(surface)
        narrow, _ = cell_knots(region, row, column, low, low + key[3:] * [_NARROWEST, 1.0])
        is_rigid = np.abs(np.diff(narrow.new) - np.diff(narrow.old)) <= SNAP
        return _Unit(surface, scope, x.at(narrow.old[1:-1]), is_rigid)

    def _unit(self, unit: _Unit) -> str:
        """CGA of a unit in a cell of its size."""
        return unit_body(unit.surface, unit.scope, self.colors, self.terminals)

    def _fitting_unit(self, unit: _Unit) -> str:
        """CGA of a unit in a cell of about its width: elements keep theirs, walls take the rest."""
        if not len(unit.cuts):
            return self._unit(unit)
        rest, scope, strips = [unit.surface], unit.scope, []
        ends = [float(scope.low[0]), *unit.cuts.tolist(), float(scope.high[0])]
        for index, (start, end) in enumerate(pairwise(ends)):
            inside = [half for piece in rest for half in halves(piece, 0, end)]
            piece = [half for half in inside if half.points[:, 0].max() <= end + SNAP]
            rest = [half for half in inside if half.points[:, 0].max() > end + SNAP]
            low, high = np.array([start, scope.low[1]]), np.array([end, scope.high[1]])
            strip = UnitScope(f"{scope.file}-{index}", low, high, scope.plane)
            body = "\n".join(unit_body(each, strip, self.colors, self.terminals) for each in piece) or "    NIL"
            name = self.names.new("Opening" if unit.is_rigid[index] else "Strip")
            self.strips.append(f"{name} -->\n{body}")
            strips.append((("" if unit.is_rigid[index] else "~") + number(end - start, _DIGITS), name))
        return f"    {split_body('x', strips, repeats=False)}"

    def around(self, tilings: Sequence[Tiling], growth: BuildingGrowth) -> Around:
        """The other walls and the rest."""
        for name in (WIDTH, HEIGHT):
            self.names.new(name)
        low = np.vstack([growth.corner, self.rest.points]).min(axis=0)
        rule, lines, parts = self.names.new("Others"), [], [f"t(0 - {WIDTH}, 0, 0)"]
        for tiling in tilings[1:]:
            wall = self.names.new(rule_name(tiling.region.name))
            parts.append(_wall(tiling, growth, wall))
            lines += self._wall_rules(tiling, wall)
        lines += self.strips
        pieces = [self.rest] if len(self.rest) else []
        for axis_growth in growth.growths:
            for position in (axis_growth.low, axis_growth.high):
                pieces = [half for piece in pieces for half in halves(piece, axis_growth.axis, position)]
        for index, piece in enumerate(pieces):
            name = self.names.new("Rest")
            parts.append(f"[ {name} ]")
            body = inserted_parts(
                f"family-rest-{index}", piece, lambda a, b: _placed(growth, a, b), self.colors, self.terminals
            )
            lines.append(f"{name} -->\n{body}")
        x, y, z = (number(float(offset), _DIGITS) for offset in growth.corner - low - [0.0, 0.0, THICKNESS])
        start = f"t({x}, {y}, {z})"
        return Around(start, rule, (f"{rule} --> {' '.join([*parts, 'NIL'])}", *lines), self.names)

    def _wall_rules(self, tiling: Tiling, wall: str) -> list[str]:
        """The rules of another wall: columns, as many as fit, of rows, as many as fit."""
        pattern, bodies = label_pattern(tiling.grid, self.units(tiling, fits=True))
        units = {label: self.names.new(f"{wall}{rule_name(label)}") for label in bodies}
        columns = [self.names.new(f"{wall}Column") for _ in pattern.columns.size]
        lines = [f"{wall} --> {_fitting('x', pattern.columns, columns)}"]
        for kind, name in enumerate(columns):
            cells = [units[row[kind].label] for row in pattern.cells]
            lines.append(f"{name} --> {_fitting('y', pattern.rows, cells)}")
        used = {cell.label for row in pattern.cells for cell in row}
        return lines + [f"{units[label]} -->\n{body}" for label, body in bodies.items() if label in used]


def _wall(tiling: Tiling, growth: BuildingGrowth, rule: str) -> str:
    """CGA of a wall: the front of a box behind it."""
    side = tiling.region.side
    low, high = (np.array([tiling.columns[end], tiling.rows[end], tiling.plane]) @ VIEWS[side] for end in (0, -1))
    width, height, depth = growth.size(np.minimum(low, high), np.maximum(low, high))
    turn = f" r(0, {90 * side}, 0)" if side else ""
    size = f"{depth if side % 2 else width}, {height}, 1"
    position = ", ".join(growth.position(low))
    return f"[ t({position}){turn} t(0, 0, -1) {front_of_box(size, rule)} ]"


def _placed(growth: BuildingGrowth, low: Floats, high: Floats) -> tuple[str, str]:
    return ", ".join(growth.position(low)), ", ".join(growth.size(low, high))


def _fitting(axis: str, lines: KindSequence, rules: Sequence[str]) -> str:
    """A split into lines; the longest run, or a line in the middle without a door, is repeated as often as it fits."""
    words = [f"~{number(lines.size[kind], _DIGITS)} : {rules[kind]}" for kind in lines.kind]
    run = _repeat(lines)
    if run is not None:
        group = " | ".join(words[run.start : run.start + run.period])
        words[run.start : run.end] = [f"{{ {group} }}*"]
    return f"split({axis}) {{ {' | '.join(words)} }}"


def _repeat(lines: KindSequence) -> Repeat | None:
    runs = repeated_runs(lines.kind)
    if runs:
        return max(runs, key=lambda run: run.period * run.turns)
    free = [index for index, kind in enumerate(lines.kind) if not lines.doors[kind]]
    inner = [index for index in free if 0 < index < len(lines.kind) - 1] or free
    return Repeat(inner[len(inner) // 2], 1, 1) if inner else None


def _building_growth(main: Tiling, rows: KindSequence, storeys: Storeys) -> BuildingGrowth:
    """The growth of a building with the columns and rows of its main wall, which faces z.

    The two lowest rows and the highest one keep their sizes, as far as they occur in every facade.

    Args:
        main: the main wall of the building that the family is made from.
        rows: sequence of the kinds of rows of the main wall.
        storeys: the possible numbers of turns of its runs of rows.
    """
    lowest, highest = _fixed_rows(rows, storeys)
    columns, lines = main.columns, main.rows
    return BuildingGrowth(
        np.array([columns[0], lines[0], main.plane]),
        (
            Growth(0, float(columns[0]), float(columns[-1]), WIDTH, float(columns[-1] - columns[0])),
            Growth(1, float(lines[lowest]), float(lines[-1 - highest]), HEIGHT, float(lines[-1] - lines[0])),
        ),
    )


def _fixed_rows(rows: KindSequence, storeys: Storeys) -> tuple[int, int]:
    """Number of lowest and of highest rows that are the same in every facade."""
    num, fewest = len(rows.kind), len(rows.kind)
    below, above = num, num
    if storeys.runs:
        turns = [
            min(run.turns, *times) for run, times in zip(storeys.runs, zip(*storeys.times, strict=True), strict=True)
        ]
        first, last = storeys.runs[0], storeys.runs[-1]
        below = first.start + turns[0] * first.period
        above = num - last.end + turns[-1] * last.period
        fewest -= sum((run.turns - least) * run.period for run, least in zip(storeys.runs, turns, strict=True))
    lowest = max(0, min(2, below, fewest // 2))
    return lowest, max(0, min(1, above, fewest - 1 - lowest))
