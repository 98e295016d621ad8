"""From the tables of a species file to a species, with findings about every mistake."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Mapping
from dataclasses import replace
from difflib import get_close_matches
from pathlib import PurePath
from typing import Any, NamedTuple

import numpy as np

from grammarlab.arrays import Floats
from grammarlab.errors import Finding, shown
from grammarlab.trees.parameters import COLUMN, COLUMNS, DEFAULTS, HIGH, IS_INTEGER, LOW, PARAMETERS, SPREAD, Parameter
from grammarlab.trees.species import Kind, Look, Species
from grammarlab.trees.species_places import Path, Places

SECTIONS = ("tree", "trunk", "level_1", "level_2", "level_3", "leaves")
"""Headings of the parameters; they order the file and mean nothing."""
MOST_KINDS = 256
MOST_FINDINGS = 50
"""Findings after which reading ends."""
_MOST_CHARACTERS = 20_000
"""Largest number of characters of a text; of an expression also `grammarlab.features.expression.MAX_CHARACTERS`."""
_ENTRIES = ("value", "spread", "range", "spread_range", "unit", "why")
_KIND_ENTRIES = ("weight", "means", "ranges")
_PICTURES = ("bark", "leaf", "blossom")
_COLORS = ("bark_color", "leaf_color", "blossom_color")
_OTHERS = ("about", "look", "kinds", "acceptance")


class TooManyFindings(Exception):  # noqa: N818  # it ends reading
    """`MOST_FINDINGS` findings."""


class Fault(NamedTuple):
    """Why a value is refused."""

    code: str
    message: str
    hint: str


def column_value(column: str, value: object, label: str) -> tuple[float | None, Fault | None]:
    """The number of a value of a column, or why it cannot have it.

    Args:
        column: one of `COLUMNS`.
        value: a value of a file.
        label: what the file calls the column.
    """
    index = COLUMN[column]
    hint = f"{_interval(LOW[index], HIGH[index], _unit(column))}; {_meaning(column)}"
    if isinstance(value, bool) or not isinstance(value, int | float):
        return None, Fault("wrong-type", f"expected a number for {label}, found {shown(value)}", hint)
    if not math.isfinite(value):
        return None, Fault("not-finite", f"expected a finite number for {label}, found {value}", hint)
    if IS_INTEGER[index] and value != math.floor(value):
        return None, Fault("not-whole", f"expected a whole number for {label}, found {value:g}", hint)
    if not LOW[index] <= value <= HIGH[index]:
        interval = _interval(LOW[index], HIGH[index], _unit(column))
        return None, Fault("out-of-range", f"expected {label} within {interval}, found {value:g}", _meaning(column))
    return float(value), None


class SpeciesTables:
    """A reader of the tables of one species file.

    Args:
        table: the whole file.
        places: places of its values.
    """

    def __init__(self, table: Mapping[str, Any], places: Places) -> None:
        self._table = table
        self._places = places
        self.findings: list[Finding] = []
        self.paths: dict[str, Path] = {}
        """Path of each parameter that the file names."""

    def species(self, name: str) -> Species:
        """The species; it means nothing if there are findings."""
        entries = dict(self._entries())
        typical, low, high = DEFAULTS.copy(), DEFAULTS.copy(), DEFAULTS.copy()
        why: dict[str, str] = {}
        for parameter, entry in entries.items():
            self._read_parameter(PARAMETERS[parameter], entry, (typical, low, high), why)
        return Species(
            name=name,
            kinds=self._kinds(low, high),
            typical=typical,
            look=self._look(),
            about=self._text((), self._table, "about"),
            why=why,
            acceptance=self._text((), self._table, "acceptance"),
        )

    def report(self, code: str, message: str, path: Path, hint: str = "", *, at_key: bool = False) -> None:
        """Add an error.

        Raises:
            TooManyFindings: If there are too many.
        """
        place = self._places.of_key(path) if at_key else self._places.of_value(path)
        self.findings.append(Finding("error", code, message, place, hint))
        if len(self.findings) >= MOST_FINDINGS:
            raise TooManyFindings

    def _entries(self) -> Iterator[tuple[str, Any]]:
        """Names and values of the parameters of all sections."""
        for key, value in self._table.items():
            if key in _OTHERS:
                continue
            if key in SECTIONS and isinstance(value, dict) and not _is_entry(key, value):
                for name, entry in value.items():
                    yield from self._entry((key, name), entry)
            else:
                yield from self._entry((key,), value)

    def _entry(self, path: Path, entry: object) -> Iterator[tuple[str, Any]]:
        name = str(path[-1])
        if name not in PARAMETERS:
            names = PARAMETERS if len(path) > 1 else (*PARAMETERS, *SECTIONS, *_OTHERS)
            hint = _nearest(name, names)
            if name.endswith(SPREAD) and name in COLUMN:
                hint = f"write it as the spread of {name.removesuffix(SPREAD)}"
            self.report("unknown-name", f"no parameter is called {shown(name)}", path, hint, at_key=True)
        elif name in self.paths:
            self.report("repeated", f"{name} has a value already", path, "delete one of them", at_key=True)
        else:
            self.paths[name] = path
            yield name, entry

    def _read_parameter(
        self, parameter: Parameter, entry: object, columns: tuple[Floats, Floats, Floats], why: dict[str, str]
    ) -> None:
        path = self.paths[parameter.name]
        path_of: dict[str, Path] = {key: (*path, key) if isinstance(entry, dict) else path for key in _ENTRIES}
        if not isinstance(entry, dict):
            entry = {"value": entry}
        else:
            self._check_keys(entry, _ENTRIES, path, parameter)
        if "value" not in entry:
            self.report("missing", f"expected {parameter.name} to have a value", path, _expected(parameter.name))
        self._read_column(parameter.name, entry, ("value", "range"), path_of, columns)
        if parameter.spread is not None:
            self._read_column(parameter.name + SPREAD, entry, ("spread", "spread_range"), path_of, columns)
        if (unit := entry.get("unit", parameter.unit)) != parameter.unit:
            expected = f'"{parameter.unit}"' if parameter.unit else "no unit"
            self.report("wrong-unit", f"expected {expected} for {parameter.name}, found {shown(unit)}", path_of["unit"])
        if "why" in entry and (reason := self._text(path, entry, "why")):
            why[parameter.name] = reason

    def _check_keys(self, entry: dict[str, Any], known: Collection[str], path: Path, parameter: Parameter) -> None:
        for key in entry:
            if key not in known:
                message = f"{parameter.name} has no entry {shown(key)}"
                self.report("unknown-name", message, (*path, key), _nearest(key, known), at_key=True)
            elif key.startswith("spread") and parameter.spread is None:
                message = f"{parameter.name} has no spread"
                self.report("no-spread", message, (*path, key), "give it a range instead", at_key=True)

    def _read_column(
        self,
        column: str,
        entry: dict[str, Any],
        keys: tuple[str, str],
        paths: Mapping[str, Path],
        columns: tuple[Floats, Floats, Floats],
    ) -> None:
        """The typical value and the range of a column, into arrays [P]."""
        index, (key, range_key) = COLUMN[column], keys
        value = self._number(column, entry[key], paths[key]) if key in entry else None
        bounds = self._range(column, entry[range_key], paths[range_key]) if range_key in entry else None
        if value is None:
            value = float(np.clip(DEFAULTS[index], *(bounds or (-np.inf, np.inf))))
        elif bounds and not bounds[0] <= value <= bounds[1]:
            message = f"expected the value of {column} within its range, {_interval(*bounds)}, found {value:g}"
            self.report("outside-own-range", message, paths[key], "change the value or the range")
        for array, number in zip(columns, (value, *(bounds or (value, value))), strict=True):
            array[index] = number

    def _number(self, column: str, value: object, path: Path) -> float | None:
        """A value of a column; None, with a finding, if it cannot be one."""
        number, fault = column_value(column, value, column)
        if fault:
            self.report(fault.code, fault.message, path, fault.hint)
        return number

    def _range(self, column: str, value: object, path: Path) -> tuple[float, float] | None:
        """A range of a column, also from one number; None, with a finding, if it is wrong."""
        if isinstance(value, int | float):
            value = [value, value]
        if not isinstance(value, list) or len(value) != 2:
            message = f"expected a range of {column} such as {_example(column)}, found {shown(value)}"
            self.report("wrong-type", message, path, _expected(column))
            return None
        low, high = (self._number(column, end, path) for end in value)
        if low is None or high is None:
            return None
        if low > high:
            message = f"expected a range of {column} from the smaller to the larger number, found {low:g} to {high:g}"
            self.report("reversed-range", message, path, f"write [{value[1]}, {value[0]}]")
            return None
        return low, high

    def _kinds(self, low: Floats, high: Floats) -> tuple[Kind, ...]:
        kinds = self._table.get("kinds", [{}])
        if not isinstance(kinds, list) or not 1 <= len(kinds) <= MOST_KINDS:
            message = f"expected 1 to {MOST_KINDS} tables [[kinds]], found {shown(kinds)}"
            self.report("wrong-type", message, ("kinds",))
            return ()
        weights = [self._weight(index, kind) for index, kind in enumerate(kinds)]
        total = math.fsum(weights)
        if math.isclose(total, 1.0, rel_tol=1e-9):  # so that a file that is written again keeps every digit
            total = 1.0
        return tuple(
            self._kind(index, kind, weight / total, low, high)
            for index, (kind, weight) in enumerate(zip(kinds, weights, strict=True))
            if isinstance(kind, dict)
        )

    def _weight(self, index: int, kind: object) -> float:
        weight = kind.get("weight", 1.0) if isinstance(kind, dict) else kind
        if isinstance(weight, bool) or not isinstance(weight, int | float) or not 1e-12 <= weight <= 1e12:
            message = f"expected the weight of a kind, a number above 0, found {shown(weight)}"
            self.report("weight", message, ("kinds", index, "weight"), "delete a kind that should not occur")
            return 1.0
        return float(weight)

    def _kind(self, index: int, kind: dict[str, Any], weight: float, low: Floats, high: Floats) -> Kind:
        path: Path = ("kinds", index)
        for key in kind:
            if key not in _KIND_ENTRIES:
                message = f"a kind has no entry {shown(key)}"
                self.report("unknown-name", message, (*path, key), _nearest(key, _KIND_ENTRIES), at_key=True)
        low, high = low.copy(), high.copy()
        ranges = kind.get("ranges", {})
        if not isinstance(ranges, dict):
            self.report("wrong-type", f"expected a table of ranges, found {shown(ranges)}", (*path, "ranges"))
            ranges = {}
        for column, value in ranges.items():
            place = (*path, "ranges", column)
            if column not in COLUMN:
                message = f"no parameter is called {shown(column)}"
                self.report("unknown-name", message, place, _nearest(column, COLUMNS), at_key=True)
            elif bounds := self._range(column, value, place):
                low[COLUMN[column]], high[COLUMN[column]] = bounds
        return Kind(weight, low, high, self._text(path, kind, "means"))

    def _look(self) -> Look:
        look = self._table.get("look", {})
        if not isinstance(look, dict):
            self.report("wrong-type", f"expected a table [look], found {shown(look)}", ("look",))
            return Look()
        for key in look:
            if key not in (*_PICTURES, *_COLORS):
                message = f"[look] has no entry {shown(key)}"
                hint = _nearest(key, (*_PICTURES, *_COLORS))
                self.report("unknown-name", message, ("look", key), hint, at_key=True)
        pictures = {key: self._picture(look, key) for key in _PICTURES}
        colors = {key: color for key in _COLORS if key in look and (color := self._color(key, look[key]))}
        return replace(replace(Look(), **pictures), **colors)

    def _picture(self, look: dict[str, Any], key: str) -> str:
        path = self._text(("look",), look, key)
        parts = PurePath(path).parts
        if path.startswith("/") or ".." in parts or "\\" in path or ":" in path:
            message = f"expected the path of a picture below the asset folder, found {shown(path)}"
            self.report("outside-folder", message, ("look", key), 'such as bark = "oak/bark.png"')
        return path

    def _color(self, key: str, value: object) -> tuple[float, float, float] | None:
        if isinstance(value, str) and len(value) == 7 and value[0] == "#":
            try:
                red, green, blue = bytes.fromhex(value[1:])
            except ValueError:
                pass
            else:
                return red / 255, green / 255, blue / 255
        if isinstance(value, list) and len(value) == 3 and all(_is_share(item) for item in value):
            return float(value[0]), float(value[1]), float(value[2])
        message = f"expected a color, found {shown(value)}"
        self.report("wrong-type", message, ("look", key), 'such as "#5c4836", or three numbers from 0 to 1')
        return None

    def _text(self, path: Path, table: Mapping[str, Any], key: str) -> str:
        """A text; empty if it is missing."""
        value = table.get(key, "")
        if not isinstance(value, str) or len(value) > _MOST_CHARACTERS:
            message = f"expected {key} = a text of at most {_MOST_CHARACTERS:,} characters, found {shown(value)}"
            self.report("wrong-type", message, (*path, key))
            return ""
        return value


def _is_entry(key: str, value: dict[str, Any]) -> bool:
    """Whether a table is the parameter ``leaves``, not the section of that name."""
    return key in PARAMETERS and "value" in value


def _is_share(value: object) -> bool:
    return not isinstance(value, bool) and isinstance(value, int | float) and 0.0 <= value <= 1.0


def _nearest(name: str, names: Collection[str]) -> str:
    near = get_close_matches(name, names, n=3, cutoff=0.6) if len(name) <= 60 else []
    if near:
        return f"did you mean {' or '.join(near)}?"
    return (
        f"expected one of {', '.join(names)}" if len(names) < 20 else "`grammarlab list` shows the files to start from"
    )


def _unit(column: str) -> str:
    return PARAMETERS[column if column in PARAMETERS else column.removesuffix(SPREAD)].unit


def _meaning(column: str) -> str:
    if column in PARAMETERS:
        return f"{column}: {PARAMETERS[column].why}"
    name = column.removesuffix(SPREAD)
    return f"the spread of {name} is the largest deviation of single stems from its value"


def _interval(low: float, high: float, unit: str = "") -> str:
    return f"{low:g} to {high:g}{f' {unit}' if unit else ''}"


def _expected(column: str) -> str:
    index = COLUMN[column]
    return f"{_interval(LOW[index], HIGH[index], _unit(column))}; {_meaning(column)}"


def _example(column: str) -> str:
    middle = DEFAULTS[COLUMN[column]]
    ends = np.clip([middle, middle + 1.0], LOW[COLUMN[column]], HIGH[COLUMN[column]])
    return f"[{ends[0]:g}, {ends[1]:g}]"
