"""Labelled regions as JSON of Label Studio: tasks, with percentages of the width and height of an image.

Both of its exports are read: "JSON", and "JSON-MIN", which has the regions of a task without their annotations.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import Any

import numpy as np

from grammarlab.errors import FacadeError
from grammarlab.facade.reading.annotation import MOST_BOXES, BoxAnnotation
from grammarlab.facade.reading.drawn_shapes import (
    FRACTIONS,
    MOST_CORNERS,
    Shape,
    ellipse,
    label_of,
    on_picture,
    polygon,
    rotated,
)
from grammarlab.facade.reading.source import (
    ImageName,
    Source,
    chosen_image,
    coordinate,
    known_size,
    last_part,
    left_out_notes,
)
from grammarlab.facade.values import a_list, an_object, numbers

_ANNOTATIONS = ("annotations", "completions", "predictions")
"""Keys of the annotations of a task: today's, that of old versions, and those of models."""
_LABELS = ("rectanglelabels", "polygonlabels", "ellipselabels", "brushlabels", "keypointlabels", "labels")
_MOST_TASKS = 1_000_000
_PERCENT = 100.0
"""Width and height of an image in its percentages."""


def is_label_studio(document: Any) -> bool:
    """Whether a JSON document has tasks of Label Studio."""
    tasks = document if isinstance(document, list) else [document]
    return bool(tasks) and all(isinstance(task, dict) and (_is_task(task) or _is_short(task)) for task in tasks[:100])


def _is_task(task: dict[str, Any]) -> bool:
    return isinstance(task.get("data"), dict) and any(key in task for key in _ANNOTATIONS)


def _is_short(task: dict[str, Any]) -> bool:
    return bool(_short_regions(task)) or ("annotator" in task and "annotation_id" in task)


def _short_regions(task: dict[str, Any]) -> list[Any]:
    """The regions of a task of JSON-MIN, where each tool has a key of its own."""
    lists = [value for value in task.values() if isinstance(value, list)]
    return [region for values in lists for region in values if isinstance(region, dict) and _labels(region) is not None]


def read_label_studio(document: Any, source: Source) -> BoxAnnotation:
    """The rectangles, polygons and ellipses of one task.

    Raises:
        FacadeError: If the file does not have that form, or a rectangle is rotated on an image of unknown size.
        UsageError: If no task has the name of the image or the id, or the choice is ambiguous.
    """
    tasks = [
        an_object(task, f"task {number}")
        for number, task in enumerate(
            a_list(document if isinstance(document, list) else [document], "tasks", _MOST_TASKS), start=1
        )
    ]
    names = [ImageName(_image_of(task), str(task.get("id", ""))[:40]) for task in tasks]
    index = chosen_image(names, source.wall)
    where = f"task {names[index].text}"
    values, notes = _regions(tasks[index], where)
    regions = [an_object(value, f"{where}, region {number}") for number, value in enumerate(values, start=1)]
    picture = last_part(names[index].file)
    size = next(
        filter(None, (known_size(*map(entry.get, ("original_width", "original_height"))) for entry in regions)), None
    )
    size = size or source.picture_size(picture)
    shapes: list[Shape] = []
    left_out: Counter[str] = Counter()
    labelled = {str(region["id"]) for region in regions if "id" in region and _labels(_value(region))}
    for number, region in enumerate(regions, start=1):
        value = _value(region)
        labels = _labels(value)
        shape = _shape(value, labels[0], f"{where}, region {number}", size) if labels else None
        if shape is not None:
            shapes.append(shape)
        elif labels or str(region.get("id")) not in labelled:  # a rectangle may have its label in a region of its own
            left_out[str(region.get("type") or "region without label")[:40]] += 1
    notes += [*left_out_notes(left_out), *_first_label_notes(regions)]
    return on_picture(shapes, source, size=size or FRACTIONS, picture=picture, notes=notes)


def _image_of(task: dict[str, Any]) -> str:
    """The address of the image of a task: the first text that ends as a picture file does, or the first text."""
    data = task.get("data") if isinstance(task.get("data"), dict) else task
    texts = [value for key, value in data.items() if isinstance(value, str) and not key.endswith("_at")] if data else []
    pictures = [text for text in texts if text.lower().partition("?")[0].endswith((".png", ".jpg", ".jpeg"))]
    return [*pictures, *texts, ""][0].partition("?")[0]


def _regions(task: dict[str, Any], where: str) -> tuple[list[Any], list[str]]:
    """The regions of the first annotation that was not cancelled, and notes."""
    if not _is_task(task):
        return _short_regions(task), []
    for key in _ANNOTATIONS:
        annotations = [
            annotation
            for annotation in a_list(task.get(key) or [], f"{where}, {key}", MOST_BOXES)
            if isinstance(annotation, dict) and not annotation.get("was_cancelled") and annotation.get("result")
        ]
        if annotations:
            notes = [f"the task has {len(annotations)} {key}: the first one is read"] if len(annotations) > 1 else []
            notes += ["the boxes are predictions of a model"] if key == "predictions" else []
            return a_list(annotations[0]["result"], f"{where}, result", MOST_BOXES), notes
    return [], []


def _value(region: dict[str, Any]) -> dict[str, Any]:
    """The shape of a region; in JSON-MIN, the region itself."""
    value = region.get("value", region)
    return value if isinstance(value, dict) else {}


def _labels(value: dict[str, Any]) -> Sequence[Any] | None:
    """The labels of a shape; None if it has no key for them."""
    return next((value[key] for key in _LABELS if isinstance(value.get(key), list)), None)


def _first_label_notes(regions: Sequence[dict[str, Any]]) -> list[str]:
    """A note on shapes with several labels."""
    number = sum(len(_labels(_value(region)) or ()) > 1 for region in regions)
    return [f"{number} shapes have several labels, of which the first one is read"] if number else []


def _shape(value: dict[str, Any], label: Any, where: str, size: tuple[float, float] | None) -> Shape | None:
    """A shape in pixels, or in fractions if the size is unknown; None if it is not an area."""
    name = label_of(label, f"{where}, label")
    scale = np.array(size or FRACTIONS) / _PERCENT
    if "points" in value:
        points = a_list(value["points"], f"{where}, points", MOST_CORNERS)
        corners = [[coordinate(number, where) for number in numbers(point, f"{where}, points", 2)] for point in points]
        return polygon(name, np.array(corners) * scale) if len(corners) >= 3 else None
    degrees = coordinate(value.get("rotation") or 0.0, f"{where}, rotation")
    if degrees % 360.0 and size is None:
        raise FacadeError(
            f"{where}: a rotated shape needs the size of its image: original_width and original_height, or the image "
            "itself in the folder of the file."
        )
    keys = ("x", "y", "radiusX", "radiusY") if "radiusX" in value else ("x", "y", "width", "height")
    if not all(key in value for key in keys):
        return None
    percent = np.array([coordinate(value[key], f"{where}, {key}") for key in keys]).reshape(2, 2)
    (left, top), (wide, high) = (percent * scale).tolist()
    if "radiusX" in value:
        return ellipse(name, (left, top), (wide, high), degrees)
    return rotated(name, (left, top, left + wide, top + high), degrees, (left, top))
