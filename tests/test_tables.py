"""Tables of text are read alike, whoever wrote them."""

import csv
import io

import pytest
from hypothesis import given
from hypothesis import strategies as st

from grammarlab.errors import TableError
from grammarlab.tables import decoded, read_table

CELL = st.text(st.characters(codec="utf-8", exclude_characters="\0\r"), max_size=8)


def written(rows, separator):
    text = io.StringIO(newline="")
    csv.writer(text, delimiter=separator, lineterminator="\n").writerows(rows)
    return text.getvalue()


@given(st.lists(st.lists(CELL, min_size=3, max_size=3), max_size=6), st.sampled_from(",;\t"))
def test_what_is_written_is_read_without_blank_rows(body, separator):
    rows = [["first", "second", "third"], *body]
    table = read_table(written(rows, separator).encode(), 10)
    kept = [tuple(cell.strip() for cell in row) for row in rows]
    assert table.separator == separator
    assert [row.cells for row in table.rows] == [row for row in kept if any(row)]


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "cp1252"])
def test_the_encoding_does_not_matter(encoding):
    text = "Étage;Größe\r\nErdgeschoß;3,5\r\n"
    table = read_table(text.encode(encoding), 10)
    assert table.header == ("étage", "größe")
    assert table.body[0].cells == ("Erdgeschoß", "3,5")
    assert decoded(text.encode(encoding)) == text


@pytest.mark.parametrize("line", ["sep=;", "SEP=;", "sep=;\r"])
def test_a_line_that_names_the_separator_is_no_row_but_counts_as_a_line(line):
    table = read_table(f"{line}\na;b\n1,5;2,5\n".encode(), 10)
    assert (table.header, table.body[0].line) == (("a", "b"), 3)
    assert [table.number(cell) for cell in table.body[0].cells] == [1.5, 2.5]


def test_a_tab_may_be_named_as_separator():
    assert read_table(b"sep=\t\na\tb\n", 10).header == ("a", "b")


def test_lines_are_those_of_the_file():
    table = read_table(b'a,b\n\n,\n1,"2\n3"\n4,5\n', 10)
    assert [(row.line, row.cells) for row in table.body] == [(5, ("1", "2\n3")), (6, ("4", "5"))]


@pytest.mark.parametrize(
    ("separator", "cell", "value"),
    [
        (";", "1.5", 1.5),
        (";", "-1,5e2", -150.0),
        (",", "1.5", 1.5),
        (",", "1,5", None),
        (";", "1.000,5", None),
        (",", "1_000", None),
        (",", "", None),
        (",", "inf", None),
        (",", "1e999", None),
        (",", "9" * 5000, None),
    ],
)
def test_numbers_have_a_decimal_comma_only_where_it_cannot_separate(separator, cell, value):
    assert read_table(f"a{separator}b".encode(), 10).number(cell) == value


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b'a,b\n"1,2\n', "line 2: this is not valid CSV"),
        (b"a\0b,c\n", "bytes of zero"),
        (b"\xff\xfea", "expected text"),
        (b"\x81\x8d\x8f", "UTF-8, UTF-16 or Windows-1252"),
        (b"a\n" * 11, "at most 10 rows"),
    ],
)
def test_what_is_not_a_table_is_refused(content, message):
    with pytest.raises(TableError, match=message):
        read_table(content, 10)


@given(st.binary(max_size=60))
def test_any_bytes_are_a_table_or_refused(content):
    try:
        table = read_table(content, 20)
    except TableError:
        return
    assert all(any(row.cells) for row in table.rows)


@pytest.mark.parametrize(
    ("line", "cells"),
    [("0,5;1,25;2", ("0,5", "1,25", "2")), ("0.5,1,2", ("0.5", "1", "2")), ("0,5\t1,25", ("0,5", "1,25"))],
)
def test_commas_in_a_table_of_numbers_may_be_decimal_points(line, cells):
    assert read_table(line.encode(), 9).rows[0].cells == cells
