"""XML from strangers: without entities or document types, bounded in size and depth."""

from __future__ import annotations

from typing import TypeAlias
from xml.etree.ElementTree import Element, ParseError, TreeBuilder  # defusedxml does the parsing

from defusedxml.common import DefusedXmlException
from defusedxml.ElementTree import DefusedXMLParser

from grammarlab.errors import XmlError

MOST_ELEMENTS = 5_000_000
MOST_DEPTH = 100

Node: TypeAlias = Element
"""An element of a parsed file."""


class _Bounded(TreeBuilder):
    """A builder of bounded trees."""

    def __init__(self, most_elements: int) -> None:
        super().__init__()
        self.most_elements = most_elements
        self.elements = self.depth = 0

    def start(self, tag: str, attrs: dict[str, str], /) -> Element:
        self.elements += 1
        self.depth += 1
        if self.depth > MOST_DEPTH:
            raise XmlError(f"This XML has more than {MOST_DEPTH} levels of nested elements.")
        if self.elements > self.most_elements:
            raise XmlError(f"This XML has more than {self.most_elements:,} elements.")
        return super().start(tag, attrs)

    def end(self, tag: str, /) -> Element:
        self.depth -= 1
        return super().end(tag)


def xml_root(*parts: bytes | str, most_elements: int = MOST_ELEMENTS) -> Node:
    """The outermost element of an XML text.

    Args:
        parts: the text, in one part or several.
        most_elements: number of elements above which it is refused.

    Raises:
        XmlError: If it is not XML, declares entities or a document type, or is too large or too deep.

    >>> xml_root("<tree><param name='Levels' value='3'/></tree>")[0].get("value")
    '3'
    """
    parser = DefusedXMLParser(target=_Bounded(most_elements), forbid_dtd=True)
    try:
        for part in parts:
            parser.feed(part)
        return parser.close()
    except DefusedXmlException as error:
        raise XmlError("This XML declares entities or a document type, which are not supported.") from error
    except ParseError as error:
        line, column = error.position
        raise XmlError(f"This is not valid XML: {error}.", line, column + 1, error.code) from error
    except (ValueError, LookupError) as error:
        raise XmlError(f"This is not valid XML: {error}.") from error
