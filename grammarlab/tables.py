"""Tables as text: CSV from strangers, as spreadsheets, exporters and people write it; Markdown for reports.

Encodings: UTF-8 with or without a byte order mark, UTF-16 with one, otherwise Windows-1252. Fields are separated by
commas, semicolons or tabs; a first line `sep=;` selects the separator. Rows without any text are skipped.
"""

from __future__ import annotations

import codecs
import csv
import io
import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import islice

from grammarlab.errors import TableError

_SEPARATORS = ",;\t"
_UTF_16 = (codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)
_MAX_DIGITS = 400
"""Longest text that is read as a number; a float has at most 17 significant digits and an exponent of three."""


@dataclass(frozen=True, slots=True)
class TableRow:
    """One row with text."""

    line: int
    """Last line of the row in the file, from 1."""
    cells: tuple[str, ...]
    """Cells of the row, without blanks around them."""


@dataclass(frozen=True, slots=True)
class Table:
    """The rows of a file, its header included."""

    separator: str
    """Separator of fields."""
    rows: tuple[TableRow, ...]
    """Rows with text, in order."""

    @property
    def header(self) -> tuple[str, ...]:
        """Cells of the first row in lower case; empty for a table without rows."""
        return tuple(cell.lower() for cell in self.rows[0].cells) if self.rows else ()

    @property
    def body(self) -> tuple[TableRow, ...]:
        """The rows after the header."""
        return self.rows[1:]

    def number(self, cell: str) -> float | None:
        r"""A cell as a finite number; None if it is not one.

        A comma is a decimal point unless it separates the fields.

        >>> table = read_table(b"label;x\nwindow;1,5", 10)
        >>> table.number("1,5"), table.number("1.5"), table.number("wide"), table.number("nan")
        (1.5, 1.5, None, None)
        """
        text = cell if self.separator == "," else cell.replace(",", ".")
        if len(text) > _MAX_DIGITS or "_" in text:  # Python reads 1_000 as a number; no spreadsheet writes it
            return None
        try:
            value = float(text)
        except ValueError:
            return None
        return value if math.isfinite(value) else None


def read_table(content: bytes, max_rows: int) -> Table:
    r"""The table of a file.

    Args:
        content: the file.
        max_rows: largest number of rows with text, the header included.

    Raises:
        TableError: If it is not text, has unbalanced quotes, or has more rows; the message names the line.

    >>> read_table("Étage;Höhe\n1;3,2\n;\n".encode("cp1252"), 10)
    Table(separator=';', rows=(TableRow(line=1, cells=('Étage', 'Höhe')), TableRow(line=2, cells=('1', '3,2'))))
    """
    text = decoded(content)
    first, _, rest = text.lstrip().partition("\n")
    skipped = 0
    if first.rstrip().lower() in {f"sep={separator}" for separator in _SEPARATORS} or first.lower().rstrip() == "sep=":
        separator = first.rstrip("\r\n")[4:5] or "\t"  # a tab at the end may be lost as a blank
        skipped = text[: len(text) - len(rest)].count("\n")
        text = rest
    else:
        separator = _separator_of(first)
    reader = csv.reader(io.StringIO(text, newline=""), delimiter=separator, strict=True)
    try:
        filled_rows = (
            TableRow(reader.line_num + skipped, tuple(cell.strip() for cell in cells))
            for cells in reader
            if any(cell.strip() for cell in cells)
        )
        rows = tuple(islice(filled_rows, max_rows + 1))
    except csv.Error as error:
        raise TableError(
            f"line {reader.line_num + skipped}: this is not valid CSV: {error}. Fields are separated by commas, "
            "semicolons or tabs."
        ) from error
    if len(rows) > max_rows:
        raise TableError(f"expected at most {max_rows:,} rows.")
    return Table(separator, rows)


def _separator_of(line: str) -> str:
    """Separator of the fields of the first line; in one of numbers only, commas may be decimal points."""
    if not any(character.isalpha() for character in line):
        return next((separator for separator in ";\t" if separator in line), ",")
    return max(_SEPARATORS, key=line.count)


def decoded(content: bytes) -> str:
    """The text of a file in UTF-8, in UTF-16 with a byte order mark, or in Windows-1252.

    Raises:
        TableError: If it is not text.
    """
    encodings = ("utf-16",) if content[:2] in _UTF_16 else ("utf-8-sig", "cp1252")
    for encoding in encodings:
        try:
            text = content.decode(encoding)
            break
        except UnicodeDecodeError:
            continue
    else:
        raise TableError("expected text in UTF-8, UTF-16 or Windows-1252.")
    if "\0" in text:
        raise TableError("expected text, found bytes of zero.")
    return text


def markdown_table(header: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    r"""A table in Markdown.

    >>> markdown_table(("a", "b"), [("1", "x|y")])
    '| a | b |\n| --- | --- |\n| 1 | x\\|y |\n'
    """
    lines = [header, ("---",) * len(header), *rows]
    return "".join("| " + " | ".join(cell.replace("|", "\\|") for cell in line) + " |\n" for line in lines)
