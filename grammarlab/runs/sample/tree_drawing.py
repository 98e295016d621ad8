"""Derivation trees as drawings (SVG) and as pages whose branches open and close (HTML)."""

from __future__ import annotations

import html
from collections.abc import Callable, Sequence
from pathlib import Path

from grammarlab.errors import UsageError
from grammarlab.files import write_text
from grammarlab.printable import printable
from grammarlab.runs.sample.trace import DerivationTrace, TreeRow, tree_rows

_MOST_ROWS = 20_000
"""Largest number of rows, which browsers still show at once."""
_STEP, _HEIGHT, _MARGIN = 18, 20, 14
"""Pixels of one level, of one row, and around the tree."""
_LETTER = 7.0
"""Pixels of a letter at most, on average."""
_MOST_LETTERS = 160
"""Letters of the details of a row in a drawing."""
_COLORS = (
    "svg { background: #ffffff; } text { font: 12px system-ui, sans-serif; fill: #1d2125; } "
    ".s { font-weight: 600; } .d { fill: #59626b; } path { fill: none; stroke: #b5bcc4; } "
    "@media (prefers-color-scheme: dark) { svg { background: #17191c; } text { fill: #e8eaed; } "
    ".d { fill: #b0b8c0; } path { stroke: #4a525a; } }"
)
_PAGE = """<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta name="color-scheme" content="light dark">
<title>{title}</title>
<style>
body {{ font: 14px/1.5 system-ui, sans-serif; margin: 1em auto; padding: 0 1em; max-width: 75em; }}
ul {{ list-style: none; margin: 0; padding-left: 1.3em; border-left: 1px solid #8886; }}
summary {{ cursor: pointer; }}
li {{ padding: 1px 0; overflow-wrap: anywhere; }}
small {{ opacity: .8; margin-left: .6em; }}
</style>
</head>
<body>
<h1>{title}</h1>
<ul>
{rows}</ul>
</body>
</html>
"""


def save_tree(trace: DerivationTrace, path: Path, *, everything: bool = False) -> None:
    """Write the tree of a model.

    Args:
        trace: the model.
        path: ends in ``.svg`` or ``.html``.
        everything: whether equal shapes of one successor are listed one by one.

    Raises:
        UsageError: If the file has another suffix, or the tree more than `_MOST_ROWS` rows.
    """
    if path.suffix.lower() not in _WRITERS:
        raise UsageError(f"{path}: a derivation tree is written as {' or '.join(_WRITERS)}")
    rows = []
    for row in tree_rows(trace, everything):
        rows.append(row)
        if len(rows) > _MOST_ROWS:
            advice = "leave out --all, which lists equal shapes one by one" if everything else "choose a smaller model"
            raise UsageError(f"the derivation tree has more than {_MOST_ROWS:,} rows: {advice}.")
    title = f"{trace.name}, {trace.forest.lots}"
    write_text(path, _WRITERS[path.suffix.lower()](title, rows))


def _svg(title: str, rows: Sequence[TreeRow]) -> str:
    """A row for each shape below its parent, with a line from it."""
    parts: list[str] = []
    last: dict[int, int] = {}
    width = len(title) * _LETTER
    for number, row in enumerate(rows):
        x, y = _MARGIN + row.depth * _STEP, _MARGIN + (number + 2) * _HEIGHT
        if row.depth:
            top = _MARGIN + (last[row.depth - 1] + 2) * _HEIGHT + 4
            parts.append(f'<path d="M{x - _STEP + 5} {top}V{y - 4}H{x - 3}"/>')
        last[row.depth] = number
        name, details = _clean(row.symbol + row.note), _clean(_details(row))[:_MOST_LETTERS]
        width = max(width, x + (len(name) + len(details) + 2) * _LETTER)
        shown = f'<tspan class="s">{name}</tspan><tspan class="d" dx="8">{details}</tspan>'
        parts.append(f'<text x="{x}" y="{y}">{shown}</text>')
    height = (len(rows) + 2) * _HEIGHT + _MARGIN
    size = f'width="{width + _MARGIN:.0f}" height="{height}" viewBox="0 0 {width + _MARGIN:.0f} {height}"'
    heading = f'<title>{_clean(title)}</title><style>{_COLORS}</style><text class="s" x="{_MARGIN}" y="{_MARGIN + 8}">'
    lines = [f'<svg xmlns="http://www.w3.org/2000/svg" {size}>', f"{heading}{_clean(title)}</text>", *parts, "</svg>"]
    return "\n".join(lines) + "\n"


def _page(title: str, rows: Sequence[TreeRow]) -> str:
    """Nested lists, of which the first levels are open."""
    parts: list[str] = []
    for row, following in zip(rows, [*rows[1:], None], strict=True):
        depth = 0 if following is None else following.depth
        text = f"<b>{_clean(row.symbol)}</b>{_clean(row.note)}<small>{_clean(_details(row))}</small>"
        if depth > row.depth:
            opened = " open" if row.depth < 3 else ""
            parts.append(f"<li><details{opened}><summary>{text}</summary><ul>\n")
        else:
            parts.append(f"<li>{text}</li>\n" + "</ul></details></li>\n" * (row.depth - depth))
    return _PAGE.format(title=_clean(title), rows="".join(parts))


def _details(row: TreeRow) -> str:
    place = row.rule_at or row.made_at
    return " · ".join([*([f"line {place.line}"] if place else []), *row.details])


def _clean(text: str) -> str:
    return html.escape(printable(text))


_WRITERS: dict[str, Callable[[str, Sequence[TreeRow]], str]] = {".svg": _svg, ".html": _page}
