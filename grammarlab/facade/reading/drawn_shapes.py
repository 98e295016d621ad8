"""Labelled shapes on a picture, as drawing programs write them, with outlines of those that are not rectangular.

x points to the right, y down from the upper left corner.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely

from grammarlab.arrays import Floats
from grammarlab.errors import FacadeError
from grammarlab.facade.reading.annotation import LONGEST_NAME, BoxAnnotation, Unit, annotate, check_count
from grammarlab.facade.reading.source import Source
from grammarlab.facade.values import a_text

MOST_CORNERS = 10_000
"""Largest number of corners of an outline."""
_RECTANGULAR = 0.999
"""Least part of its box that the polygon of a rectangle fills."""
FRACTIONS = (1.0, 1.0)
"""Size of a picture whose shapes are given as fractions."""
_NOTED_ROTATION = 1.0
"""Least rotation of a rectangle that is reported, degrees: less is an unsteady hand."""
_SAME_ASPECT = 0.01
"""Largest relative difference of aspect ratios that rounding to whole pixels explains."""
_ELLIPSE_CORNERS = 32
_NO_OUTLINE = np.zeros((0, 2))


@dataclass(frozen=True, slots=True)
class Shape:
    """One labelled shape."""

    name: str
    box: tuple[float, float, float, float]
    """Left, top, right, bottom."""
    outline: Floats
    """[P, 2] corners, if it may be something else than an upright rectangle; empty otherwise."""
    degrees: float = 0.0
    """Rotation of a rectangle against the nearest upright one, -45 to 45; 0 for other shapes."""


def on_picture(
    shapes: Sequence[Shape],
    source: Source,
    *,
    size: tuple[float, float] | None,
    picture: str = "",
    notes: Sequence[str] = (),
) -> BoxAnnotation:
    """The annotation of a picture.

    Args:
        shapes: shapes of the picture, in pixels, or in fractions if the size is `FRACTIONS`.
        source: the file.
        size: width and height of the picture, pixels; if unknown, that of the picture beside the file. Without any, the
            shapes have no bounds, and show no picture.
        picture: file name of the picture.
        notes: notes so far.

    Raises:
        FacadeError: If the boxes are unusable, see `annotate`, or the picture beside the file is broken.
    """
    check_count(len(shapes))
    remarks = [*notes, *_rotation_notes(shapes), *_crossing_notes(shapes)]
    unit: Unit = "parts" if size is FRACTIONS else "pixels"
    if unit == "pixels":
        actual = source.picture_size(picture)
        remarks += _size_notes(picture, size, actual)
        size = size or actual
    boxes = np.array([shape.box for shape in shapes]).reshape(-1, 4)
    height = float(boxes[:, 3].max(initial=0.0)) if size is None else size[1]
    return annotate(
        np.column_stack([boxes[:, 0], height - boxes[:, 3], boxes[:, 2], height - boxes[:, 1]]),
        [shape.name for shape in shapes],
        unit,
        outlines=[_outline(shape.outline, size, height) for shape in shapes],
        bounds=None if size is None else np.array([[0.0, 0.0], size]),
        picture=picture if size is not None else "",
        notes=remarks,
    )


def outline_of(points: Floats) -> Floats:
    """The points [P, 2]; none if they form a rectangle or have no area.

    A polygon that crosses itself is not an outline, nor is one of more than `MOST_CORNERS`.
    """
    if not 3 <= len(points) <= MOST_CORNERS or not np.isfinite(points).all():
        return _NO_OUTLINE
    polygon = shapely.Polygon(points)
    extent = np.ptp(points, axis=0).prod()
    if not polygon.is_valid or not 0.0 < polygon.area < _RECTANGULAR * extent:
        return _NO_OUTLINE
    return points


def sides_around(across: float, down: float, width: float, height: float) -> tuple[float, float, float, float]:
    """Left, top, right and bottom of a rectangle with a centre and a size."""
    return across - width / 2.0, down - height / 2.0, across + width / 2.0, down + height / 2.0


def upright(name: str, left: float, top: float, right: float, bottom: float) -> Shape:
    """An upright rectangle; a negative size is refused later, with the name of the box."""
    return Shape(name, (left, top, right, bottom), _NO_OUTLINE)


def polygon(name: str, corners: Floats, *, rectangle: bool = False) -> Shape:
    """A polygon [P, 2] of at least one corner.

    Args:
        name: label of the shape.
        corners: [P, 2] corners in order.
        rectangle: whether its four corners are those of a rectangle, whose rotation is then measured.
    """
    (left, top), (right, bottom) = corners.min(axis=0).tolist(), corners.max(axis=0).tolist()
    degrees = 0.0
    if rectangle and len(corners) == 4:
        across, down = (corners[1] - corners[0]).tolist()
        degrees = _from_upright(float(np.degrees(np.arctan2(down, across))))
    return Shape(name, (left, top, right, bottom), corners, degrees)


def rotated(name: str, sides: Sequence[float], degrees: float, pivot: tuple[float, float] | None = None) -> Shape:
    """A rectangle that is rotated clockwise on the picture.

    Args:
        name: label of the shape.
        sides: left, top, right, bottom before the rotation.
        degrees: angle of the rotation.
        pivot: the point that stays; the centre when left out.
    """
    left, top, right, bottom = sides
    if not degrees % 360.0:
        return upright(name, left, top, right, bottom)
    corners = np.array([[left, top], [right, top], [right, bottom], [left, bottom]])
    fixed = corners.mean(axis=0) if pivot is None else np.array(pivot)
    return polygon(name, fixed + _turned(corners - fixed, degrees), rectangle=True)


def ellipse(name: str, center: tuple[float, float], radii: tuple[float, float], degrees: float = 0.0) -> Shape:
    """An ellipse as a polygon; rotated clockwise on the picture."""
    angle = np.linspace(0.0, 2.0 * np.pi, _ELLIPSE_CORNERS, endpoint=False)
    around = np.stack([np.cos(angle), np.sin(angle)], axis=1) * np.abs(radii)
    return polygon(name, np.array(center) + _turned(around, degrees))


def label_of(value: object, where: str) -> str:
    """The label of a shape, without blanks around it.

    Raises:
        FacadeError: If it is not a text, is empty, or is too long.
    """
    label = a_text(value, where, LONGEST_NAME).strip()
    if not label:
        raise FacadeError(f"{where}: expected the label of the shape, found none.")
    return label


def _rotation_notes(shapes: Sequence[Shape]) -> list[str]:
    angles = [abs(shape.degrees) for shape in shapes if abs(shape.degrees) > _NOTED_ROTATION]
    if not angles:
        return []
    note = f"{len(angles)} rectangles are rotated, by up to {max(angles):.1f} degrees"
    return [f"{note}: their outlines are kept, in boxes that surround them"]


def _crossing_notes(shapes: Sequence[Shape]) -> list[str]:
    number = sum(len(shape.outline) >= 3 and not shapely.Polygon(shape.outline).is_valid for shape in shapes)
    return [f"{number} polygons cross themselves and are read as their boxes"] if number else []


def _size_notes(picture: str, size: tuple[float, float] | None, actual: tuple[float, float] | None) -> list[str]:
    """A note if the picture beside the file has another aspect ratio than its annotation, such as a turned one."""
    if size is None or actual is None or abs(size[0] * actual[1] / (size[1] * actual[0]) - 1.0) <= _SAME_ASPECT:
        return []
    note = f"{picture} has {actual[0]:g} x {actual[1]:g} pixels, but its annotation {size[0]:g} x {size[1]:g}"
    return [f"{note}: the picture may be turned or cut, and is stretched"]


def _outline(corners: Floats, size: tuple[float, float] | None, height: float) -> Floats:
    """An outline with y up, cut at the borders of the picture."""
    outline = outline_of(corners)
    if len(outline) and size is not None and ((outline < 0.0).any() or (outline > size).any()):
        inside = shapely.Polygon(outline).intersection(shapely.box(0.0, 0.0, *size))
        if not isinstance(inside, shapely.Polygon) or inside.is_empty:
            return _NO_OUTLINE
        outline = outline_of(shapely.get_coordinates(inside.exterior)[:-1])
    return np.column_stack([outline[:, 0], height - outline[:, 1]])


def _from_upright(degrees: float) -> float:
    """Angle against the nearest multiple of 90 degrees."""
    return (degrees + 45.0) % 90.0 - 45.0


def _turned(points: Floats, degrees: float) -> Floats:
    """Points [P, 2] rotated about the origin; clockwise, since y points down."""
    angle = np.radians(degrees)
    return points @ np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
