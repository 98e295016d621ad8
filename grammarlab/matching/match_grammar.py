"""A match as a grammar, as a completed facade, and as a picture.

Kinds are rules, shared parameters are shared attributes, and uncertainties are random ranges. In the completed facade
every element is complete and in place, with wall around it. The picture has the fitted templates in the colours of
their kinds, under the points of all elements.
"""

from __future__ import annotations

import colorsys
from collections.abc import Sequence

import numpy as np
import shapely
from PIL import Image, ImageDraw
from shapely.geometry.polygon import orient

from grammarlab.arrays import Floats
from grammarlab.facade.grammar.rule_text import RuleNames, front_of_box, leaf_body, number, rule_name
from grammarlab.facade.looks import THICKNESS, look_of
from grammarlab.facade.reading.annotation import annotate
from grammarlab.facade.reading.assembling import LARGEST, Assembled, assemble
from grammarlab.language.formatting import format_grammar
from grammarlab.language.grammar import Grammar
from grammarlab.matching.match import SURE, Match, drawn_parameters
from grammarlab.matching.template import ARC_PIECES, HEIGHT, WIDTH, Template, points_along

_MAX_SIDE_PIXELS = 2400
"""Largest side, pixels."""
_MAX_PIXELS_PER_M = 120.0
"""Largest resolution, pixels per metre."""
_MAX_POINTS = 400
"""Largest number of points shown per element."""
_PAPER, _POINT, _UNKNOWN = (255, 255, 255), (60, 60, 60), (200, 30, 30)


def picture(match: Match) -> Image.Image:
    """Elements from the front; uncertain ones have thin lines, unknown ones a red box."""
    low, high = match.elements.low.min(axis=0), match.elements.high.max(axis=0)
    extent = np.maximum(high - low, 1e-6)
    scale = min(_MAX_PIXELS_PER_M, _MAX_SIDE_PIXELS / float(extent.max()))
    size = np.maximum(np.ceil(extent * scale), 1.0).astype(int)
    drawing = Image.new("RGB", (int(size[0]), int(size[1])), _PAPER)
    pen = ImageDraw.Draw(drawing)

    def pixels(points: np.ndarray) -> list[tuple[float, float]]:
        moved = (points - low) * scale
        return [(x, size[1] - y) for x, y in moved.tolist()]

    for element in range(len(match.kind)):
        drawn = drawn_parameters(match, element)
        if drawn is None:
            corners = pixels(np.stack([match.elements.low[element], match.elements.high[element]]))
            (x_low, y_low), (x_high, y_high) = corners
            pen.rectangle((x_low, y_high, x_high, y_low), outline=_UNKNOWN)
        else:
            color = color_of(int(match.kind[element]))
            width = 4 if match.probability[element] >= SURE else 1
            for segment in points_along(*drawn):
                pen.line(pixels(segment + match.corner[element]), fill=color, width=width)
        cloud = match.elements.points_of(element)[:, :2]
        sample = (
            cloud[np.linspace(0, len(cloud) - 1, min(len(cloud), _MAX_POINTS)).astype(int)] if len(cloud) else cloud
        )
        for x, y in pixels(sample):
            pen.ellipse((x - 2, y - 2, x + 2, y + 2), fill=_POINT)
    return drawing


def color_of(kind: int) -> tuple[int, int, int]:
    """A colour for each kind; hues are a golden angle apart, for the best contrast."""
    red, green, blue = colorsys.hsv_to_rgb((0.58 + 0.381966 * kind) % 1.0, 0.85, 0.8)
    return round(255 * red), round(255 * green), round(255 * blue)


_BORDER_M = 0.5
"""Width of the wall around the outermost elements, metres."""
_SNAP_RATIO = 0.0005
"""Largest distance of sides that are moved to one line, as a fraction of the shorter side of the facade."""
_NUM_SDS = 2.0
"""Half width of a random range, in standard deviations."""
_MIN_GAP_M = 0.02
"""Least distance between elements, metres."""
_BAR_WIDTH_M, _BAR_DEPTH_M = 0.06, 0.1
"""Width and depth of the bars along wires, metres: those of usual window frames."""
_DIGITS = 6
"""Decimal digits of factors and of lengths in metres."""


