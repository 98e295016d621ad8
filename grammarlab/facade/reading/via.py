"""Labelled regions of the VGG Image Annotator (VIA 1 and 2), as JSON or CSV, in pixels from the top left.

Regions have free attributes; one of them is the label, see `_label_key`. The files do not have the size of a picture.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from grammarlab.errors import FacadeError, shown
from grammarlab.facade.reading.annotation import MOST_BOXES, BoxAnnotation
from grammarlab.facade.reading.drawn_shapes import MOST_CORNERS, Shape, ellipse, label_of, on_picture, polygon, upright
from grammarlab.facade.reading.source import ImageName, Source, chosen_image, coordinate, known_size, left_out_notes
from grammarlab.facade.values import a_list, an_object, parse_json
from grammarlab.tables import Table

_LABEL_KEYS = ("label", "class", "category", "name", "type", "object")
"""Usual names of the attribute that is the label, the most usual first."""
_AREAS = ("rect", "polygon", "circle", "ellipse")
_IMAGES = "_via_img_metadata"
_CELLS = ("filename", "region_shape_attributes", "region_attributes")


@dataclass(frozen=True, slots=True)
class _Region:
    """One region of an image."""

    where: str
    """Position of the region, for messages."""
    shape: dict[str, Any]
    attributes: dict[str, Any]


def is_via(document: Any) -> bool:
    """Whether a JSON document is a project of VIA, or its exported annotations."""
    if not isinstance(document, dict):
        return False
    images = document.get(_IMAGES, document)
    return _IMAGES in document or (
        bool(images)
        and all(isinstance(image, dict) and {"filename", "regions"} <= image.keys() for image in images.values())
    )


def is_via_table(table: Table) -> bool:
    """Whether a table is one of VIA."""
    return "region_shape_attributes" in table.header


def read_via(document: dict[str, Any], source: Source) -> BoxAnnotation:
    """The regions of one image of a project, or of exported annotations.

    Raises:
        FacadeError: If a region has not the form of its shape, or no region has a label.
        UsageError: If no image has the name, or the choice is ambiguous.
    """
    images = an_object(document.get(_IMAGES, document), _IMAGES)
    keys = list(images)
    entries = [an_object(images[key], f"image {shown(key)}") for key in keys]
    names = [ImageName(str(entry.get("filename", "")), key) for key, entry in zip(keys, entries, strict=True)]
    index = chosen_image(names, source.wall)
    entry, name = entries[index], names[index]
    regions = entry.get("regions")
    regions = list(regions.values()) if isinstance(regions, dict) else regions  # an object in VIA 1
    where = f"image {name.text}, region"
    options = document.get("_via_attributes")
    attributes = entry.get("file_attributes")
    size = known_size(attributes.get("width"), attributes.get("height")) if isinstance(attributes, dict) else None
    return _annotation(
        [
            _region(an_object(region, f"{where} {number}"), f"{where} {number}")
            for number, region in enumerate(a_list(regions, f"{where}s", MOST_BOXES), start=1)
        ],
        source,
        name.file,
        size,
        options.get("region") if isinstance(options, dict) else None,
    )


def read_via_table(table: Table, source: Source) -> BoxAnnotation:
    """The regions of one image of a table.

    Raises:
        FacadeError: As `read_via`, or if a line has another form than the header.
        UsageError: As `read_via`.
    """
    columns = [name.lstrip("#") for name in table.header]
    missing = [name for name in _CELLS if name not in columns]
    if missing:
        raise FacadeError(f"Line 1: this is a table of VIA without the column {missing[0]}.")
    column_indices = [columns.index(name) for name in _CELLS]
    rows = [row for row in table.body if len(row.cells) > max(column_indices)]
    if len(rows) < len(table.body):
        raise FacadeError(f"Expected {len(columns)} fields in each line of this table of VIA, found fewer.")
    images = list(dict.fromkeys(row.cells[column_indices[0]] for row in rows))
    image = images[chosen_image([ImageName(name) for name in images], source.wall)]
    regions = []
    for row in rows:
        file, shape, attributes = (row.cells[column] for column in column_indices)
        if file == image and shape not in ("", "{}"):  # an image without regions has one line
            where = f"line {row.line}"
            texts = {"shape_attributes": shape, "region_attributes": attributes or "{}"}
            regions.append(_region({key: _parsed(text, where) for key, text in texts.items()}, where))
    return _annotation(a_list(regions, "regions of the image", MOST_BOXES), source, image, None, None)


def _parsed(text: str, where: str) -> Any:
    try:
        return parse_json(text.encode())
    except FacadeError as error:
        raise FacadeError(f"{where}: {error}") from error


def _region(region: dict[str, Any], where: str) -> _Region:
    shape = an_object(region.get("shape_attributes"), f"{where}, shape_attributes")
    return _Region(where, shape, an_object(region.get("region_attributes", {}), f"{where}, region_attributes"))


def _annotation(
    regions: Sequence[_Region], source: Source, picture: str, size: tuple[float, float] | None, options: Any
) -> BoxAnnotation:
    key, notes = _label_key(regions)
    names = _option_names(options, key)
    shapes: list[Shape] = []
    left_out: Counter[str] = Counter()
    for region in regions:
        kind = region.shape.get("name")
        label = _text(region.attributes.get(key))
        if kind not in _AREAS:
            left_out[str(kind)[:20]] += 1
        elif not label:
            left_out[f"{kind} without {shown(key)}"] += 1
        else:
            shapes.append(_shape(region, kind, label_of(names.get(label, label), f"{region.where}, {key}")))
    return on_picture(shapes, source, size=size, picture=picture, notes=[*notes, *left_out_notes(left_out)])


def _label_key(regions: Sequence[_Region]) -> tuple[str, list[str]]:
    """The attribute that is the label: the one that most regions have; of several, the most usual name, then the first.

    Returns:
        Its name, and a note if there are other attributes.

    Raises:
        FacadeError: If there are regions, and no region has a text as attribute.
    """
    counts = Counter(key for region in regions for key, value in region.attributes.items() if _text(value))
    if not counts:
        if regions:
            raise FacadeError(
                f"None of the {len(regions)} regions of this VIA file has a label: give each a region attribute "
                "such as label."
            )
        return "", []
    most = max(counts.values())
    keys = [key for key, count in counts.items() if count == most]
    usual = [name for name in _LABEL_KEYS for key in keys if key.lower() == name]
    key = next((key for key in keys if usual and key.lower() == usual[0]), keys[0])
    other_keys = [shown(name) for name in counts if name != key]
    if not other_keys:
        return key, []
    return key, [f"the attribute {shown(key)} is read as the label; others are not: {', '.join(other_keys[:8])}"]


def _text(value: Any) -> str:
    """An attribute as text: a choice of several options is an object whose keys are the chosen ones."""
    if isinstance(value, dict):
        value = next((key for key, chosen in value.items() if chosen), "")
    return value.strip() if isinstance(value, str) else ""


def _option_names(attributes: Any, key: str) -> dict[str, str]:
    """Names of options whose ids are numbers, from the definition of an attribute in a project."""
    definition = attributes.get(key) if isinstance(attributes, dict) else None
    options = definition.get("options") if isinstance(definition, dict) else None
    if not isinstance(options, dict):
        return {}
    return {
        key: name for key, name in options.items() if key.strip().isdigit() and isinstance(name, str) and name.strip()
    }


def _shape(region: _Region, kind: str, label: str) -> Shape:
    shape, where = region.shape, region.where
    if kind == "polygon":
        columns = [
            [coordinate(value, f"{where}, {key}") for value in a_list(shape.get(key), f"{where}, {key}", MOST_CORNERS)]
            for key in ("all_points_x", "all_points_y")
        ]
        if len(columns[0]) != len(columns[1]) or len(columns[0]) < 3:
            raise FacadeError(f"{where}: expected at least 3 corners, with one x for each y.")
        return polygon(label, np.array(columns).T)
    keys = {"rect": ("x", "y", "width", "height"), "circle": ("cx", "cy", "r"), "ellipse": ("cx", "cy", "rx", "ry")}
    across, down, *sizes = (coordinate(shape.get(key), f"{where}, {key}") for key in keys[kind])
    if kind == "rect":
        return upright(label, across, down, across + sizes[0], down + sizes[1])
    radians = coordinate(shape.get("theta", 0.0), f"{where}, theta")
    return ellipse(label, (across, down), (sizes[0], sizes[-1]), float(np.degrees(radians)))
