"""Files and folders that are either whole or not there, whatever happens in between."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from hashlib import sha256
from pathlib import Path

PART_PREFIX = ".part-"
"""What the name of an unfinished file or folder begins with."""


@contextmanager
def atomic_file(path: Path) -> Iterator[Path]:
    """A path to write to; it becomes ``path`` when the block ends well and vanishes when it does not.

    The path lies in the same folder and has the same suffix, since writers choose their format by it.
    """
    part = path.with_name(f"{PART_PREFIX}{os.getpid()}-{path.name}")
    try:
        yield part
        part.replace(path)
    finally:
        part.unlink(missing_ok=True)


@contextmanager
def atomic_folder(path: Path) -> Iterator[Path]:
    """A new folder to fill; it becomes ``path``, replacing what stood there, when the block ends well."""
    part = path.with_name(f"{PART_PREFIX}{os.getpid()}-{path.name}")
    shutil.rmtree(part, ignore_errors=True)
    part.mkdir(parents=True)
    try:
        yield part
        if path.exists():
            shutil.rmtree(path)
        part.replace(path)
    finally:
        shutil.rmtree(part, ignore_errors=True)


def write_text(path: Path, text: str) -> None:
    """Write UTF-8 text whole or not at all, with Unix line ends on every system."""
    with atomic_file(path) as part:
        part.write_text(text, encoding="utf-8", newline="\n")


def file_hash(path: Path) -> str:
    """SHA-256 of a file's bytes in hexadecimal."""
    digest = sha256()
    with path.open("rb") as file:
        while block := file.read(1 << 20):
            digest.update(block)
    return digest.hexdigest()
