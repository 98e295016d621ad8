"""The choice of a reader for a file, by its content."""

from __future__ import annotations

import codecs
from pathlib import Path

from grammarlab.errors import FacadeError, TableError, UsageError
from grammarlab.facade.boxes.annotation import BoxAnnotation
from grammarlab.facade.reading.formats import JSON, TABLES, TEXTS, XML, read_as, readable
from grammarlab.facade.reading.markup import parse_xml
from grammarlab.facade.reading.source import Source
from grammarlab.facade.reading.table import missing_columns
from grammarlab.facade.values import parse_json, read_bounded, shown
from grammarlab.tables import decoded, read_table

_TABLES, _MARKUP, _JSON = (".csv", ".tsv", ".txt"), (".xml", ".gml"), (".json",)
SUFFIXES = (*_MARKUP, *_JSON, *_TABLES)
MOST_ROWS = 500_000
"""Largest number of rows of a table, which may be one of many pictures."""
_MARKS = (codecs.BOM_UTF8, codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)


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
    if suffix not in SUFFIXES:
        raise UsageError(f"{path.name}: expected a file that ends in {', '.join(SUFFIXES)}: {readable()}.")
    content = read_bounded(path)
    try:
        return _read(content, suffix, Source(path, wall))
    except (FacadeError, TableError) as error:
        raise FacadeError(f"{path.name}: {error}") from error
    except UsageError as error:
        raise UsageError(f"{path.name}: {error}") from error


def _read(content: bytes, suffix: str, source: Source) -> BoxAnnotation:
    """The annotation of a file, whose first character may tell another format than its suffix."""
    first = _first_character(content)
    if first == b"<" or (suffix in _MARKUP and first not in (b"{", b"[")):
        root = parse_xml(content)
        return read_as(XML, root, source, f"This XML has the root {shown(root.tag)}. Read are {readable()}.")
    if first in (b"{", b"[") or suffix in _JSON:
        document = parse_json(content)
        keys = sorted(map(str, document))[:8] if isinstance(document, dict) else []
        kind = f"with the keys {', '.join(map(shown, keys))}" if keys else "without keys"
        return read_as(JSON, document, source, f"This is JSON {kind}. Read are {readable()}.")
    if suffix == ".txt" and any(each.matches(text := decoded(content)) for each in TEXTS):
        return read_as(TEXTS, text, source, "")
    table = read_table(content, MOST_ROWS)
    return read_as(TABLES, table, source, f"{missing_columns(table)} Read are {readable()}.")


def _first_character(content: bytes) -> bytes:
    """The first character of a text that is not blank, if it is in ASCII."""
    head = content[:1024]
    for mark in _MARKS:
        head = head.removeprefix(mark)
    return head.lstrip(b" \t\r\n\0")[:1]