def completed(match: Match) -> Assembled | None:
    """The facade of all elements with a template; None if there is none, or it would be too large.

    An element is a box with its template's width and height, with its outline inside; parts beyond it are left out.
    """
    boxes, names, outlines = [], [], []
    for element in range(len(match.kind)):
        drawing = drawn_parameters(match, element)
        if drawing is None:
            continue
        template, parameters = drawing
        corner, size = match.corner[element], parameters[[WIDTH, HEIGHT]]
        boxes.append([*corner, *(corner + size)])
        names.append(f"{match.name_of(int(match.kind[element]))} {_thing(template)}")
        outlines.append(
            _outer(template, parameters) + corner if not _rectangular(template, parameters) else np.zeros((0, 2))
        )
    if not boxes:
        return None
    box_array = np.array(boxes)
    bounds = np.stack([box_array[:, :2].min(axis=0) - _BORDER_M, box_array[:, 2:].max(axis=0) + _BORDER_M])
    if (bounds[1] - bounds[0]).max() > LARGEST:
        return None
    boxes_and_wall = np.vstack([bounds.reshape(1, 4), box_array])
    none = np.zeros((0, 2))
    annotation = annotate(boxes_and_wall, ["wall", *names], "metres", outlines=[none, *outlines], bounds=bounds)
    return assemble(annotation, tolerance=_SNAP_RATIO, split=True)


def write_terminals(match: Match) -> str | None:
    """CGA text that draws the facade of a match from its kinds; None if it has none.

    Rows of the facade are bands; in each, elements are in order, with their gaps. Samples vary every parameter within
    the uncertainty of the scan, equally for all kinds that share it.
    """
    rows = _rows(match)
    if not rows:
        return None
    names, attributes, lines = RuleNames(), {}, ['version "2023.0"']
    for name in ("Bar", "ArcBar", "Arc", "Chord", "Beam", "Pane", "Wall"):
        names.new(name)
    rules = [names.new(rule_name(match.name_of(kind))) for kind in range(len(match.values))]
    for kind in range(len(match.values)):
        for index, parameter in enumerate(match.template_of(kind).parameters):
            key = (int(match.kind_template[kind]), parameter, float(match.values[kind][index]))
            if key not in attributes:
                attributes[key] = f"{parameter}_{1 + sum(parameter == other[1] for other in attributes)}"
                middle, reach = key[2], _NUM_SDS * float(match.spread[kind][index])
                low, high = max(middle - reach, 0.1 * middle), middle + reach
                lines.append(f"attr {attributes[key]} = rand({number(low, 4)}, {number(high, 4)})")
    right_edge = max(match.corner[row, 0].max() + _size(match, row)[:, 0].max() for row in rows)
    left_edge = min(match.corner[row, 0].min() for row in rows)
    bands = _bands(match, rows)
    height = bands[-1][1] + _BORDER_M - (bands[0][0] - _BORDER_M)
    span = right_edge - left_edge + 2 * _BORDER_M
    lines += [
        "@StartRule",
        f"Lot --> {front_of_box(f'{number(span, 3)}, {number(height, 3)}, {THICKNESS}', 'Facade')}",
    ]
    stories, below = [], bands[0][0] - _BORDER_M
    for index, (row, (bottom, top)) in enumerate(zip(rows, bands, strict=True)):
        name = names.new(f"Row{index + 1}")
        stories += [f"~{number(max(bottom - below, _MIN_GAP_M), 3)} : Wall", f"{number(top - bottom, 3)} : {name}"]
        below = top
        parts, before = [], left_edge - _BORDER_M
        for element in row.tolist():
            kind = int(match.kind[element])
            start = float(match.corner[element, 0])
            parts.append(f"~{number(max(start - before, _MIN_GAP_M), 3)} : Wall")
            parts.append(f"{attributes[_key(match, kind, WIDTH)]} : {rules[kind]}")
            before = start + float(match.parameters[element][WIDTH])
        parts.append(f"~{number(max(right_edge + _BORDER_M - before, _MIN_GAP_M), 3)} : Wall")
        lines.append(f"{name} --> split(x) {{ {' | '.join(parts)} }}")
    stories.append(f"~{number(_BORDER_M, 3)} : Wall")
    lines.append(f"Facade --> split(y) {{ {' | '.join(stories)} }}")
    for kind, rule in enumerate(rules):
        attribute = attributes[_key(match, kind, HEIGHT)]
        lines.append(f"{rule} --> split(y) {{ ~1 : Wall | {attribute} : {rule}Terminal | ~1 : Wall }}")
        template = match.template_of(kind)
        values = [attributes[_key(match, kind, index)] for index in range(len(template.parameters))]
        pane = f"[ {leaf_body(_thing(template))} Pane. ]"
        lines.append(f"{rule}Terminal --> {pane} {wire_bars(template, values)} NIL")
    has_arcs = any("ArcBar(" in line for line in lines)
    rules_of_bars = [rule for rule in bar_rules() if has_arcs or rule.startswith(("Bar", "Beam"))]
    lines += [f"Wall --> {leaf_body('wall')}", *rules_of_bars]
    return format_grammar(Grammar.parse("\n".join(lines)))


