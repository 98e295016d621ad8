"""Formats of annotations, and the choice of the reader of a file by its content.

Each format has the test of a parsed file and its reader. The tests of a list are tried in order, so a special format
comes before a general one.
"""

from __future__ import annotations

import codecs
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Generic, TypeVar

from grammarlab.errors import FacadeError, TableError, UsageError, shown
from grammarlab.facade.reading.annotation import BoxAnnotation
from grammarlab.facade.reading.citygml import is_citygml, read_citygml
from grammarlab.facade.reading.json_annotations import (
    is_coco,
    is_createml,
    is_labelme,
    read_coco,
    read_createml,
    read_labelme,
)
from grammarlab.facade.reading.label_studio import is_label_studio, read_label_studio
from grammarlab.facade.reading.markup import local_name, parse_xml
from grammarlab.facade.reading.source import Source
from grammarlab.facade.reading.text_annotations import (
    is_box_table,
    is_picture_table,
    is_yolo,
    missing_columns,
    read_box_table,
    read_picture_table,
    read_yolo,
)
from grammarlab.facade.reading.via import is_via, is_via_table, read_via, read_via_table
from grammarlab.facade.reading.xml_annotations import (
    is_cmp,
    is_cvat,
    is_labelme_xml,
    is_voc,
    read_cmp,
    read_cvat,
    read_labelme_xml,
    read_voc,
)
from grammarlab.facade.values import parse_json, read_bounded
from grammarlab.tables import Table, decoded, read_table
from grammarlab.xml_text import Node

_Parsed = TypeVar("_Parsed")
_TABLE_SUFFIXES, _XML_SUFFIXES, _JSON_SUFFIXES = (".csv", ".tsv", ".txt"), (".xml", ".gml"), (".json",)
_SUFFIXES = (*_XML_SUFFIXES, *_JSON_SUFFIXES, *_TABLE_SUFFIXES)
_MOST_ROWS = 500_000
"""Largest number of rows of a table, which may be one of many pictures."""
_MARKS = (codecs.BOM_UTF8, codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)


@dataclass(frozen=True, slots=True)
class _Format(Generic[_Parsed]):
    """A format of annotations."""

    name: str
    matches: Callable[[_Parsed], bool]
    """Whether a parsed file has this format."""
    read: Callable[[_Parsed, Source], BoxAnnotation] | None
    """Reader of the format; None if the format is only recognised."""
    export: str = ""
    """The export of the same program that is read instead, if there is no reader."""


_XML_FORMATS: tuple[_Format[Node], ...] = (
    _Format("CityGML", is_citygml, read_citygml),
    _Format("LabelMe XML", is_labelme_xml, read_labelme_xml),
    _Format("CMP", is_cmp, read_cmp),
    _Format("Pascal VOC", is_voc, read_voc),
    _Format("CVAT for images", is_cvat, read_cvat),
    _Format("dlib's imglab XML", lambda root: root.tag == "dataset", None, "Pascal VOC or COCO"),
    _Format("KML", lambda root: local_name(root) == "kml", None, "a map: grammarlab sample reads GeoJSON"),
    _Format("SVG", lambda root: local_name(root) == "svg", None, "a table of boxes, or rules (.cga)"),
)
_JSON_FORMATS: tuple[_Format[Any], ...] = (
    _Format("VIA JSON", is_via, read_via),
    _Format(
        "COCO panoptic",
        lambda document: _has(document, "annotations") and _has_first(document["annotations"], "segments_info"),
        None,
        "COCO with one annotation for each object",
    ),
    _Format("COCO", is_coco, read_coco),
    _Format("LabelMe JSON", is_labelme, read_labelme),
    _Format("Label Studio JSON", is_label_studio, read_label_studio),
    _Format("Create ML JSON", is_createml, read_createml),
    _Format("VIA 3 JSON", lambda document: _has(document, "metadata", "view", "file"), None, "VIA 2, as COCO or JSON"),
    _Format("Supervisely JSON", lambda document: _has(document, "objects", "size"), None, "COCO or Pascal VOC"),
    _Format(
        "VoTT JSON",
        lambda document: _has(document, "asset", "regions") or _has(document, "assets", "tags"),
        None,
        "CSV or Pascal VOC",
    ),
    _Format("SuperAnnotate JSON", lambda document: _has(document, "instances", "metadata"), None, "COCO"),
    _Format("Datumaro JSON", lambda document: _has(document, "items", "categories"), None, "COCO"),
    _Format("Labelbox JSON", lambda document: _has_first(document, "data_row", "projects"), None, "COCO"),
    _Format(
        "COCO results",
        lambda document: _has_first(document, "image_id", "bbox"),
        None,
        "COCO with images and categories",
    ),
    _Format("GeoJSON", lambda document: _has(document, "features"), None, "a map: grammarlab sample reads it"),
)
_TABLE_FORMATS: tuple[_Format[Table], ...] = (
    _Format("VIA CSV", is_via_table, read_via_table),
    _Format("VIA 3 CSV", lambda table: "vgg image annotator" in " ".join(table.header), None, "VIA 2, as COCO or CSV"),
    _Format("tables of pictures (TensorFlow, RetinaNet, Open Images)", is_picture_table, read_picture_table),
    _Format("tables of boxes", is_box_table, read_box_table),
)
_TEXT_FORMATS: tuple[_Format[str], ...] = (_Format("YOLO", is_yolo, read_yolo),)


