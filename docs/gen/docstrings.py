"""Docstrings in Google style as Markdown."""

from __future__ import annotations

import re
import textwrap

_SECTION = re.compile(r"^(Args|Returns|Yields|Raises):\n((?:(?: +.*)?\n)*)", re.MULTILINE)
_ENTRY = re.compile(r"^(\*{0,2}\w+): *", re.MULTILINE)
_EXAMPLE = re.compile(r"^( *)>>> .*(?:\n\1\S.*)*", re.MULTILINE)
_TITLES = {"Args": "Arguments", "Returns": "Returns", "Yields": "Yields", "Raises": "Raises"}


def markdown(docstring: str) -> str:
    """A docstring as Markdown: sections with a title, arguments and errors as lists, examples as code.

    Args:
        docstring: without indentation, as `inspect.cleandoc` returns it.
    """
    text = _SECTION.sub(lambda match: f"{_section(match[1], match[2])}\n\n", f"{docstring}\n")
    return re.sub(r"\n{3,}", "\n\n", fenced(text)).strip()


def summary(docstring: str) -> str:
    """The first paragraph on one line, for a cell of a table."""
    return cell(docstring.split("\n\n", maxsplit=1)[0])


def cell(text: str) -> str:
    """Text on one line, for a cell of a table."""
    return " ".join(text.split()).replace("|", "\\|")


def fenced(text: str) -> str:
    """The text with fences around its examples, which Markdown would read as quotations."""
    return _EXAMPLE.sub(lambda match: f"\n{match[1]}```pycon\n{match[0]}\n{match[1]}```\n", text)


def _section(name: str, body: str) -> str:
    text = textwrap.dedent(body).strip()
    if name in {"Args", "Raises"}:
        entries = _ENTRY.split(text)[1:]
        pairs = zip(entries[::2], entries[1::2], strict=True)
        text = "\n".join(f"- `{entry}`: {' '.join(words.split())}" for entry, words in pairs)
    return f"**{_TITLES[name]}**\n\n{text}"
