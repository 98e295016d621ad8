"""Text from strangers as a terminal may show it: no character of it moves the cursor or changes a direction."""

from __future__ import annotations

import re

_UNSAFE = re.compile(
    "[\x00-\x08\x0b-\x1f\x7f-\x9f"  # control characters, except for tabs and line ends
    "\u061c\u200e\u200f\u202a-\u202e\u2066-\u2069"  # directions of writing
    "\u2028\u2029\ufeff"  # other line ends and byte order marks
    "\ud800-\udfff]"  # bytes of file names that are not text
)


def printable(text: str) -> str:
    r"""The text with escapes such as ``\x1b`` for control characters, directions of writing and lone surrogates.

    Tabs and line ends stay.

    >>> printable("a red \x1b[31m word\nand a \u202eturned one")
    'a red \\x1b[31m word\nand a \\u202eturned one'
    """
    return _UNSAFE.sub(_escape, text)


def _escape(match: re.Match[str]) -> str:
    code = ord(match[0])
    return f"\\x{code:02x}" if code < 0x100 else f"\\u{code:04x}"