def read_annotation(path: Path, wall: str = "") -> BoxAnnotation:
    """The boxes of a file, from the reader for its format.

    Args:
        path: path of the file.
        wall: name of one facade in a file with several: a wall of CityGML, or an image.

    Raises:
        UsageError: If no reader supports such a file, or no facade in it has that name.
        FacadeError: If the file is broken; with the position of the mistake.
    """
    suffix = path.suffix.lower()
    if suffix not in _SUFFIXES:
        raise UsageError(f"{path.name}: expected a file that ends in {', '.join(_SUFFIXES)}: {_readable()}.")
    content = read_bounded(path)
    try:
        return _read(content, suffix, Source(path, wall))
    except (FacadeError, TableError) as error:
        raise FacadeError(f"{path.name}: {error}") from error
    except UsageError as error:
        raise UsageError(f"{path.name}: {error}") from error


def _has(document: Any, *keys: str) -> bool:
    """Whether a document is an object with keys."""
    return isinstance(document, dict) and all(key in document for key in keys)


def _has_first(document: Any, *keys: str) -> bool:
    """Whether a document is a list whose first entry is an object with keys."""
    return isinstance(document, list) and _has(next(iter(document), None), *keys)


def _readable() -> str:
    """The names of all formats with a reader."""
    formats: list[_Format[Any]] = [*_XML_FORMATS, *_JSON_FORMATS, *_TABLE_FORMATS, *_TEXT_FORMATS]
    return ", ".join(entry.name for entry in formats if entry.read is not None)


def _read(content: bytes, suffix: str, source: Source) -> BoxAnnotation:
    """The annotation of a file, whose first character may tell another format than its suffix."""
    first = _first_character(content)
    if first == b"<" or (suffix in _XML_SUFFIXES and first not in (b"{", b"[")):
        root = parse_xml(content)
        return _read_as(_XML_FORMATS, root, source, f"This XML has the root {shown(root.tag)}. Read are {_readable()}.")
    if first in (b"{", b"[") or suffix in _JSON_SUFFIXES:
        document = parse_json(content)
        keys = sorted(map(str, document))[:8] if isinstance(document, dict) else []
        kind = f"with the keys {', '.join(map(shown, keys))}" if keys else "without keys"
        return _read_as(_JSON_FORMATS, document, source, f"This is JSON {kind}. Read are {_readable()}.")
    if suffix == ".txt" and any(text_format.matches(text := decoded(content)) for text_format in _TEXT_FORMATS):
        return _read_as(_TEXT_FORMATS, text, source, "")
    table = read_table(content, _MOST_ROWS)
    return _read_as(_TABLE_FORMATS, table, source, f"{missing_columns(table)} Read are {_readable()}.")


def _first_character(content: bytes) -> bytes:
    """The first character of a text that is not blank, if it is in ASCII."""
    head = content[:1024]
    for mark in _MARKS:
        head = head.removeprefix(mark)
    return head.lstrip(b" \t\r\n\0")[:1]


def _read_as(formats: tuple[_Format[_Parsed], ...], parsed: _Parsed, source: Source, otherwise: str) -> BoxAnnotation:
    """The annotation of a parsed file.

    Args:
        formats: those that it may have.
        parsed: content of the file.
        source: the file.
        otherwise: message for a file of another format.

    Raises:
        FacadeError: If the file has none of the formats, or one that is not read; and as its reader.
        UsageError: As its reader.
    """
    match = next((candidate for candidate in formats if candidate.matches(parsed)), None)
    if match is None:
        raise FacadeError(otherwise)
    if match.read is None:
        raise FacadeError(f"This is {match.name}, which is not read. Export {match.export}. Read are {_readable()}.")
    return match.read(parsed, source)