def bar_rules() -> tuple[str, ...]:
    """Rules of a straight bar, and of an arc of straight ones; lengths in metres, angles in degrees.

    Bars lie in the plane of the wall, from one point to another. An arc rises to the right of the line between them,
    and is a straight bar if it does not rise.
    """
    place = f"t(x, y, {number(look_of('window').front, 3)}) r(0, 0, atan2(dy, dx))"
    width, depth = number(_BAR_WIDTH_M, 3), number(_BAR_DEPTH_M, 3)
    distance = "sqrt(dx * dx + dy * dy)"
    starts = [2.0 * part / ARC_PIECES - 1.0 for part in range(ARC_PIECES)]
    chords = " ".join(f"[ Chord(0.5 * length / sin(half), half, {start:g} * half) ]" for start in starts)
    to_start = "t(radius * (sin(half) + sin(angle)), radius * (cos(half) - cos(angle)), 0)"
    turn = f"r(0, 0, angle + half / {ARC_PIECES})"
    look = f'color("{look_of("sill").color}") primitiveCube()'
    return (
        f"Bar(x, y, dx, dy) --> {place} Beam({distance})",
        f"ArcBar(x, y, dx, dy, rise) --> {place} Arc({distance}, 2 * atan2(2 * rise, {distance}))",
        # The radius of an arc without a rise is infinite.
        f"Arc(length, half) --> case abs(half) < 0.01 : Beam(length) else : {chords} NIL",
        f"Chord(radius, half, angle) --> {to_start} {turn} Beam(2 * radius * sin(half / {ARC_PIECES}))",
        f"Beam(length) --> t(0, {number(-0.5 * _BAR_WIDTH_M, 3)}, 0) s(length, {width}, {depth}) {look}",
    )


def wire_bars(template: Template, parameters: Sequence[str]) -> str:
    """CGA that draws the wires of a template as bars along them; it calls the rules of `bar_rules`.

    Args:
        template: the template.
        parameters: [D] attributes or numbers with the values of its parameters.
    """
    bars = []
    for start_x, start_y, end_x, end_y, rise in template.wires:
        terms = [start_x, start_y, end_x - start_x, end_y - start_y]
        rule = "ArcBar" if np.abs(rise).max() > 0.0 else "Bar"
        values = ", ".join(_linear(form, parameters) for form in (*terms, *([rise] if rule == "ArcBar" else [])))
        bars.append(f"[ {rule}({values}) ]")
    return " ".join(bars)


