"""The completed facade of a match: every element complete and in place, with wall around it."""

from __future__ import annotations

import numpy as np
import shapely
from shapely.geometry.polygon import orient

from grammarlab.facade.boxes.annotation import annotate
from grammarlab.facade.boxes.assembling import LARGEST, Assembled, assemble
from grammarlab.facade.templates.elements import Floats
from grammarlab.facade.templates.kinds.match import Match, drawn_parameters
from grammarlab.facade.templates.template import HEIGHT, WIDTH, Template, points_along

_BORDER = 0.5
"""Width of the wall around the outermost elements, metres."""
_SNAP = 0.0005
"""Largest distance of sides that are moved to one line, as a fraction of the shorter side of the facade."""


def completed(match: Match) -> Assembled | None:
    """The facade of all elements with a template; None if there is none, or it would be too large.

    An element is a box with its template's width and height, with its outline inside; parts beyond it are left out.
    """
    boxes, names, outlines = [], [], []
    for element in range(len(match.kind)):
        found = drawn_parameters(match, element)
        if found is None:
            continue
        template, parameters = found
        corner, size = match.corner[element], parameters[[WIDTH, HEIGHT]]
        boxes.append([*corner, *(corner + size)])
        names.append(f"{match.name_of(int(match.kind[element]))} {_thing(template)}")
        outlines.append(
            outer(template, parameters) + corner if not _rectangular(template, parameters) else np.zeros((0, 2))
        )
    if not boxes:
        return None
    every = np.array(boxes)
    bounds = np.stack([every[:, :2].min(axis=0) - _BORDER, every[:, 2:].max(axis=0) + _BORDER])
    if (bounds[1] - bounds[0]).max() > LARGEST:
        return None
    boxes_and_wall = np.vstack([bounds.reshape(1, 4), every])
    none = np.zeros((0, 2))
    annotation = annotate(boxes_and_wall, ["wall", *names], "metres", outlines=[none, *outlines], bounds=bounds)
    return assemble(annotation, tolerance=_SNAP, split=True)


def outer(template: Template, parameters: Floats) -> Floats:
    """[P, 2] corners, anticlockwise, of the area that the wires of a template enclose, within its width and height."""
    segments = points_along(template, parameters)
    around = shapely.union_all([shapely.LineString(each) for each in segments]).convex_hull
    inside = around.intersection(shapely.box(0.0, 0.0, parameters[WIDTH], parameters[HEIGHT]))
    if not isinstance(inside, shapely.Polygon) or inside.area <= 0.0:
        return np.zeros((0, 2))
    return np.asarray(orient(inside).exterior.coords)[:-1]


def _rectangular(template: Template, parameters: Floats) -> bool:
    corners = outer(template, parameters)
    if not len(corners):
        return True
    return shapely.Polygon(corners).area >= 0.999 * parameters[WIDTH] * parameters[HEIGHT]


def _thing(template: Template) -> str:
    """The label of a template, which determines its look in pictures."""
    for name in ("door", "gate", "column", "pilaster"):
        if name in template.base:
            return name
    return "window"
