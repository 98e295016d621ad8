"""The choice of a reader for a file."""

from __future__ import annotations

from pathlib import Path

from grammarlab.errors import FacadeError, UsageError
from grammarlab.facade.boxes.annotation import BoxAnnotation
from grammarlab.facade.reading.citygml import read_citygml
from grammarlab.facade.reading.cmp import read_cmp
from grammarlab.facade.reading.coco import read_coco
from grammarlab.facade.reading.labelme import read_labelme
from grammarlab.facade.reading.table import read_table
from grammarlab.facade.values import parse_json, read_bounded, shown

SUFFIXES = (".xml", ".gml", ".json", ".csv")
_HEAD = 64 * 1024
"""Number of bytes of an XML file that determine its kind."""


def read_annotation(path: Path, wall: str = "") -> BoxAnnotation:
    """The boxes of a file, from the reader for its format.

    Args:
        path: path of the file.
        wall: name of one facade in a file with several: a wall of CityGML, an image of COCO.

    Raises:
        UsageError: If no reader supports such a file, or no facade in it has that name.
        FacadeError: If the file is broken; with the position of the mistake.
    """
    suffix = path.suffix.lower()
    if suffix not in SUFFIXES:
        raise UsageError(f"{path.name}: expected a file that ends in {', '.join(SUFFIXES)}.")
    content = read_bounded(path)
    try:
        if suffix == ".csv":
            return _only(read_table(content), wall)
        if suffix == ".json":
            return _read_json(content, wall)
        if suffix == ".gml" or b"CityModel" in content[:_HEAD]:
            return read_citygml(content, wall)
        return _only(read_cmp(content, path.name), wall)
    except FacadeError as error:
        raise FacadeError(f"{path.name}: {error}") from error
    except UsageError as error:
        raise UsageError(f"{path.name}: {error}") from error


def _only(annotation: BoxAnnotation, wall: str) -> BoxAnnotation:
    """The facade of a file that has only one."""
    if wall:
        raise UsageError("this file has only one facade: leave out --wall.")
    return annotation


def _read_json(content: bytes, wall: str) -> BoxAnnotation:
    document = parse_json(content)
    keys = set(document) if isinstance(document, dict) else set()
    if {"images", "annotations"} <= keys:
        return read_coco(document, wall)
    if "shapes" in keys:
        return _only(read_labelme(document), wall)
    raise FacadeError(
        'expected COCO JSON, which has "images" and "annotations", or LabelMe JSON, which has "shapes"; found '
        f"{shown(sorted(map(str, keys))[:8]) if keys else 'no object'}."
    )
