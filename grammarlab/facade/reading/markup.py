"""XML of strangers: without entities or document types, bounded in size and depth."""

from __future__ import annotations

import re
from typing import TypeAlias
from xml.etree.ElementTree import Element, ParseError, TreeBuilder  # defusedxml does the parsing

from defusedxml.common import DefusedXmlException
from defusedxml.ElementTree import DefusedXMLParser

from grammarlab.errors import FacadeError

MOST_ELEMENTS = 5_000_000
MOST_DEPTH = 100
_DECLARATION = re.compile(rb"\A\s*(?:\xef\xbb\xbf)?\s*<\?xml[^>]*\?>")

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


def parse_xml(content: bytes, *, fragments: bool = False) -> Node:
    """The outermost element of an XML file.

    Args:
        content: the file.
        fragments: whether there may be several top-level elements, without one around them; they become the children of
            an element `root`.

    Raises:
        FacadeError: If it is not XML, declares entities or a document type, or is too large or too deep.
    """
    parser = DefusedXMLParser(target=_Bounded(), forbid_dtd=True)
    try:
        if fragments:
            parser.feed(b"<root>")
            content = _DECLARATION.sub(b"", content)
        parser.feed(content)
        if fragments:
            parser.feed(b"</root>")
        return parser.close()
    except (ParseError, ValueError, LookupError) as error:
        if isinstance(error, DefusedXmlException):
            raise FacadeError("This XML declares entities or a document type, which are not supported.") from error
        raise FacadeError(f"This is not valid XML: {error}.") from error


def local_name(node: Node) -> str:
    """The name of an element without its namespace."""
    return str(node.tag).rpartition("}")[2]
