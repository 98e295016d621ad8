"""Designs as TOML files; docs/layers/file.md describes the format.

A file may come from a stranger: its values are bounded and checked before a design is made. Messages give the line and
column of a mistake.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, fields
from difflib import get_close_matches
from pathlib import Path
from typing import Any, NoReturn

from grammarlab.errors import Finding, LanguageError, Location, TomlError, shown
from grammarlab.facade.values import read_bounded
from grammarlab.layers.design import MIN_WEIGHT, WILDCARD, Counter, Design, Layer, Shape, Symbol, Weights, is_weight
from grammarlab.layers.patterns import REFLECTIONS, LayerPattern, PatternError, Sign, parse_pattern
from grammarlab.toml_text import toml_table, toml_text

MOST_BYTES = 2**20
"""Largest size of a design file, bytes."""
MIN_SIZE_M, MAX_SIZE_M = 1e-6, 10_000.0
"""Smallest and largest size of a canvas or a symbol, metres."""
MOST_LAYERS, _MOST_NAMES, _MOST_TIMES = 64, 1_000, 10_000
"""Largest numbers of layers, of entries of a table, and of copies of a part."""
_HEADER = re.compile(r"\s*\[+\s*([^\[\]]+?)\s*\]+\s*(?:#.*)?$")
_TABLES = ("title", "canvas", "symbols", "counters", "patterns", "shapes", "solver", "layers")
_FLAGS = ("opaque", "attached", "unoccludable", "transparent")
_AXES = ("x", "y")
_SIDES = ("left", "bottom", "right", "top")


def load_design(path: Path) -> Design:
    """Read a design.

    Raises:
        LanguageError: If it has a mistake; with line and column.
        FacadeError: If the file is not a regular file, or too large.
    """
    return parse_design(read_design_text(path), path.name)


def parse_design(text: str, file: str = "<text>") -> Design:
    """The design that a text describes.

    Raises:
        LanguageError: If it has a mistake; with line and column.
    """
    try:
        values = toml_table(text)
    except TomlError as error:
        raise _not_toml(error, text, file) from error
    return _DesignReader(text, file).design(values)


def read_design_text(path: Path) -> str:
    """The text of a design; errors as in `load_design`."""
    content = read_bounded(path, MOST_BYTES)
    try:
        return toml_text(content)
    except TomlError as error:
        raise _not_toml(error, "", path.name) from error


def _not_toml(error: TomlError, text: str, file: str) -> LanguageError:
    location = Location(error.line or 1, error.column or 1, file=file)
    return LanguageError((Finding("error", "not-toml", error.message, location),), text if error.line else "")


@dataclass
class _DesignReader:
    """Makes a design from the values of a file; stops at the first mistake."""

    text: str
    file: str
    symbols: dict[str, Symbol] = field(default_factory=dict)
    patterns: dict[str, LayerPattern] = field(default_factory=dict)

    def design(self, values: dict[str, Any]) -> Design:
        self._check_keys(values, _TABLES, "", None, ())
        title = values.get("title", "")
        if not isinstance(title, str):
            self._fail(f"expected a text, found {shown(title)}", "title", None, ())
        canvas = self._table(values.get("canvas"), "canvas", None, ())
        self._check_keys(canvas, ("width", "height"), "canvas", None, ())
        width, height = (self._length(canvas.get(key), "canvas", None, (key,)) for key in ("width", "height"))
        for name, value in self._named(values, "symbols"):
            self.symbols[name] = self._symbol(name, value)
        named = [*self._named(values, "patterns")]
        for name, value in named:
            self.patterns[name] = self._pattern(value, "patterns", None, (name,))
        layers = values.get("layers")
        if not isinstance(layers, list) or not layers:
            self._fail(f"expected layers, each under [[layers]], found {shown(layers)}", "layers", None, ())
        if len(layers) > MOST_LAYERS:
            self._fail(f"expected at most {MOST_LAYERS} layers, found {len(layers):,}", "layers", MOST_LAYERS, ())
        parsed_layers = tuple(self._layer(number, value) for number, value in enumerate(layers))
        if not any(layer.on for layer in parsed_layers):
            self._fail("expected a layer that is on, found none", "layers", 0, ("on",))
        counters = {name: self._counter(name, value) for name, value in self._named(values, "counters")}
        for pattern in self.patterns.values():
            for name in pattern.counters():
                counters.setdefault(name, Counter(name))
        weights, overhang = self._solver(self._table(values.get("solver", {}), "solver", None, ()))
        shapes = self._shapes(values.get("shapes", {}), "shapes", None, ())
        return Design(
            title=title,
            width=width,
            height=height,
            symbols=self.symbols,
            counters=counters,
            patterns=self.patterns,
            layers=parsed_layers,
            shapes=shapes,
            weights=weights,
            overhang=overhang,
        )

    def _solver(self, table: dict[str, Any]) -> tuple[Weights, bool]:
        names = [field.name for field in fields(Weights)]
        self._check_keys(table, (*names, "overhang"), "solver", None, ())
        numbers = {name: self._number(table[name], "solver", None, (name,)) for name in names if name in table}
        for name, number in numbers.items():
            if not is_weight(number):
                message = f"expected a weight of at least 0, above 0 at least {MIN_WEIGHT:g}, found {number:g}"
                self._fail(message, "solver", None, (name,))
        return Weights(**numbers), self._truth(table.get("overhang", False), "solver", None, ("overhang",))

    def _named(self, values: dict[str, Any], table: str) -> Iterable[tuple[str, Any]]:
        entries = self._table(values.get(table, {}), table, None, ())
        if len(entries) > _MOST_NAMES:
            self._fail(f"expected at most {_MOST_NAMES:,} {table}, found {len(entries):,}", table, None, ())
        return entries.items()

    def _symbol(self, name: str, value: Any) -> Symbol:
        where = ("symbols", None, (name,))
        if not name[:1].isalpha() or not name.isprintable() or set(name) & set("{}()|^;:"):
            self._fail(f"expected a name that begins with a letter, without {{}}()|^;:, found {name!r}", *where)
        if isinstance(value, int | float):
            value = {"size": value}
        table = self._table(value, *where)
        self._check_keys(table, ("size", *_FLAGS), *where)
        size = self._length(table["size"], "symbols", None, (name, "size")) if "size" in table else None
        flags = {}
        for flag in _FLAGS:
            if flag in table:
                flags[flag] = self._truth(table[flag], "symbols", None, (name, flag))
        return Symbol(name, size, **flags)

    def _counter(self, name: str, value: Any) -> Counter:
        where = ("counters", None, (name,))
        table = self._table(value, *where)
        self._check_keys(table, ("least", "most", "reflection"), *where)
        bounds = []
        for key in ("least", "most"):
            bound = table.get(key)
            if bound is not None and (type(bound) is not int or abs(bound) > _MOST_TIMES):
                message = f"expected a whole number from {-_MOST_TIMES} to {_MOST_TIMES}, found {shown(bound)}"
                self._fail(message, "counters", None, (name, key))
            bounds.append(bound)
        least, most = bounds
        if most is not None and most < (least or 0) and not (least is None and most < 0):
            self._fail(f"expected at least {least or 0}, found {most}", "counters", None, (name, "most"))
        if least is None and most is not None and most < 0:
            self._fail(f"expected at least 0, or a value for 'least', found {most}", "counters", None, (name, "most"))
        reflection = table.get("reflection", "inner")
        if reflection not in REFLECTIONS:
            message = f"expected one of {', '.join(REFLECTIONS)}, found {shown(reflection)}"
            self._fail(message, "counters", None, (name, "reflection"))
        return Counter(name, least, most, reflection)

    def _pattern(self, value: Any, table: str, index: int | None, keys: Sequence[str]) -> LayerPattern:
        if not isinstance(value, str):
            self._fail(f"expected a pattern such as 'A(BA)^k', found {shown(value)}", table, index, keys)
        try:
            pattern = parse_pattern(value)
        except PatternError as error:
            self._fail_inside(value, error, table, index, keys)
        symbols = set(self.symbols)
        replaced = {sign.symbol for sign, _ in pattern.contents}
        for node in pattern.nodes():
            if isinstance(node, Sign) and node.symbol not in symbols | replaced:
                near = get_close_matches(node.symbol, symbols, 1) if len(node.symbol) > 1 else []
                hint = f"did you mean {near[0]}?" if near else f"add {node.symbol} to [symbols]"
                if table == "layers":
                    hint += f", or name one of [patterns]: {', '.join(self.patterns) or 'none yet'}"
                error = PatternError(f"unknown symbol {node.symbol!r}", node.position, len(node.symbol), hint)
                self._fail_inside(value, error, table, index, keys)
        return pattern

    def _layer(self, number: int, value: Any) -> Layer:
        table = self._table(value, "layers", number, ())
        self._check_keys(table, ("name", "x", "y", "group", "mask", "on", "depth", "shapes"), "layers", number, ())
        names = []
        for key in _AXES:
            name = table.get(key)
            if not isinstance(name, str):
                self._fail(f"expected a pattern such as 'A(BA)^k', found {shown(name)}", "layers", number, (key,))
            if name not in self.patterns:
                self.patterns[name] = self._pattern(name, "layers", number, (key,))
            names.append(name)
        groups = self._table(table.get("group", {}), "layers", number, ("group",))
        masks = self._table(table.get("mask", {}), "layers", number, ("mask",))
        for keys, entry in ((("group",), groups), (("mask",), masks)):
            self._check_keys(entry, _AXES, "layers", number, keys)
        depth = self._number(table.get("depth", 0.0), "layers", number, ("depth",))
        name = table.get("name", f"layer {number + 1}")
        for entry, key in ((name, "name"), *((group, "group") for group in groups.values())):
            if not isinstance(entry, str):
                self._fail(f"expected a text, found {shown(entry)}", "layers", number, (key,))
        return Layer(
            name=name,
            patterns=(names[0], names[1]),
            groups=(groups.get("x", ""), groups.get("y", "")),
            masks=(self._mask(masks, "x", names[0], number), self._mask(masks, "y", names[1], number)),
            on=self._truth(table.get("on", True), "layers", number, ("on",)),
            depth=depth,
            shapes=self._shapes(table.get("shapes", {}), "layers", number, ("shapes",)),
        )

    def _mask(self, masks: dict[str, Any], key: str, pattern: str, number: int) -> frozenset[str] | None:
        if key not in masks:
            return None
        value, symbols = masks[key], self.patterns[pattern].symbols()
        if not isinstance(value, list) or not all(isinstance(symbol, str) for symbol in value):
            self._fail(f"expected a list of visible symbols, found {shown(value)}", "layers", number, ("mask",))
        for symbol in value:
            if symbol not in symbols:
                message = f"expected symbols of the pattern {pattern!r}: {', '.join(symbols)}; found {symbol!r}"
                self._fail(message, "layers", number, ("mask",))
        return frozenset(value)

    def _shapes(self, value: Any, table: str, index: int | None, keys: Sequence[str]) -> dict[tuple[str, str], Shape]:
        shapes = {}
        for across, row in self._table(value, table, index, keys).items():
            for up, shape in self._table(row, table, index, (*keys, across)).items():
                where = (table, index, (*keys, across, up))
                for name in (across, up):
                    if name != WILDCARD and name not in self.symbols:
                        self._fail(f"unknown symbol {name!r}", *where)
                shapes[across, up] = self._shape(shape, *where)
        return shapes

    def _shape(self, value: Any, table: str, index: int | None, keys: Sequence[str]) -> Shape:
        if isinstance(value, str):
            value = {"label": value}
        entry = self._table(value, table, index, keys)
        self._check_keys(entry, ("label", "depth", "inset", "frame"), table, index, keys)
        label, frame = entry.get("label"), entry.get("frame", "")
        for text, where in ((label, keys), (frame, (*keys, "frame"))):
            if not isinstance(text, str) or len(text) > 200 or not text.isprintable():
                self._fail(f"expected a label of at most 200 characters, found {shown(text)}", table, index, where)
        depth = self._number(entry.get("depth", 0.0), table, index, (*keys, "depth"))
        return Shape(
            str(label), depth, self._inset(entry.get("inset", [0.0] * 4), table, index, (*keys, "inset")), frame
        )

    def _inset(
        self, value: Any, table: str, index: int | None, keys: Sequence[str]
    ) -> tuple[float, float, float, float]:
        if not isinstance(value, list) or len(value) != len(_SIDES):
            self._fail(f"expected metres at {', '.join(_SIDES)}, found {shown(value)}", table, index, keys)
        left, bottom, right, top = (self._number(side, table, index, keys) for side in value)
        if min(left, bottom, right, top) < 0.0:
            self._fail(f"expected metres of at least 0, found {shown(value)}", table, index, keys)
        return left, bottom, right, top

    def _table(self, value: Any, table: str, index: int | None, keys: Sequence[str]) -> dict[str, Any]:
        if not isinstance(value, dict):
            self._fail(f"expected a table, found {shown(value)}", table, index, keys)
        return value

    def _length(self, value: Any, table: str, index: int | None, keys: Sequence[str]) -> float:
        number = self._number(value, table, index, keys, within=1e300)
        if not MIN_SIZE_M <= number <= MAX_SIZE_M:
            message = (
                f"expected metres above 0, at least {MIN_SIZE_M:g} and at most {MAX_SIZE_M:,.0f}, found {number:g}"
            )
            self._fail(message, table, index, keys)
        return number

    def _number(
        self, value: Any, table: str, index: int | None, keys: Sequence[str], *, within: float = MAX_SIZE_M
    ) -> float:
        if not isinstance(value, int | float) or isinstance(value, bool) or not -within <= value <= within:
            self._fail(f"expected a number, found {shown(value)}", table, index, keys)
        return float(value)

    def _truth(self, value: Any, table: str, index: int | None, keys: Sequence[str]) -> bool:
        if not isinstance(value, bool):
            self._fail(f"expected true or false, found {shown(value)}", table, index, keys)
        return value

    def _check_keys(
        self, values: Mapping[str, Any], allowed: Sequence[str], table: str, index: int | None, keys: Sequence[str]
    ) -> None:
        for key in values:
            if key not in allowed:
                near = get_close_matches(key, allowed, 1)
                hint = f"did you mean {near[0]}?" if near else ""
                where = (table, index, (*keys, key)) if table else (key, None, ())
                self._fail(f"expected one of {', '.join(allowed)}, found {key!r}", *where, hint=hint)

    def _fail_inside(
        self, value: str, error: PatternError, table: str, index: int | None, keys: Sequence[str]
    ) -> NoReturn:
        start = _location_of(self.text, self.file, table, index, keys, value)
        location = Location(start.line, start.column + error.position, error.length, self.file)
        raise LanguageError((Finding("error", "pattern", error.message, location, error.hint),), self.text) from error

    def _fail(self, message: str, table: str, index: int | None, keys: Sequence[str], *, hint: str = "") -> NoReturn:
        location = _location_of(self.text, self.file, table, index, keys)
        where = ".".join(part for part in (table, *keys) if part)
        finding = Finding("error", "design", f"{where}: {message}", location, hint)
        raise LanguageError((finding,), self.text)


def _location_of(
    text: str, file: str, table: str, index: int | None, keys: Sequence[str], value: object = None
) -> Location:
    """Location of a value, or of the closest enclosing entry that is found.

    Args:
        text: content of the file.
        file: name of the file.
        table: name of a top-level table.
        index: index in an array of tables.
        keys: keys from the table down to the value.
        value: the value, if the mistake is inside a text: then the location is that of its first character.
    """
    names = [table, *keys]
    best, depth, table_index, rest = Location(file=file), 0, -1, names if index is None else []
    for number, content in enumerate(text.splitlines(), start=1):
        header = _HEADER.match(content)
        if header:
            path = [part.strip().strip("\"'") for part in header[1].split(".")]
            table_index += header[0].lstrip().startswith("[[") and path == [table]
            inside = path == names[: len(path)] and (index is None or table_index == index)
            rest = names[len(path) :] if inside else []
            if inside and len(path) > depth:
                best, depth = Location(number, content.index("[") + 1, file=file), len(path)
            continue
        matched, after = _matched(content, rest)
        if matched and len(names) - len(rest) + matched > depth:
            depth = len(names) - len(rest) + matched
            best = Location(number, _value_column(content, after, value), file=file)
    return best


def _matched(content: str, keys: Sequence[str]) -> tuple[int, int]:
    """Number of leading keys of a line that match in order, and the index of the character after the last one."""
    offset = 0
    for number, key in enumerate(keys):
        quoted = rf"(?:{re.escape(key)}|\"{re.escape(key)}\"|'{re.escape(key)}')"
        before = r"\s*" if not number else r"(?:\s*\.\s*|\s*=\s*\{.*?(?<![\w-]))"
        match = re.compile(before + quoted + r"(?=\s*[.=])").match(content, offset)
        if match is None:
            return number, offset
        offset = match.end()
    return len(keys), offset


def _value_column(content: str, after: int, value: object) -> int:
    equals = content.find("=", after)
    start = equals + 1 + len(content[equals + 1 :]) - len(content[equals + 1 :].lstrip()) if equals >= 0 else after
    inside = content.find(value, start) if isinstance(value, str) else -1
    return (inside if inside >= 0 else start) + 1
