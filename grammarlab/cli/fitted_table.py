"""Tables for a terminal of any width, in which names, headings and numbers are whole."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from shutil import get_terminal_size
from typing import TYPE_CHECKING

from grammarlab.cli.console import print_result
from grammarlab.printable import printable

if TYPE_CHECKING:
    from rich.console import Console
    from rich.table import Table

_WIDEST = 30
"""Letters of a word that are in one line; only names may have more."""
_GAP = 2
"""Blanks between two columns."""
_INDENT = 4 * " "
"""Before what follows a name that stands alone in its line."""


def print_table(title: str, columns: Mapping[str, Sequence[str | int]], names: Collection[str]) -> None:
    """Print a table as wide as the terminal, or as a list where its names do not fit beside one another.

    Args:
        title: its title.
        columns: cells by heading, the first of which identify rows.
        names: headings of the columns whose words are not broken.
    """
    from rich.text import Text

    console = _console()
    texts = {heading: [printable(str(cell)) for cell in cells] for heading, cells in columns.items()}
    numeric = [all(isinstance(cell, int) for cell in cells) for cells in columns.values()]
    widths = _widths(texts, numeric, names, console.width - _GAP * (len(columns) - 1))
    if widths:
        console.print(_table(title, texts, numeric, widths))
        return
    console.print(Text(title, "italic"))
    for line in _lines(texts, console.width):
        # What is wider than the terminal is a name, which the terminal itself continues in its next line.
        console.print(Text(line), soft_wrap=True)


def print_text(text: str) -> None:
    """Print text in lines as wide as the terminal, whose words are whole."""
    for line in wrapped(printable(text), _console().width):
        print_result(line)


def wrapped(text: str, width: int, indent: str = "") -> list[str]:
    """Lines of whole words; only a word alone in its line may have more cells than the width.

    Lines may also end before and after wide letters, since Japanese and Chinese have no blanks.
    """
    from rich.cells import cell_len

    lines: list[str] = []
    line = indent
    for word in text.split():
        blank = " "
        for part in _parts(word):
            if line != indent and cell_len(line + blank + part) > width:
                lines.append(line)
                line = indent
            line += part if line == indent else blank + part
            blank = ""
    return [*lines, line] if line != indent else lines


def _console() -> Console:
    from rich.console import Console

    console = Console()
    # COLUMNS=0 says nothing about the terminal.
    console.width = console.width or get_terminal_size().columns
    return console


def _table(title: str, texts: Mapping[str, Sequence[str]], numeric: Sequence[bool], widths: Sequence[int]) -> Table:
    from rich.box import SIMPLE_HEAD
    from rich.table import Table
    from rich.text import Text

    # No lines between columns, which leave names more room.
    table = Table(
        title=title, title_justify="left", box=SIMPLE_HEAD, show_edge=False, pad_edge=False, collapse_padding=True
    )
    for heading, is_number, column_width in zip(texts, numeric, widths, strict=True):
        table.add_column(heading, justify="right" if is_number else "left", overflow="fold", width=column_width)
    for cells in zip(*texts.values(), strict=True):
        table.add_row(*map(Text, cells))
    return table


def _lines(texts: Mapping[str, Sequence[str]], width: int) -> list[str]:
    """Lines of a list: the first cell of each row, and below it the others with their headings."""
    lines = [""]
    for first, *others in zip(*texts.values(), strict=True):
        facts = (f"{heading}: {cell}" for heading, cell in zip(list(texts)[1:], others, strict=True) if cell)
        lines += [first, *wrapped("; ".join(facts), width, indent=_INDENT)]
    return lines


def _parts(word: str) -> Iterator[str]:
    """Parts of a word between which a line may end."""
    from rich.cells import cell_len

    part = ""
    for letter in word:
        # Marks, which have no width, stay with the letter that they change.
        if part and cell_len(letter) and (cell_len(letter) > 1 or cell_len(part[0]) > 1):
            yield part
            part = ""
        part += letter
    yield part


def _widths(
    texts: Mapping[str, Sequence[str]], numeric: Sequence[bool], names: Collection[str], room: int
) -> list[int]:
    """Widths of columns in some room: whole cells if they fit, else whole words, headings and numbers; else none."""
    from rich.cells import cell_len

    whole = [max(map(cell_len, (heading, *cells))) for heading, cells in texts.items()]
    longest = [max((cell_len(word) for cell in cells for word in cell.split()), default=0) for cells in texts.values()]
    words = [
        most if number else max(cell_len(heading), word if heading in names else min(word, _WIDEST))
        for heading, number, most, word in zip(texts, numeric, whole, longest, strict=True)
    ]
    # Long cells take the room that words leave.
    return _levelled(words, whole, room)


def _levelled(least: Sequence[int], most: Sequence[int], room: int) -> list[int]:
    """The widest columns in proportion to their largest widths, within their limits; none in too little room."""
    largest = max(most)
    for level in range(room, -1, -1):
        widths = [max(level * high // largest, low) for low, high in zip(least, most, strict=True)]
        widths = [min(width, high) for width, high in zip(widths, most, strict=True)]
        if sum(widths) <= room:
            return widths
    return []
