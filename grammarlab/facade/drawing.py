"""Front views of facades: pictures, and SVG with one element per leaf, in metres.

Leaves that have pictures show them; other leaves have the looks of their labels.
"""

from __future__ import annotations

import base64
import re
from io import BytesIO
from xml.etree.ElementTree import Element, SubElement, indent, tostring

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from grammarlab.errors import FacadeError
from grammarlab.facade.looks import look_of
from grammarlab.facade.scene import realize_facade
from grammarlab.facade.tree import Facade, Picture, X, Y
from grammarlab.rendering.camera import View, frame
from grammarlab.rendering.light.look import Look
from grammarlab.rendering.raycast import RaycastRenderer
from grammarlab.rendering.renderer import LARGEST_AREA, LARGEST_SIDE, RenderOptions
from grammarlab.scene import TriangleBatch, triangles

_DIGITS = 6
_LOOK = Look(sun_azimuth=-38.0, sun_elevation=40.0, exposure=0.66)
"""Light for a wall that faces the camera, which gets less light than the sides of whole models."""


def draw(facade: Facade, pixels_per_metre: float, samples: int = 2) -> NDArray[np.uint8]:
    """A picture [height, width, 3] of a facade, without surroundings.

    Args:
        facade: the facade.
        pixels_per_metre: > 0.
        samples: samples along each side of a pixel, where the facade has no picture.

    Raises:
        FacadeError: If the picture would be too large, or a picture of the facade is broken.
    """
    width, height = picture_size(facade.width, facade.height, pixels_per_metre)
    leaves = facade.leaves[facade.picture[facade.leaves] >= 0]
    if len(leaves) == len(facade.leaves):
        picture = Image.new("RGB", (width, height))
    else:
        picture = Image.fromarray(front(triangles(realize_facade(facade)), width, height, samples=samples))
    opened = [_opened(entry) for entry in facade.pictures]
    sides = np.array([width, height]) / facade.size[0]
    low = np.rint((facade.position - facade.position[0]) * sides).astype(np.int64)
    high = np.rint((facade.position - facade.position[0] + facade.size) * sides).astype(np.int64)
    for leaf in leaves.tolist():
        size = high[leaf] - low[leaf]
        if (size > 0).all():
            part = _cropped(opened[facade.picture[leaf]], facade.window[leaf], (int(size[X]), int(size[Y])))
            picture.paste(part, (int(low[leaf, X]), int(height - high[leaf, Y])))
    return np.asarray(picture)


def front(batch: TriangleBatch, width: int, height: int, azimuth: float = 0.0, samples: int = 2) -> NDArray[np.uint8]:
    """A picture [height, width, 3] of one model that fills it, in orthographic projection.

    Args:
        batch: one model.
        width: pixels.
        height: pixels.
        azimuth: direction of the camera, degrees from +z towards +x.
        samples: samples along each side of a pixel.
    """
    view = View(azimuth, elevation=0.0, field_of_view=0.0, margin=0.0)
    options = RenderOptions(
        width=width, height=height, samples=samples, openness_rays=8, ground=False, view=view, look=_LOOK
    )
    return RaycastRenderer().render(batch, frame(batch.vertices, width / height, view), options)


def picture_size(width: float, height: float, pixels_per_metre: float) -> tuple[int, int]:
    """Width and height in pixels, at least 1.

    Raises:
        FacadeError: If there are too many pixels.
    """
    pixels = max(1, round(width * pixels_per_metre)), max(1, round(height * pixels_per_metre))
    if max(pixels) > LARGEST_SIDE or pixels[0] * pixels[1] > LARGEST_AREA:
        raise FacadeError(
            f"A picture of {pixels[0]} x {pixels[1]} pixels is too large: expected at most {LARGEST_SIDE} along a side "
            f"and {LARGEST_AREA:,} in all. Use fewer pixels per metre."
        )
    return pixels


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


def _opened(picture: Picture) -> Image.Image:
    try:
        with Image.open(BytesIO(picture.content), formats=("PNG", "JPEG")) as image:
            return image.convert("RGB")
    except Exception as error:  # readers raise any exception for a broken file
        raise FacadeError(f"The picture {picture.name!r} cannot be read: {error}") from error


def _cropped(image: Image.Image, window: NDArray[np.float64], size: tuple[int, int]) -> Image.Image:
    """The part of an image in a window, with the given number of pixels."""
    left, bottom, right, top = np.clip(window, 0.0, 1.0).tolist()
    box = (left * image.width, (1.0 - top) * image.height, right * image.width, (1.0 - bottom) * image.height)
    if box[2] - box[0] < 1e-6 or box[3] - box[1] < 1e-6:
        return image.resize(size)
    return image.resize(size, Image.Resampling.BILINEAR, box=box, reducing_gap=None)


def _number(value: float) -> str:
    return f"{round(value, _DIGITS):.{_DIGITS}f}".rstrip("0").rstrip(".")


def _mime(picture: Picture) -> str:
    return "image/png" if picture.content.startswith(b"\x89PNG") else "image/jpeg"


def _add_leaf(root: Element, facade: Facade, leaf: int) -> None:
    label, outline = facade.name_of(leaf), facade.outline(leaf)
    width, height = facade.size[leaf].tolist()
    left, bottom = (facade.position[leaf] - facade.position[0]).tolist()
    top = facade.height - bottom - height
    box = {"x": _number(left), "y": _number(top), "width": _number(width), "height": _number(height)}
    class_attribute = {"class": re.sub(r"[^A-Za-z0-9_-]+", "-", label).strip("-") or "part"}
    if facade.picture[leaf] >= 0:
        u, v, right, upper = facade.window[leaf].tolist()
        view = " ".join(map(_number, (u, 1.0 - upper, right - u, upper - v)))
        part = SubElement(root, "svg", {**class_attribute, **box, "viewBox": view, "preserveAspectRatio": "none"})
        SubElement(part, "use", {"href": f"#picture{facade.picture[leaf]}"})
        return
    wall, look = look_of(""), look_of(label)
    if not len(outline):
        SubElement(root, "rect", {**class_attribute, **box, "fill": look.color})
        return
    SubElement(root, "rect", {**box, "fill": wall.color})
    corners = np.array([left, top]) + (outline * [1.0, -1.0] + [0.0, 1.0]) * [width, height]
    path = "M" + "L".join(f"{_number(x)} {_number(y)}" for x, y in corners.tolist()) + "Z"
    SubElement(root, "path", {**class_attribute, "d": path, "fill": look.color})
