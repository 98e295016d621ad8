"""Graph of the rules and symbols of a grammar, laid out on a page, as a picture: SVG as text, PNG through Pillow."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from html import escape
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from grammarlab.errors import UsageError
from grammarlab.files import atomic_file, write_text
from grammarlab.language.call_order import groups
from grammarlab.language.syntax.syntax_tree import Invoke, Rule, Stochastic, walk

_SWEEPS = 8
"""Passes of the crossing reduction; more passes change little on graphs of a few hundred symbols."""
_FILL = {"start": "#2f5d8a", "rule": "#dfe7f0", "stochastic": "#f4d58d", "terminal": "#e3efdc"}
_INK = {"start": "#ffffff", "rule": "#22303c", "stochastic": "#3f3212", "terminal": "#2f4a24"}
_LEGEND = {"start": "start rule", "rule": "rule", "stochastic": "rule with chance", "terminal": "leaf"}
_BACKGROUND, _LINE = "#fbfaf7", "#9aa7b4"
_BOX_HEIGHT, _ROW, _GAP, _MARGIN, _TEXT = 22, 30, 70, 24, 12
"""Pixels: height of a box, distance of rows, space between columns, border, letter size."""
_SCALE = 2
"""Pixels of the PNG for each pixel of the SVG, for sharp letters."""
_MAX_SIDE = 16_000
"""Longest side of a PNG in pixels."""
_Point = tuple[float, float]


@dataclass(frozen=True, slots=True)
class PlacedSymbol:
    """A symbol with its place."""

    symbol: str
    kind: str
    """``start``, ``rule``, ``stochastic`` (a rule with a stochastic choice) or ``terminal``."""
    column: int
    """Index of the column, 0 at the start rule."""
    row: float
    """Position in the column in rows of boxes, 0 at the top."""


@dataclass(frozen=True, slots=True)
class RuleGraph:
    """Symbols of a grammar, with edges from rules to the symbols they make."""

    kind: Mapping[str, str]
    """Kind of each symbol, see `PlacedSymbol.kind`."""
    edges: Collection[tuple[str, str]]
    """A rule and a symbol that it makes; each pair once."""

    def neighbours(self, forward: bool = True) -> dict[str, list[str]]:
        """Successors of each symbol, or its predecessors if backward."""
        adjacent: dict[str, list[str]] = {symbol: [] for symbol in self.kind}
        for edge in self.edges:
            start, end = edge if forward else reversed(edge)
            adjacent[start].append(end)
        return adjacent


def rule_graph(rules: Iterable[Rule], start: str, operations: frozenset[str]) -> RuleGraph:
    """Graph of the symbols, with an edge from each rule to each symbol it makes.

    Args:
        rules: all rules; overloads count as one symbol.
        start: the start rule.
        operations: names that are operations, not symbols.
    """
    kind: dict[str, str] = {}
    successors: dict[str, dict[str, None]] = {}
    for rule in rules:
        inside = list(walk(rule.body))
        stochastic = kind.get(rule.name) == "stochastic" or any(isinstance(node, Stochastic) for node in inside)
        kind[rule.name] = "start" if rule.name == start else "stochastic" if stochastic else "rule"
        for node in inside:
            if isinstance(node, Invoke) and node.name not in operations:
                kind.setdefault(node.name, "terminal")
                successors.setdefault(rule.name, {})[node.name] = None
    return RuleGraph(kind, [(symbol, child) for symbol in kind for child in successors.get(symbol, ())])


def place_symbols(graph: RuleGraph) -> list[PlacedSymbol]:
    """Columns by the longest path from the start, rows with few crossing edges (Sugiyama, Tagawa and Toda, 1981)."""
    column = _columns(graph)
    rows: dict[str, float] = {}
    layers: list[list[str]] = [[] for _ in range(max(column.values(), default=-1) + 1)]
    for symbol in graph.kind:
        layers[column[symbol]].append(symbol)
    for layer in layers:
        rows.update({symbol: index for index, symbol in enumerate(layer)})
    for sweep in range(_SWEEPS):
        forward = sweep % 2 == 0
        neighbours = graph.neighbours(not forward)
        for layer in layers if forward else reversed(layers):
            layer.sort(key=lambda symbol: _mean([rows[other] for other in neighbours[symbol]], rows[symbol]))
            rows.update({symbol: index for index, symbol in enumerate(layer)})
    tallest = max(map(len, layers), default=0)
    return [
        PlacedSymbol(symbol, graph.kind[symbol], index, row + (tallest - len(layer)) / 2)
        for index, layer in enumerate(layers)
        for row, symbol in enumerate(layer)
    ]


def save_graph(symbols: Sequence[PlacedSymbol], edges: Iterable[tuple[str, str]], path: Path) -> None:
    """Draw placed symbols and the edges between them.

    Args:
        symbols: symbols with their places, from `place_symbols`.
        edges: pairs of symbols.
        path: ends in ``.svg`` or ``.png``.
    """
    writers = {".svg": _save_svg, ".png": _save_png}
    if (suffix := path.suffix.lower()) not in writers:
        raise UsageError(f"graph picture {path.name!r}: expected a name that ends in {' or '.join(writers)}.")
    writers[suffix](_lay_out(symbols, edges), path)


def _columns(graph: RuleGraph) -> dict[str, int]:
    """Length of the longest path to each symbol; the symbols of one recursion share a column."""
    before = graph.neighbours(forward=False)
    column: dict[str, int] = {}
    for group in groups(before):
        above = [column[symbol] for member in group for symbol in before[member] if symbol not in group]
        column.update(dict.fromkeys(group, max(above, default=-1) + 1))
    return column


def _mean(values: list[float], otherwise: float) -> float:
    return sum(values) / len(values) if values else otherwise


@dataclass(frozen=True, slots=True)
class _Page:
    width: float
    height: float
    boxes: tuple[_Box, ...]
    curves: tuple[tuple[_Point, _Point, _Point, _Point], ...]
    """Cubic Bezier curves."""


def _save_svg(page: _Page, path: Path) -> None:
    size = f'width="{page.width:.0f}" height="{page.height:.0f}"'
    font = f'font-family="Helvetica, Arial, sans-serif" font-size="{_TEXT}"'
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" {size} {font}>',
        f'<rect width="100%" height="100%" fill="{_BACKGROUND}"/>',
        *(_svg_curve(*curve) for curve in page.curves),
        *(_svg_box(box) for box in page.boxes),
        "</svg>",
    ]
    write_text(path, "\n".join(lines) + "\n")


@dataclass(frozen=True, slots=True)
class _Box:
    placed: PlacedSymbol
    x: float
    y: float
    width: float


def _svg_curve(start: _Point, control_1: _Point, control_2: _Point, end: _Point) -> str:
    points = " ".join(f"{x:.1f},{y:.1f}" for x, y in (control_1, control_2, end))
    return f'<path d="M{start[0]:.1f},{start[1]:.1f} C{points}" fill="none" stroke="{_LINE}"/>'


def _svg_box(box: _Box) -> str:
    kind, middle = box.placed.kind, box.y + _BOX_HEIGHT / 2 + 4
    size = f'width="{box.width:.1f}" height="{_BOX_HEIGHT}" rx="5"'
    return (
        f'<rect x="{box.x:.1f}" y="{box.y:.1f}" {size} fill="{_FILL[kind]}"/>'
        f'<text x="{box.x + 8:.1f}" y="{middle:.1f}" fill="{_INK[kind]}">{escape(box.placed.symbol)}</text>'
    )


def _save_png(page: _Page, path: Path) -> None:
    scale = _SCALE if max(page.width, page.height) * _SCALE <= _MAX_SIDE else 1
    if max(page.width, page.height) * scale > _MAX_SIDE:
        raise UsageError(
            f"the rule graph is {page.width:.0f} x {page.height:.0f} pixels, too large for a PNG: use .svg."
        )
    image = Image.new("RGB", (round(page.width * scale), round(page.height * scale)), _BACKGROUND)
    draw = ImageDraw.Draw(image)
    t = np.linspace(0, 1, 33)[:, None]
    weights = np.hstack([(1 - t) ** 3, 3 * t * (1 - t) ** 2, 3 * t**2 * (1 - t), t**3])
    for curve in page.curves:
        points = (weights @ np.array(curve) * scale).tolist()
        draw.line([(x, y) for x, y in points], fill=_LINE, width=scale, joint="curve")
    font = _font(scale)
    for box in page.boxes:
        corners = (box.x, box.y, box.x + box.width, box.y + _BOX_HEIGHT)
        draw.rounded_rectangle([value * scale for value in corners], 5 * scale, fill=_FILL[box.placed.kind])
        middle = ((box.x + 8) * scale, (box.y + _BOX_HEIGHT / 2) * scale)
        draw.text(middle, box.placed.symbol, _INK[box.placed.kind], font, anchor="lm")
    with atomic_file(path) as part:
        image.save(part)


def _font(scale: int) -> ImageFont.FreeTypeFont | ImageFont.ImageFont:
    return ImageFont.load_default(_TEXT * scale)


def _lay_out(symbols: Sequence[PlacedSymbol], edges: Iterable[tuple[str, str]]) -> _Page:
    font = _font(1)
    legend = [PlacedSymbol(text, kind, -1, 0) for kind, text in _LEGEND.items()]
    text_width = {item: font.getlength(item.symbol) + 16 for item in [*symbols, *legend]}
    num_columns = max((s.column for s in symbols), default=-1) + 1
    widths = [max(text_width[s] for s in symbols if s.column == column) for column in range(num_columns)]
    lefts = np.concatenate([[0.0], np.cumsum(np.array(widths) + _GAP)]) + _MARGIN
    top = _MARGIN + 2 * _ROW
    boxes = {s.symbol: _Box(s, float(lefts[s.column]), top + s.row * _ROW, text_width[s]) for s in symbols}
    keys, x = [], float(_MARGIN)
    for item in legend:
        keys.append(_Box(item, x, _MARGIN, text_width[item]))
        x += text_width[item] + 12
    height = max((box.y for box in boxes.values()), default=_MARGIN) + _BOX_HEIGHT + _MARGIN
    curves = tuple(_curve(boxes[a], boxes[b]) for a, b in edges)
    return _Page(max(float(lefts[-1]) - _GAP, x) + _MARGIN, height, (*keys, *boxes.values()), curves)


def _curve(a: _Box, b: _Box) -> tuple[_Point, _Point, _Point, _Point]:
    """A curve from the right side of a box to the left side of another; backward edges bend further out."""
    start, end = (a.x + a.width, a.y + _BOX_HEIGHT / 2), (b.x, b.y + _BOX_HEIGHT / 2)
    bow = max(_GAP / 2, 0.4 * abs(end[0] - start[0]))
    lift = -_ROW if end[0] <= start[0] else 0
    return start, (start[0] + bow, start[1] + lift), (end[0] - bow, end[1] + lift), end
