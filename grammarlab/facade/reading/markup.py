"""XML of strangers: without entities or document types, bounded in size and depth."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import TypeAlias
from xml.etree.ElementTree import Element, ParseError, TreeBuilder  # defusedxml does the parsing
from xml.parsers.expat.errors import XML_ERROR_JUNK_AFTER_DOC_ELEMENT, XML_ERROR_NO_ELEMENTS, codes

from defusedxml.common import DefusedXmlException
from defusedxml.ElementTree import DefusedXMLParser

from grammarlab.errors import FacadeError
from grammarlab.facade.reading.source import coordinate

MOST_ELEMENTS = 5_000_000
MOST_DEPTH = 100
_DECLARATION = re.compile(rb"\A\s*(?:\xef\xbb\xbf)?\s*<\?xml[^>]*\?>")

_SEVERAL = (codes[XML_ERROR_JUNK_AFTER_DOC_ELEMENT], codes[XML_ERROR_NO_ELEMENTS])
"""Codes of errors about a file that has not one outermost element, but several, or only text."""

Node: TypeAlias = Element
"""An element of a parsed file."""


class _Bounded(TreeBuilder):
    """A builder of bounded trees."""

    def __init__(self) -> None:
        super().__init__()
        self.elements = self.depth = 0

    def start(self, tag: str, attrs: dict[str, str], /) -> Element:
        self.elements += 1
        self.depth += 1
        if self.depth > MOST_DEPTH:
            raise FacadeError(f"This XML has more than {MOST_DEPTH} levels of nested elements.")
        if self.elements > MOST_ELEMENTS:
            raise FacadeError(f"This XML has more than {MOST_ELEMENTS:,} elements.")
        return super().start(tag, attrs)

    def end(self, tag: str, /) -> Element:
        self.depth -= 1
        return super().end(tag)


def parse_xml(content: bytes) -> Node:
    """The outermost element of an XML file; several of them become the children of an element `root`.

    Raises:
        FacadeError: If it is not XML, declares entities or a document type, or is too large or too deep.
    """
    try:
        return _parsed(content)
    except ParseError as error:
        if error.code not in _SEVERAL:
            raise FacadeError(f"This is not valid XML: {error}.") from error
    try:
        return _parsed(b"<root>", _DECLARATION.sub(b"", content), b"</root>")
    except ParseError as error:
        raise FacadeError(f"This is not valid XML: {error}.") from error


def _parsed(*parts: bytes) -> Node:
    parser = DefusedXMLParser(target=_Bounded(), forbid_dtd=True)
    try:
        for part in parts:
            parser.feed(part)
        return parser.close()
    except DefusedXmlException as error:
        raise FacadeError("This XML declares entities or a document type, which are not supported.") from error
    except (ValueError, LookupError) as error:
        raise FacadeError(f"This is not valid XML: {error}.") from error


def local_name(node: Node) -> str:
    """The name of an element without its namespace."""
    return str(node.tag).rpartition("}")[2]


def numbers_of(node: Node, keys: Sequence[str], where: str) -> list[float]:
    """The numbers in the children of an element with these names.

    Raises:
        FacadeError: If one is missing or not a finite number.
    """
    return [coordinate((node.findtext(key) or "").strip(), f"{where}, {key}") for key in keys]
