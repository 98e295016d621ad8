"""Files of one JSON object a line that survive a kill between any two bytes."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any, TypeVar

from grammarlab.errors import GrammarlabError

MAX_BYTES = 1 << 28

_T = TypeVar("_T")


def append(path: Path, values: Mapping[str, Any]) -> None:
    """Add a line; after this returns it survives a crash of the machine."""
    line = json.dumps(values, allow_nan=False) + "\n"
    with path.open("ab") as file:
        file.write(line.encode())
        file.flush()
        os.fsync(file.fileno())


def read(path: Path, parse: Callable[[Any], _T], what: str) -> Iterator[_T]:
    """What the lines of a file hold; nothing where there is no file.

    What a writer that was killed left of a last line is cut off.

    Args:
        path: the file.
        parse: makes a value of the object of a line; whatever it trips over is told as an error of the file.
        what: what a line is, for the error.

    Raises:
        GrammarlabError: a line is not what it should be, or the file is larger than `MAX_BYTES`.
    """
    if not path.is_file():
        return
    if path.stat().st_size > MAX_BYTES:
        raise GrammarlabError(f"{path} is larger than {MAX_BYTES:,} bytes. Start again with --fresh.")
    content = path.read_bytes()
    whole = content.rfind(b"\n") + 1
    if whole < len(content):
        with path.open("r+b") as file:
            file.truncate(whole)
    for number, line in enumerate(content[:whole].splitlines(), 1):
        try:
            value = parse(json.loads(line))
        except (ValueError, KeyError, TypeError, OverflowError, RecursionError) as error:
            raise GrammarlabError(
                f"{path}:{number}: expected {what} as grammarlab writes it, found {line[:60]!r}. "
                "Start again with --fresh, or write into another folder."
            ) from error
        yield value