def _linear(form: Floats, parameters: Sequence[str]) -> str:
    """CGA of a linear form [1 + D]: a constant, and a factor of each parameter."""
    text = number(float(form[0]), _DIGITS)
    terms = [] if text == "0" else [text]
    for factor, name in zip(form[1:].tolist(), parameters, strict=True):
        text = number(factor, _DIGITS)
        if text != "0":
            terms.append({"1": name, "-1": f"-{name}"}.get(text, f"{text} * {name}"))
    return " + ".join(terms).replace("+ -", "- ") or "0"


def _thing(template: Template) -> str:
    """The label of a template, which determines its look in pictures."""
    for name in ("door", "gate", "column", "pilaster"):
        if name in template.base:
            return name
    return "window"


def _outer(template: Template, parameters: Floats) -> Floats:
    """[P, 2] corners, anticlockwise, of the area that the wires of a template enclose, within its width and height."""
    segments = points_along(template, parameters)
    around = shapely.union_all([shapely.LineString(segment) for segment in segments]).convex_hull
    inside = around.intersection(shapely.box(0.0, 0.0, parameters[WIDTH], parameters[HEIGHT]))
    if not isinstance(inside, shapely.Polygon) or inside.area <= 0.0:
        return np.zeros((0, 2))
    return np.asarray(orient(inside).exterior.coords)[:-1]


def _rectangular(template: Template, parameters: Floats) -> bool:
    corners = _outer(template, parameters)
    if not len(corners):
        return True
    return shapely.Polygon(corners).area >= 0.999 * parameters[WIDTH] * parameters[HEIGHT]


def _rows(match: Match) -> list[np.ndarray]:
    """Elements of each row from the left to the right, the lowest row first; overlapping elements are left out."""
    elements = [element for element in range(len(match.kind)) if match.kind[element] >= 0]
    if not elements:
        return []
    size = _size(match, np.array(elements))
    middle = {
        element: float(match.corner[element, 1] + height / 2)
        for element, height in zip(elements, size[:, 1], strict=True)
    }
    rows: list[list[int]] = []
    for element in sorted(elements, key=lambda element: (middle[element], match.corner[element, 0])):
        level = middle[element] - middle[rows[-1][0]] if rows else np.inf
        if level > 0.5 * float(np.median(size[:, 1])):
            rows.append([])
        rows[-1].append(element)
    bands: list[np.ndarray] = []
    for row in rows:
        rest = sorted(row, key=lambda element: float(match.corner[element, 0]))
        while rest:
            selected, end = [], -np.inf
            for element in rest:
                if match.corner[element, 0] >= end:
                    selected.append(element)
                    end = float(match.corner[element, 0] + match.parameters[element][WIDTH])
            bands.append(np.array(selected))
            rest = [element for element in rest if element not in selected]
    return bands


def _size(match: Match, row: np.ndarray) -> np.ndarray:
    return np.array([match.parameters[element][[WIDTH, HEIGHT]] for element in row.tolist()])


def _bands(match: Match, rows: list[np.ndarray]) -> list[tuple[float, float]]:
    """Bottom and top of each row, from the lowest, with room for its variation; rows do not overlap."""
    bands: list[tuple[float, float]] = []
    for row in rows:
        low = match.corner[row, 1]
        room = max(float(_NUM_SDS * match.spread[int(match.kind[element])][HEIGHT]) for element in row.tolist())
        bottom, top = float(low.min()) - room, float((low + _size(match, row)[:, 1]).max()) + room
        if bands and bottom < bands[-1][1] + _MIN_GAP_M:
            bottom, top = bands[-1][1] + _MIN_GAP_M, top + bands[-1][1] + _MIN_GAP_M - bottom
        bands.append((bottom, top))
    return bands


def _key(match: Match, kind: int, index: int) -> tuple[int, str, float]:
    return int(match.kind_template[kind]), match.template_of(kind).parameters[index], float(match.values[kind][index])
