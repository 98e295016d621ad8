"""XML from strangers."""

import pytest

from grammarlab.errors import XmlError
from grammarlab.xml_text import MOST_DEPTH, xml_root


def test_parts_are_one_text():
    root = xml_root(b"<a>", "<b c='ü'/>", b"</a>")
    assert [(node.tag, node.get("c")) for node in root] == [("b", "ü")]


@pytest.mark.parametrize(
    ("text", "place"),
    [("<a>\n <b></a>", (2, 7)), ("", (1, 1)), ("<a/><b/>", (1, 5)), ("<a>&b;</a>", (1, 4))],
)
def test_an_error_has_line_and_column(text: str, place: tuple[int, int]):
    with pytest.raises(XmlError, match="not valid XML") as error:
        xml_root(text)
    assert (error.value.line, error.value.column) == place


@pytest.mark.parametrize("text", ["<!DOCTYPE a><a/>", '<!DOCTYPE a [<!ENTITY b "ha">]><a>&b;</a>'])
def test_document_types_and_entities_are_refused(text: str):
    with pytest.raises(XmlError, match="declares entities or a document type"):
        xml_root(text)


def test_depth_and_number_of_elements_are_bounded():
    assert xml_root("<a>" * MOST_DEPTH + "</a>" * MOST_DEPTH).tag == "a"
    with pytest.raises(XmlError, match="levels of nested elements"):
        xml_root("<a>" * (MOST_DEPTH + 1))
    assert len(xml_root("<a>" + "<b/>" * 9 + "</a>", most_elements=10)) == 9
    with pytest.raises(XmlError, match="more than 9 elements"):
        xml_root("<a>" + "<b/>" * 9 + "</a>", most_elements=9)
