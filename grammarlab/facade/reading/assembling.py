"""A facade in metres from labelled boxes: snapped, trimmed where they overlap, filled with wall, cut into a tree.

Snapping makes nearly equal coordinates of sides equal, so that boxes touch and are aligned.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import shapely

from grammarlab.arrays import Floats, Ints, offsets_from_counts
from grammarlab.errors import FacadeError
from grammarlab.facade.reading.annotation import BACKGROUND, BoxAnnotation
from grammarlab.facade.reading.cutting import cut, pinwheel_text
from grammarlab.facade.reading.filling import WALL, PinwheelError, fill
from grammarlab.facade.reading.overlaps import VisiblePieces, uncovered
from grammarlab.facade.tree import LEAF, Facade, Picture, X, Y, check

DRAWN_TOLERANCE, MEASURED_TOLERANCE = 0.01, 0.001
"""Tolerances for boxes drawn on pictures and for boxes in metres, as fractions of the shorter side of the facade."""
DEFAULT_WIDTH_M = 20.0
"""Default width of a facade whose annotation is in pixels, metres."""
LARGEST = 10_000.0
"""Largest side of a facade, metres."""
OUTSIDE = "outside"
"""Label of the area beyond the outline of a wall that is not rectangular."""
_LEAST_ASPECT = 1e-9
"""Least ratio of the sides of the area of all boxes; also its least side, in the unit of the boxes."""
_NEGLIGIBLE_SHARE = 1e-6
"""Largest negligible part of a leaf."""


@dataclass(frozen=True, slots=True)
class Assembled:
    """A facade, and data on its assembly from boxes."""

    facade: Facade
    moved: float
    """Largest move of a side by snapping, metres."""
    notes: tuple[str, ...]
    """Notes for the user, one sentence each."""


@dataclass(frozen=True, slots=True)
class Snapped:
    """N boxes with sides on few lines."""

    low: Ints
    """[N, 2] line of the left and of the lower side of each box."""
    high: Ints
    """[N, 2] line of the right and of the upper side; greater than that of `low`."""
    lines: tuple[Floats, Floats]
    """Coordinates of the lines across x and across y, ascending."""
    moved: float
    """Largest move of a side, in the units of the boxes."""


def assemble(
    annotation: BoxAnnotation,
    *,
    width: float | None = None,
    height: float | None = None,
    tolerance: float | None = None,
    split: bool = False,
    picture: Picture | None = None,
    pixels: tuple[int, int] | None = None,
) -> Assembled:
    """The facade that boxes describe.

    Args:
        annotation: the boxes.
        width: width of the facade, metres; if left out, it follows from other data, see `_scale`.
        height: height of the facade, metres; if left out, it follows from other data, see `_scale`.
        tolerance: sides with a smaller distance are moved to one line, as a fraction of the shorter side of the facade;
            `DRAWN_TOLERANCE` or `MEASURED_TOLERANCE` when left out.
        split: whether boxes of a pinwheel may be cut; otherwise a pinwheel is an error.
        picture: the picture named by `annotation.picture`, if it exists; leaves show their parts of it.
        pixels: width and height of the picture, if known.

    Raises:
        FacadeError: If boxes form a pinwheel, or sizes are out of bounds.
    """
    if tolerance is None:
        tolerance = MEASURED_TOLERANCE if annotation.unit == "metres" else DRAWN_TOLERANCE
    if not 0.0 <= tolerance <= 0.1:
        raise FacadeError(f"Tolerance: expected a fraction of the facade from 0 to 0.1, found {tolerance}.")
    scale, notes = _scale(annotation, width, height, pixels)
    origin = annotation.frame[0]
    frame = (annotation.frame - origin) * scale
    labels = [name.strip().lower() for name in annotation.names]
    foreground = np.array([index for index, name in enumerate(labels) if name not in BACKGROUND], dtype=np.int64)
    names = [labels[box] for box in foreground.tolist()]
    low, high = ((side[foreground] - origin) * scale for side in (annotation.low, annotation.high))
    snapped = snap(low, high, frame, tolerance * float(frame[1].min()))
    pieces = uncovered(np.hstack([snapped.low, snapped.high]), names)
    last = [len(lines) - 1 for lines in snapped.lines]
    try:
        tiles, source = fill(pieces, (0, 0, last[X], last[Y]), split=split)
    except PinwheelError as error:
        text = pinwheel_text(error.sources, low, high, names, annotation.number[foreground])
        raise FacadeError(f"{text} Or allow cuts through it (`split=True`).") from error
    facade, tile = cut(
        *_corners(tiles, snapped.lines), [names[box] if box != WALL else "wall" for box in source.tolist()]
    )
    leaf_source = np.where(tile >= 0, source[tile], WALL)
    num_hidden = len(foreground) - len(np.unique(source[source != WALL]))
    if num_hidden:
        notes.append(f"{num_hidden} boxes that are fully hidden by others are left out")
    notes += _split_notes(source, pieces, names, annotation.number[foreground])
    outlines = [(annotation.outlines[box] - origin) * scale for box in foreground.tolist()]
    outlines = _moved_outlines(outlines, (low, high), _corners(np.hstack([snapped.low, snapped.high]), snapped.lines))
    facade = _with_outlines(facade, leaf_source, outlines, (annotation.wall - origin) * scale)
    if picture is not None:
        facade = _with_picture(facade, picture, (annotation.picture_area - origin) * scale)
    return Assembled(check(facade), snapped.moved, (*annotation.notes, *notes))


def snap(low: Floats, high: Floats, frame: Floats, tolerance: float) -> Snapped:
    """Boxes with sides on few lines: all sides of a line lie within the tolerance, and the line is at their median.

    Coordinates are divided recursively at their largest gap, until those of each part lie within the tolerance and no
    box has both of its sides there; so even a thin box keeps a size above 0. Boxes that touch exactly and lines with
    distances above the tolerance are unchanged, to the last bit.

    Args:
        low: [N, 2] lower left corners, inside the frame.
        high: [N, 2] upper right corners, larger than `low`.
        frame: [2, 2] lower left and upper right corner of the facade, which do not move.
        tolerance: largest distance of sides on one line, in the units of the boxes, >= 0.
    """
    low, high = np.vstack([low, frame[:1]]), np.vstack([high, frame[1:]])
    sides = [_snapped_axis(low[:, axis], high[:, axis], tolerance) for axis in (0, 1)]
    lows, highs = np.stack([side[0] for side in sides], axis=1), np.stack([side[1] for side in sides], axis=1)
    lines = sides[0][2], sides[1][2]
    moved = max(
        float(np.abs(lines[axis][line_index[:, axis]] - before[:, axis]).max())
        for axis in (0, 1)
        for line_index, before in ((lows, low), (highs, high))
    )
    return Snapped(lows[:-1], highs[:-1], lines, moved)


def _scale(
    annotation: BoxAnnotation, width: float | None, height: float | None, pixels: tuple[int, int] | None
) -> tuple[Floats, list[str]]:
    """Metres [2] per unit along x and y.

    Annotations in metres keep their size if no size is given. One size determines the other by the aspect ratio of the
    picture; two sizes are used as given.
    """
    for name, value in (("width", width), ("height", height)):
        if value is not None and not 0.0 < value <= LARGEST:
            raise FacadeError(f"The {name}: expected above 0 and at most {LARGEST:,.0f} metres, found {value:g}.")
    notes: list[str] = []
    shape = np.ones(2)
    if annotation.unit == "parts" and pixels is not None:
        shape = np.array(pixels, dtype=np.float64)
    elif annotation.unit == "parts" and (width is None or height is None):
        notes.append("the aspect ratio of the picture is unknown: assumed to be 1; give a width and a height")
    extent = (annotation.frame[1] - annotation.frame[0]) * shape
    if extent.min() < _LEAST_ASPECT * max(1.0, extent.max()):
        raise FacadeError(f"The boxes span {extent[X]:g} x {extent[Y]:g} {annotation.unit}: that is no facade.")
    if annotation.unit == "metres" and width is None and height is None:
        if extent.max() > LARGEST:
            raise FacadeError(f"The facade is {extent.max():g} metres large; expected at most {LARGEST:,.0f}.")
        return shape, notes
    if width is None and height is None:
        width = DEFAULT_WIDTH_M
        hint = "give the width or height (`width=`, `height=`)"
        notes.append(f"the size of the facade is unknown: assuming a width of {width:g} m; {hint}")
    across = width / extent[X] if width is not None else None
    up = height / extent[Y] if height is not None else None
    return shape * np.array([across or up, up or across]), notes


def _snapped_axis(low: Floats, high: Floats, tolerance: float) -> tuple[Ints, Ints, Floats]:
    """Lines of the lower [N] and higher [N] sides along one axis, and their coordinates; the last box is the frame."""
    sides = np.concatenate([low, high])
    order = np.argsort(sides, kind="stable")
    values, box = sides[order], order % len(low)
    starts = _line_starts(values, _other_side_before(box), tolerance)
    lines = np.array([np.median(part) for part in np.split(values, starts[1:])])
    lines[0], lines[-1] = low[-1], high[-1]
    line = np.empty(len(sides), dtype=np.int64)
    line[order] = np.searchsorted(starts, np.arange(len(sides)), side="right") - 1
    return line[: len(low)], line[len(low) :], lines


def _line_starts(values: Floats, before: Ints, tolerance: float) -> Ints:
    """Index of the first value of each line, for ascending values [K]."""
    gaps = np.diff(values)
    wide = np.concatenate([[0], 1 + np.flatnonzero(gaps > tolerance), [len(values)]])
    starts, parts = [], list(zip(wide[:-1].tolist(), wide[1:].tolist(), strict=True))
    while parts:
        first, end = parts.pop()
        if values[end - 1] - values[first] <= tolerance and before[first:end].max() < first:
            starts.append(first)
            continue
        inside = gaps[first : end - 1]
        largest = np.flatnonzero(inside == inside.max())
        middle = first + 1 + int(largest[len(largest) // 2])
        parts += [(first, middle), (middle, end)]
    return np.sort(np.array(starts))


def _other_side_before(box: Ints) -> Ints:
    """[2 N] position of the other side of the same box if it comes first, else -1."""
    sides = np.argsort(box, kind="stable").reshape(-1, 2)
    before = np.full(len(box), -1)
    before[sides[:, 1]] = sides[:, 0]
    return before


def _corners(boxes: Ints, lines: tuple[Floats, Floats]) -> tuple[Floats, Floats]:
    """Lower left and upper right corners [N, 2] of boxes [N, 4] given by line indices."""
    low = np.stack([lines[X][boxes[:, 0]], lines[Y][boxes[:, 1]]], axis=1)
    return low, np.stack([lines[X][boxes[:, 2]], lines[Y][boxes[:, 3]]], axis=1)


def _split_notes(source: Ints, pieces: VisiblePieces, names: list[str], number: Ints) -> list[str]:
    """Names of boxes that were cut although they should be kept whole."""
    parts = np.bincount(source[source != WALL], minlength=len(names))
    cut_up = pieces.source[pieces.whole & (parts[pieces.source] > 1)].tolist()
    if not cut_up:
        return []
    listing = ", ".join(f"{names[box]} {number[box]}" for box in cut_up[:8])
    return [f"{len(cut_up)} boxes of pinwheels are cut into parts: {listing}{', …' if len(cut_up) > 8 else ''}"]


def _moved_outlines(
    outlines: list[Floats], before: tuple[Floats, Floats], after: tuple[Floats, Floats]
) -> list[Floats]:
    """Outlines moved with their boxes, from the corners of the boxes before and after snapping."""
    scale = (after[1] - after[0]) / (before[1] - before[0])
    return [after[0][k] + (outline - before[0][k]) * scale[k] for k, outline in enumerate(outlines)]


def _with_outlines(facade: Facade, source: Ints, outlines: list[Floats], wall: Floats) -> Facade:
    """The facade with outlines of shapes that are not rectangular, each leaf with its part of them.

    Args:
        facade: a facade of rectangles.
        source: [N] the box of each node, or `WALL`.
        outlines: [B] outlines of the boxes, metres; empty for rectangles.
        wall: [P, 2] outline of the wall, metres; empty for a rectangle.
    """
    points: dict[int, Floats] = {}
    outside: list[int] = []
    around = shapely.Polygon(wall) if len(wall) else None
    if around is not None:
        shapely.prepare(around)
    for node in facade.leaves.tolist():
        low, size = facade.position[node], facade.size[node]
        box = int(source[node])
        if box != WALL and len(outlines[box]):
            polygon = shapely.Polygon(outlines[box])
        elif box == WALL and around is not None:
            polygon = around
        else:
            continue
        visible = _clipped_outline(polygon, low, size)
        if visible is None:
            outside.append(node)
        elif len(visible):
            points[node] = visible
    counts = np.zeros(len(facade), dtype=np.int64)
    for node, corners in points.items():
        counts[node] = len(corners)
    label, labels = facade.label.copy(), facade.labels
    if outside:
        labels = labels if OUTSIDE in labels else (*labels, OUTSIDE)
        label[outside] = labels.index(OUTSIDE)
    ordered = [points[node] for node in sorted(points)]
    return replace(
        facade,
        label=label,
        labels=labels,
        outline_offsets=offsets_from_counts(counts),
        outline_points=np.vstack(ordered) if ordered else np.zeros((0, 2)),
    )


def _clipped_outline(polygon: shapely.Polygon, low: Floats, size: Floats) -> Floats | None:
    """Corners [P, 2] of a polygon inside a leaf, as fractions of it, anticlockwise; empty for all, None for nothing."""
    if not polygon.is_valid:
        return np.zeros((0, 2))
    high = low + size
    visible = shapely.intersection(polygon, shapely.box(low[X], low[Y], high[X], high[Y]))
    area_share = visible.area / size.prod()
    if area_share < _NEGLIGIBLE_SHARE:
        return None
    if area_share > 1.0 - _NEGLIGIBLE_SHARE or not isinstance(visible, shapely.Polygon) or visible.interiors:
        return np.zeros((0, 2))
    corners = shapely.get_coordinates(shapely.geometry.polygon.orient(visible).exterior)[:-1]
    return np.clip((corners - low) / size, 0.0, 1.0)


def _with_picture(facade: Facade, picture: Picture, area: Floats) -> Facade:
    """The facade with the leaves' parts of a picture that covers an area [2, 2], metres."""
    window = np.hstack([facade.position, facade.position + facade.size])
    window = np.clip((window - np.tile(area[0], 2)) / np.tile(area[1] - area[0], 2), 0.0, 1.0)
    leaf = facade.axis == LEAF
    return replace(
        facade,
        pictures=(picture,),
        picture=np.where(leaf, 0, -1),
        window=np.where(leaf[:, None], window, np.array([0.0, 0.0, 1.0, 1.0])),
    )
