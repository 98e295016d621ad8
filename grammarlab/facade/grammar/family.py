"""The family of a facade as a stochastic CGA grammar: columns and rows of its kinds in other numbers, on one grid.

Leaves are boxes or meshes, with the picture that they show in the facade. The facade is a member of its family: its own
columns and rows are derived for comparison, whether or not they are among the choices.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from collections.abc import Sequence as Listed
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import chain, pairwise
from math import isfinite

import numpy as np

from grammarlab.errors import FacadeError
from grammarlab.facade.grammar.bands import Repeat
from grammarlab.facade.grammar.contents import ON_AREA, Cell, PictureWindow, picture_on, window_over
from grammarlab.facade.grammar.derived_errors import member_error
from grammarlab.facade.grammar.leaf_looks import OutlinedLeaf, outlined_leaf, picture_file, window_projection
from grammarlab.facade.grammar.rule_text import (
    RuleNames,
    front_of_box,
    leaf_body,
    nested,
    number,
    renamed,
    round_percentages,
    rule_name,
    split_body,
    top_down,
)
from grammarlab.facade.grammar.storeys import Storeys, floor_names, storeys_of
from grammarlab.facade.grammar.walks import (
    LONGEST,
    KindPattern,
    KindSequence,
    Walks,
    WalkState,
    WalkStep,
    equal_futures,
    narrowest,
    pattern_of,
    walks,
)
from grammarlab.facade.looks import THICKNESS, is_door, look_of
from grammarlab.facade.tree import LEAF, Facade, X, Y
from grammarlab.language.formatting import format_grammar
from grammarlab.language.grammar import Grammar

_Outline = tuple[tuple[float, float], ...]
STRETCH = 0.05
"""Largest relative difference of equal elements in the facade; in its family they have one size."""
_DIGITS = 6
Range = tuple[float, float]
"""Least and largest, metres."""
WIDTH, HEIGHT = "facadeWidth", "facadeHeight"
"""Attributes with the size of a facade, metres, for the rules around it."""


@dataclass(frozen=True, slots=True)
class WrittenFamily:
    """A grammar of a family."""

    text: str
    """CGA text."""
    rules: int
    columns: dict[int, Range]
    """Least and largest width of facades in metres, by number of columns."""
    rows: dict[str, Range]
    """Least and largest number of turns of a run of rows, by attribute."""
    facades: float
    """Number of different facades."""
    error: float | None = None
    """Largest difference of the sides of elements, metres, in the derivation of the facade's own columns and rows, even
    if these are not among the choices; None for a pattern, and if elements are too thin for the rules."""
    outlined: tuple[OutlinedLeaf, ...] = ()
    """Leaves whose meshes the grammar refers to."""


@dataclass(frozen=True, slots=True)
class Around:
    """A building around the facades of a family: rules that follow the width and height of each facade."""

    start: str
    """CGA before the facade: a move from the corner of the lot to the lower left corner of the facade."""
    rule: str
    """Rule that makes the building; its scope is at the lower right corner of the facade."""
    lines: tuple[str, ...]
    """This rule and others; their sizes may contain the attributes `WIDTH` and `HEIGHT`."""
    names: RuleNames
    """Names of all these rules."""


def write_family(facade: Facade, widths: Range, heights: Range, stretch: float = STRETCH) -> WrittenFamily:
    """The family of a facade, as rules whose every derivation is a facade of the same grid.

    First the storeys are drawn, then one column after the other; so all columns have the same rows, and all rows the
    same columns. Elements have their sizes in the facade, and so have the walls between them (their mean if they vary):
    the width and height of a facade follow from the draws. Each element has the outline, and shows the part of the
    picture, of the first of its kind.

    Args:
        facade: the facade.
        widths: least and largest width, metres.
        heights: least and largest height, metres.
        stretch: largest relative difference of equal elements in the facade, 0 to 1.

    Raises:
        FacadeError: If no such facade is within these ranges; the message has the possible sizes.
    """
    pattern = pattern_of(facade, stretch)
    storeys, column_walks = _storeys_and_walks(pattern, widths, heights)
    leaves = _FacadeLeaves(facade)
    written = _FamilyWriter(
        pattern=pattern,
        storeys=storeys,
        walks=column_walks,
        leaf=leaves.body,
        projection=leaves.projection,
        start=leaves.common_picture,
    ).write()
    error = _own_error(facade, pattern, storeys, column_walks)
    return replace(written, error=error, outlined=leaves.outlined)


def write_pattern(
    pattern: KindPattern, widths: Range, heights: Range, leaf: Callable[[Cell], str], around: Around | None = None
) -> WrittenFamily:
    """The family of a pattern of columns and rows.

    Args:
        pattern: the pattern.
        widths: least and largest width, metres.
        heights: least and largest height, metres.
        leaf: function that makes the CGA of an element.
        around: rules of a building around each facade.

    Raises:
        FacadeError: If no such facade is within these ranges; the message has the possible sizes.
    """
    storeys, column_walks = _storeys_and_walks(pattern, widths, heights)
    names = RuleNames() if around is None else around.names
    return _FamilyWriter(
        pattern=pattern,
        storeys=storeys,
        walks=column_walks,
        leaf=leaf,
        start="" if around is None else around.start,
        around=around,
        names=names,
    ).write()


def _storeys_and_walks(pattern: KindPattern, widths: Range, heights: Range) -> tuple[Storeys, Walks]:
    """Storeys and walks of these sizes."""
    storeys = storeys_of(pattern.rows, *heights)
    column_walks = walks(pattern.columns, *widths)
    if column_walks is None:
        possible = narrowest(pattern.columns, widths[1])
        reason = "it has no window and no door"
        if possible:
            low, high = min(possible), max(possible)
            reason = f"its columns make widths from {low:.4g} m to {high:.4g} m, with at most {LONGEST} columns"
        raise FacadeError(f"no facade of this family is {widths[0]:g} to {widths[1]:g} m wide: {reason}.")
    return storeys, column_walks


@dataclass(frozen=True, slots=True)
class _FacadeLeaves:
    """Writer of the leaves of a facade. Each leaf lays its own window of the picture on its box."""

    facade: Facade
    meshes: dict[_Outline, OutlinedLeaf | None] = field(default_factory=dict)
    """Mesh by outline; None for an outline that is written as its box."""

    def body(self, cell: Cell) -> str:
        """The operations that make a thing, which has no parts."""
        is_on_area = cell.shows == ON_AREA
        setup = self.projection(cell.shows) if cell.shows and not is_on_area else ""
        if cell.outline not in self.meshes:
            self.meshes[cell.outline] = outlined_leaf(np.array(cell.outline)) if cell.outline else None
        mesh, pictured = self.meshes[cell.outline], is_on_area or bool(setup)
        body = mesh.body(cell.label, pictured=pictured) if mesh else leaf_body(cell.label, pictured=pictured)
        return f"{setup} {body}".lstrip()

    @property
    def outlined(self) -> tuple[OutlinedLeaf, ...]:
        """Those whose meshes the rules refer to."""
        return tuple(mesh for mesh in self.meshes.values() if mesh)

    @property
    def common_picture(self) -> str:
        """The operation that takes the picture that all leaves show a part of; empty if some show none or another."""
        facade = self.facade
        shown = set(facade.picture[facade.leaves].tolist())
        return f'texture("{picture_file(facade, 0)}")' if shown == {0} else ""

    def projection(self, shows: PictureWindow, size: tuple[float, float] | None = None) -> str:
        """The operations that project a window of a picture on a rectangle; empty if it has no area.

        Args:
            shows: the window.
            size: width and height of the rectangle, metres; any if left out.
        """
        low, high = np.array(shows.low), np.array(shows.high)
        projection = window_projection(low, high - low, _DIGITS, None if size is None else np.array(size))
        if not projection or self.common_picture:
            return projection
        return f'texture("{picture_file(self.facade, shows.picture)}") {projection}'


@dataclass
class _FamilyWriter:
    """The text of a family, rule by rule."""

    pattern: KindPattern
    storeys: Storeys
    walks: Walks
    leaf: Callable[[Cell], str]
    projection: Callable[[PictureWindow, tuple[float, float]], str] = lambda _, __: ""
    """Function that makes the CGA that projects a window of a picture on an area of this width and height."""
    start: str = ""
    """CGA before the facade."""
    around: Around | None = None
    names: RuleNames = field(default_factory=RuleNames)
    lines: list[str] = field(default_factory=list)
    rules: dict[str, str] = field(default_factory=dict)
    """Bodies of the rules of columns and all that is in them, by name."""
    part_names: dict[str, list[str]] = field(default_factory=dict)
    """Names of areas and of cells with parts, by what they are called without a number."""
    cells: dict[Cell, str] = field(default_factory=dict)
    bays: dict[str, str] = field(default_factory=dict)
    """Rules of piers with the column after them, by their text."""
    areas: dict[str, str] = field(default_factory=dict)
    """Rules of areas of one picture, by their text."""
    labels: dict[str, str] = field(default_factory=dict)
    """Labels of leaves by symbol."""

    def write(self) -> WrittenFamily:
        attributes = [self._attribute(run.start, run.end) for run in self.storeys.runs]
        for name, run in zip(attributes, self.storeys.runs, strict=True):
            self.lines.append(f"attr {name} = {run.turns}")
        if self.around:
            self.lines += [f"attr {WIDTH} = 0", f"attr {HEIGHT} = 0"]
        self.lines.append("@StartRule")
        self.lines.append(f"Lot --> {self.start} {front_of_box(f'1, 1, {THICKNESS}', 'Storeys')}")
        for name in ("Storeys", "Columns"):
            self.names.new(name)
        columns = self._column_names()
        states = self._state_names(columns)
        self._add_storeys(attributes)
        first = self._placed(columns, self.walks.before, self.walks.start.kind)
        self.lines.append(f"Columns --> {self._height(attributes)} {first} {states[self.walks.start]}")
        for state in dict.fromkeys(self._equal_states().values()):
            self._add_state(state, states, columns)
        self.lines += [f"{name} --> {body}" for body, name in self.bays.items()]
        for name, kind in {name: kind for kind, name in columns.items()}.items():
            self.rules[name] = self._column_body(name, kind, attributes)
        self.lines += [f"{name} --> {body}" for name, body in self._readable_rules(columns.values()).items()]
        self.lines += self.around.lines if self.around else ()
        text = format_grammar(Grammar.parse("\n".join([self._title(), 'version "2023.0"', *self.lines])))
        times = list(zip(*self.storeys.times, strict=True))
        rows = {name: (min(counts), max(counts)) for name, counts in zip(attributes, times, strict=True)}
        num = len(self.storeys.times) * self.walks.total
        return WrittenFamily(
            text=text, rules=len(Grammar.parse(text).rules), columns=self.walks.sizes, rows=rows, facades=num
        )

    def _readable_rules(self, columns: Iterable[str]) -> dict[str, str]:
        """Rules of columns from the whole to its parts: what is used once is in its place, the others are numbered."""
        rules = nested(self.rules, chain.from_iterable(self.part_names.values()))
        rules = top_down(rules, columns)
        order = {name: index for index, name in enumerate(rules)}
        numbered: dict[str, str] = {}
        for names in self.part_names.values():
            written = sorted((name for name in names if name in order), key=lambda name: order[name])
            numbered |= zip(written, names, strict=False)
        return {numbered.get(name, name): renamed(body, numbered) for name, body in rules.items()}

    def _part_name(self, preferred: str) -> str:
        """A new name of a rule that `_readable_rules` may write in its place or number again."""
        name = self.names.new(preferred)
        self.part_names.setdefault(preferred, []).append(name)
        return name

    def _title(self) -> str:
        sizes = [size for lengths in self.walks.sizes.values() for size in lengths]
        columns, heights = self.walks.sizes, self.storeys.heights
        wide, high = (f"{min(lengths):.4g} to {max(lengths):.4g} m" for lengths in (sizes, heights))
        things = "buildings, main walls" if self.around else "facades"
        return f"// A family of {things} with {min(columns)} to {max(columns)} columns, {wide} wide and {high} high"

    @cached_property
    def floors(self) -> dict[int, str]:
        """Names of the rows with windows or doors."""
        return floor_names(self.pattern.rows, self.pattern.cells)

    def _add_storeys(self, attributes: Listed[str]) -> None:
        """The rule that draws the numbers of turns; all are equally likely, to the percent."""
        ways = [
            "".join(f"set({name}, {turns}) " for name, turns in zip(attributes, times, strict=True)) + "Columns"
            for times in self.storeys.times
        ]
        self.lines.append(_choice("Storeys", [1.0 / len(ways)] * len(ways), ways))

    def _height(self, attributes: Listed[str]) -> str:
        """CGA that gives the scope the height of the drawn rows."""
        rows = self.pattern.rows
        turns = [
            sum(rows.size[kind] for kind in rows.kind[run.start : run.start + run.period]) for run in self.storeys.runs
        ]
        fixed = sum(rows.size[kind] for kind in rows.kind) - sum(
            run.turns * size for run, size in zip(self.storeys.runs, turns, strict=True)
        )
        terms = [number(fixed, _DIGITS)] if number(fixed, _DIGITS) != "0" else []
        terms += [f"{name} * {number(size, _DIGITS)}" for name, size in zip(attributes, turns, strict=True)]
        height = " + ".join(terms)
        if self.around:
            return f"set({HEIGHT}, {height}) s('1, {HEIGHT}, 0)"
        return f"s('1, {height}, 0)"

    def _add_state(self, state: WalkState, states: dict[WalkState, str], columns: dict[int, str]) -> None:
        ways = [
            f"{self._placed(columns, step.gap, step.to.kind)} {states[step.to]}" for step in self.walks.steps[state]
        ]
        probabilities = [step.probability for step in self.walks.steps[state]]
        if state in self.walks.end:
            after = self.walks.after
            if self.around:
                ways.append(f"{self._placed(columns, after, -1)} {self.around.rule}")
            else:
                ways.append(self._box(columns[after], self.pattern.columns.size[after]) if after >= 0 else "NIL")
            probabilities.append(self.walks.end[state])
        self.lines.append(_choice(states[state], probabilities, ways))

    def _placed(self, columns: dict[int, str], gap: int, kind: int) -> str:
        """A pier and a column, side by side, and a move to the end of both."""
        kinds = [each for each in (gap, kind) if each >= 0]
        if not kinds:
            return ""
        sizes = [self.pattern.columns.size[each] for each in kinds]
        body = f"[ {self._box(columns[kinds[0]], sizes[0])} ]" if len(kinds) == 1 else self._bay(columns, gap, kind)
        length = number(sum(round(size, _DIGITS) for size in sizes), _DIGITS)
        return f"{body} t({length}, 0, 0)" + (f" set({WIDTH}, {WIDTH} + {length})" if self.around else "")

    def _bay(self, columns: dict[int, str], gap: int, kind: int) -> str:
        """The rule of a pier and a column."""
        width, other = (number(self.pattern.columns.size[each], _DIGITS) for each in (gap, kind))
        body = f"s({width} + {other}, '1, 0) split(x) {{ {width} : {columns[gap]} | {other} : {columns[kind]} }}"
        if body not in self.bays:
            self.bays[body] = self.names.new(columns[kind].replace("Column", "Bay"))
        return self.bays[body]

    def _box(self, name: str, size: float) -> str:
        return f"s({number(size, _DIGITS)}, '1, 0) {name}"

    def _column_names(self) -> dict[int, str]:
        """The rules of the kinds of columns that occur."""
        kinds = dict.fromkeys(self.pattern.columns.kind)
        name_of_cells: dict[tuple[Cell, ...], str] = {}
        for kind in kinds:
            cells = tuple(row[kind] for row in self.pattern.cells)
            if cells not in name_of_cells:
                has_elements = self.pattern.columns.has_elements[kind]
                name_of_cells[cells] = self.names.new(self._name(cells, "Column") if has_elements else "Pier")
        return {kind: name_of_cells[tuple(row[kind] for row in self.pattern.cells)] for kind in kinds}

    def _state_names(self, columns: dict[int, str]) -> dict[WalkState, str]:
        """The name of each state: the number of columns so far, and of doors among them.

        Where the last column decides how walks go on, it is part of the name. States with equal futures have one name.
        """
        first = self._equal_states()
        short = {state: self._state_name(state) for state in dict.fromkeys(first.values())}
        names: dict[WalkState, str] = {}
        for state, name in short.items():
            is_clear = list(short.values()).count(name) == 1
            names[state] = self.names.new(name if is_clear else name + columns[state.kind].replace("Column", ""))
        return {state: names[first[state]] for state in first}

    def _equal_states(self) -> dict[WalkState, WalkState]:
        """The state whose rule is that of each state; probabilities are compared as they are written."""
        return equal_futures(self.walks, self.pattern.columns.doors, round_percentages)

    def _state_name(self, state: WalkState) -> str:
        if not state.doors:
            return f"After{state.columns}"
        where = "At" if self.pattern.columns.doors[state.kind] else "Past"
        return f"After{state.columns}{where}{f'{state.doors}Doors' if state.doors > 1 else 'Door'}"

    def _attribute(self, start: int, end: int) -> str:
        kinds = self.pattern.rows.kind[start:end]
        name = self._name([cell for kind in kinds for cell in self.pattern.cells[kind]], "Rows")
        return self.names.new(name[:1].lower() + name[1:])

    def _name(self, cells: Listed[Cell], what: str) -> str:
        """A name for cells: by the most important element in them."""
        things = {thing for cell in cells for thing in cell.things()}
        standing = sorted(thing for thing in things if not look_of(thing).is_flexible)
        telling = [thing for thing in standing if look_of(thing).glazed] or standing
        chosen = ([thing for thing in standing if is_door(thing)] or telling or ["wall"])[0]
        return f"{rule_name(chosen)}{what}"

    def _column_body(self, name: str, kind: int, attributes: Listed[str]) -> str:
        """The rows of a kind of column from the bottom up."""
        parts: list[tuple[list[str], str]] = []
        runs = {run.start: run for run in self.storeys.runs}
        attribute = dict(zip(runs, attributes, strict=True))
        for start, end in self._areas(kind, runs):
            rows = self._rows(name, kind, start, end)
            if start not in runs:
                for size, rule in rows:
                    self._append(parts, size, rule)
                continue
            height = sum(self.pattern.rows.size[row] for row in self.pattern.rows.kind[start:end])
            rule = rows[0][1]
            if any(other != rule for _, other in rows) or not self._stretches(rule):
                group = " | ".join(f"{size} : {other}" for size, other in rows)
                rule = f"split(y) {{ {{ {group} }}* }}"
            self._append(parts, f"{attribute[start]} * {number(height, _DIGITS)}", rule)
        return self._stack(parts)

    def _rows(self, name: str, kind: int, start: int, end: int) -> list[tuple[str, str]]:
        """Sizes and rules of rows of a column: one if a picture goes on over them."""
        if area := self._area(name, kind, start, end):
            height = sum(round(self.pattern.rows.size[row], _DIGITS) for row in self.pattern.rows.kind[start:end])
            return [(number(height, _DIGITS), area)]
        if end - start > 1:
            return [row for index in range(start, end) for row in self._rows(name, kind, index, index + 1)]
        row = self.pattern.rows.kind[start]
        return [(self._row_size(row), self._cell(row, kind))]

    def _stack(self, parts: list[tuple[list[str], str]]) -> str:
        """Parts from the bottom up, each with the terms of its size."""
        if len(parts) == 1:
            return parts[0][1]
        is_only_flexible = sum(self._is_flexible(rule) for _, rule in parts) == 1
        named = [
            ("~1" if is_only_flexible and self._is_flexible(rule) else " + ".join(sizes), rule) for sizes, rule in parts
        ]
        return split_body("y", named, repeats=False)

    def _areas(self, kind: int, runs: dict[int, Repeat]) -> list[tuple[int, int]]:
        """First and last row, exclusive, of the areas of a column on which one picture goes on.

        A run of rows is represented by its first turn; rows without such a picture are areas of their own.
        """
        areas: list[tuple[int, int]] = []
        position, num = 0, len(self.pattern.rows.kind)
        while position < num:
            if position in runs:
                run = runs[position]
                areas.append((position, position + run.period))
                position = run.end
                continue
            end = position + 1
            while end < num and end not in runs and self._window(kind, position, end + 1):
                end += 1
            areas.append((position, end))
            position = end
        return areas

    def _window(self, kind: int, start: int, end: int) -> PictureWindow | None:
        """The window of a picture that goes on over rows of a column; None if there is none."""
        rows = self.pattern.rows
        windows = []
        for row in rows.kind[start:end]:
            cell = self.pattern.cells[row][kind]
            is_sized = not any(
                cell.is_split(axis) and lines.is_mean(index)
                for axis, lines, index in ((X, self.pattern.columns, kind), (Y, rows, row))
            )
            windows.append((rows.size[row], picture_on(cell) if is_sized else None))
        return window_over(windows, Y)

    def _area(self, column: str, kind: int, start: int, end: int) -> str:
        """The rule of rows of a named column with the picture that goes on over them, or nothing if there is none."""
        window = self._window(kind, start, end)
        height = sum(self.pattern.rows.size[row] for row in self.pattern.rows.kind[start:end])
        projection = self.projection(window, (self.pattern.columns.size[kind], height)) if window else ""
        if not projection:
            return ""
        parts: list[tuple[list[str], str]] = []
        cells = [self.pattern.cells[row][kind].on_area() for row in self.pattern.rows.kind[start:end]]
        for row, cell in zip(self.pattern.rows.kind[start:end], cells, strict=True):
            self._append(parts, self._row_size(row), self._rule_of(cell))
        body = f"{projection} {self._stack(parts)}"
        if body not in self.areas:
            floors = [floor for row, floor in self.floors.items() if start <= row < end]
            where = "To".join(dict.fromkeys([floors[0], floors[-1]])) if floors else self._name(cells, "")
            self.areas[body] = self._part_name(f"{column}{where}")
            self.rules[self.areas[body]] = body
        return self.areas[body]

    def _append(self, parts: list[tuple[list[str], str]], size: str, rule: str) -> None:
        """Appends a part of a column; adjacent walls are merged."""
        if parts and parts[-1][1] == rule and self._stretches(rule):
            parts[-1][0].append(size)
        else:
            parts.append(([size], rule))

    def _is_flexible(self, rule: str) -> bool:
        return any(
            name == rule and cell.axis == LEAF and look_of(cell.label).is_flexible for cell, name in self.cells.items()
        )

    def _stretches(self, rule: str) -> bool:
        """Whether several such rows are one: walls without a picture of their own, which would be stretched."""
        return self._is_flexible(rule) and not any(
            cell.shows not in (None, ON_AREA) for cell, name in self.cells.items() if name == rule
        )

    def _row_size(self, row: int) -> str:
        return number(self.pattern.rows.size[row], _DIGITS)

    def _cell(self, row: int, column: int) -> str:
        return self._rule_of(self.pattern.cells[row][column])

    def _rule_of(self, cell: Cell) -> str:
        """The rule of a cell, written at its first use."""
        if cell not in self.cells:
            if cell.axis == LEAF:
                self.cells[cell] = name = self.names.new(rule_name(cell.label))
                body, terminal = self.leaf(cell), name
                if cell.outline:
                    # What follows a part of its own is a leaf without a name.
                    terminal = self.names.new(f"{name}Shape")
                    body += f" {terminal}."
                self.labels[terminal] = cell.label
                self.rules[name] = body
            else:
                self.cells[cell] = name = self._part_name(self._name([cell], "Cell"))
                floats = [part.can_stretch(cell.axis) for _, part in cell.parts]
                sizes = [
                    (("~" if floating or not any(floats) else "") + number(size, _DIGITS), self._rule_of(part))
                    for floating, (size, part) in zip(floats, cell.parts, strict=True)
                ]
                self.rules[name] = split_body("xy"[cell.axis], sizes)
        return self.cells[cell]


def _choice(name: str, probabilities: Listed[float], ways: Listed[str]) -> str:
    """A rule with alternatives of about the given probabilities, which are written as round percentages."""
    if len(ways) == 1:
        return f"{name} --> {ways[0]}"
    *first, last = zip(round_percentages(probabilities), ways, strict=True)
    lines = [f"{percentage}% : {way}" for percentage, way in first]
    return f"{name} -->\n" + "\n".join([*lines, f"else : {last[1]}"])


def _own_error(facade: Facade, pattern: KindPattern, storeys: Storeys, column_walks: Walks) -> float | None:
    leaves = _FacadeLeaves(facade)
    own_storeys, own_walks = _own_member(pattern, storeys, column_walks)
    writer = _FamilyWriter(
        pattern=pattern,
        storeys=own_storeys,
        walks=own_walks,
        leaf=leaves.body,
        projection=leaves.projection,
        start=leaves.common_picture,
    )
    error = member_error(facade, pattern, Grammar.parse(writer.write().text), writer.labels, leaves.outlined)
    return error if isfinite(error) else None


def _own_member(pattern: KindPattern, storeys: Storeys, walks: Walks) -> tuple[Storeys, Walks]:
    """The choices of a family restricted to those of the original facade."""
    times = tuple(run.turns for run in storeys.runs)
    height = sum(pattern.rows.size[kind] for kind in pattern.rows.kind)
    return Storeys(storeys.runs, (times,), (height,)), _own_walk(pattern.columns, walks)


def _own_walk(columns: KindSequence, walks: Walks) -> Walks:
    states, gaps, gap, doors = [], [], -1, 0
    for kind in columns.kind:
        if not columns.has_elements[kind]:
            gap = kind
            continue
        doors += columns.doors[kind]
        states.append(WalkState(kind, doors, len(states) + 1))
        gaps.append(gap)
        gap = -1
    steps = {
        state: (WalkStep(1.0, between, to),) for (state, to), between in zip(pairwise(states), gaps[1:], strict=True)
    }
    size = sum(columns.size[kind] for kind in columns.kind)
    end = states[-1]
    return Walks(
        before=walks.before,
        after=walks.after,
        start=states[0],
        steps=steps | {end: ()},
        end={end: 1.0},
        sizes={end.columns: (size, size)},
        total=1.0,
    )
