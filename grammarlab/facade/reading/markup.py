"""Annotations in XML, perhaps with several outermost elements."""

from __future__ import annotations

import re
from collections.abc import Sequence
from xml.parsers.expat.errors import XML_ERROR_JUNK_AFTER_DOC_ELEMENT, XML_ERROR_NO_ELEMENTS, codes

from grammarlab.errors import FacadeError, XmlError
from grammarlab.facade.reading.source import coordinate
from grammarlab.xml_text import Node, xml_root

_DECLARATION = re.compile(rb"\A\s*(?:\xef\xbb\xbf)?\s*<\?xml[^>]*\?>")

_SEVERAL = (codes[XML_ERROR_JUNK_AFTER_DOC_ELEMENT], codes[XML_ERROR_NO_ELEMENTS])
"""Codes of errors about a file that has not one outermost element, but several, or only text."""


def parse_xml(content: bytes) -> Node:
    """The outermost element of an XML file; several of them become the children of an element `root`.

    Raises:
        FacadeError: If it is not XML, declares entities or a document type, or is too large or too deep.
    """
    try:
        return xml_root(content)
    except XmlError as error:
        if error.code not in _SEVERAL:
            raise FacadeError(error.message) from error
    try:
        return xml_root(b"<root>", _DECLARATION.sub(b"", content), b"</root>")
    except XmlError as error:
        raise FacadeError(error.message) from error


def local_name(node: Node) -> str:
    """The name of an element without its namespace."""
    return str(node.tag).rpartition("}")[2]


def numbers_of(node: Node, keys: Sequence[str], where: str) -> list[float]:
    """The numbers in the children of an element with these names.

    Raises:
        FacadeError: If one is missing or not a finite number.
    """
    return [coordinate((node.findtext(key) or "").strip(), f"{where}, {key}") for key in keys]
