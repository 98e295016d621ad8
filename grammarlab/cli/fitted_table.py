"""Tables for a terminal of any width, in which names, headings and numbers are whole."""

from __future__ import annotations

import textwrap
from collections.abc import Collection, Mapping, Sequence
from typing import TYPE_CHECKING

from grammarlab.cli.console import print_result
from grammarlab.printable import printable

if TYPE_CHECKING:
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
    from rich.console import Console

    console = Console()
    texts = {heading: [printable(str(cell)) for cell in cells] for heading, cells in columns.items()}
    numeric = [all(isinstance(cell, int) for cell in cells) for cells in columns.values()]
    widths = _widths(texts, numeric, names, console.width - _GAP * (len(columns) - 1))
    if widths:
        console.print(_table(title, texts, numeric, widths))
        return
    console.print(title, style="italic", markup=False)
    for line in _lines(texts, console.width):
        # What is wider than the terminal is a name, which the terminal itself continues in its next line.
        console.print(line, soft_wrap=True, markup=False, highlight=False)


def print_text(text: str) -> None:
    """Print text in lines as wide as the terminal, whose words are whole."""
    from rich.console import Console

    for line in _wrapped(printable(text), Console().width):
        print_result(line)


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
        lines += [first, *_wrapped("; ".join(facts), width, indent=_INDENT)]
    return lines


def _wrapped(text: str, width: int, indent: str = "") -> list[str]:
    """Lines of whole words."""
    return textwrap.wrap(
        text,
        width,
        initial_indent=indent,
        subsequent_indent=indent,
        break_long_words=False,
        break_on_hyphens=False,
    )


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
