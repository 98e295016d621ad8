"""Facades as SVG: one element per leaf, in metres."""

from __future__ import annotations

import base64
import re
from xml.etree.ElementTree import Element, SubElement, indent, tostring

import numpy as np

from grammarlab.facade.looks import look_of
from grammarlab.facade.tree import Facade, Picture

_DIGITS = 6


def svg(facade: Facade) -> str:
    """A drawing of a facade, with one unit per metre.

    Each leaf is a ``rect``, a ``path`` if it has an outline, or its part of a picture, with the class of its label;
    pictures are embedded once.
    """
    box = f"0 0 {_number(facade.width)} {_number(facade.height)}"
    root = Element("svg", {"xmlns": "http://www.w3.org/2000/svg", "viewBox": box})
    defs = SubElement(root, "defs")
    for index, picture in enumerate(facade.pictures):
        SubElement(
            defs,
            "image",
            {
                "id": f"picture{index}",
                "width": "1",
                "height": "1",
                "preserveAspectRatio": "none",
                "href": f"data:{_mime(picture)};base64,{base64.b64encode(picture.content).decode()}",
            },
        )
    for leaf in facade.leaves.tolist():
        _add_leaf(root, facade, leaf)
    indent(root)
    return tostring(root, encoding="unicode") + "\n"


def _add_leaf(root: Element, facade: Facade, leaf: int) -> None:
    label, outline = facade.name_of(leaf), facade.outline(leaf)
    width, height = facade.size[leaf].tolist()
    left, bottom = (facade.position[leaf] - facade.position[0]).tolist()
    top = facade.height - bottom - height
    box = {"x": _number(left), "y": _number(top), "width": _number(width), "height": _number(height)}
    of_class = {"class": re.sub(r"[^A-Za-z0-9_-]+", "-", label).strip("-") or "part"}
    if facade.picture[leaf] >= 0:
        u, v, right, upper = facade.window[leaf].tolist()
        view = " ".join(map(_number, (u, 1.0 - upper, right - u, upper - v)))
        part = SubElement(root, "svg", {**of_class, **box, "viewBox": view, "preserveAspectRatio": "none"})
        SubElement(part, "use", {"href": f"#picture{facade.picture[leaf]}"})
        return
    wall, look = look_of(""), look_of(label)
    if not len(outline):
        SubElement(root, "rect", {**of_class, **box, "fill": look.color})
        return
    SubElement(root, "rect", {**box, "fill": wall.color})
    corners = np.array([left, top]) + (outline * [1.0, -1.0] + [0.0, 1.0]) * [width, height]
    path = "M" + "L".join(f"{_number(x)} {_number(y)}" for x, y in corners.tolist()) + "Z"
    SubElement(root, "path", {**of_class, "d": path, "fill": look.color})


def _number(value: float) -> str:
    return f"{round(value, _DIGITS):.{_DIGITS}f}".rstrip("0").rstrip(".")


def _mime(picture: Picture) -> str:
    return "image/png" if picture.content.startswith(b"\x89PNG") else "image/jpeg"
