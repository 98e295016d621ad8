"""Files and folders that are either whole or not there, whatever happens in between."""

from __future__ import annotations

import os
import secrets
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from hashlib import sha256
from pathlib import Path

PART_PREFIX = ".part-"
"""What the name of an unfinished file or folder begins with."""


@contextmanager
def atomic_file(path: Path, *, lasting: bool = True) -> Iterator[Path]:
    """A path to write to; it becomes ``path`` when the block ends well and vanishes when it does not.

    The path lies in the same folder and has the same suffix, since writers choose their format by it. No other process
    or thread has the same one.

    Args:
        path: where the file is to be; one of that name is replaced at once.
        lasting: whether the file survives a power failure once the block has ended. That takes 10 ms or more a file,
            too much for thousands that can be made again.
    """
    part = _part_of(path)
    try:
        yield part
        if lasting:
            _sync(part)
        part.replace(path)
        if lasting and hasattr(os, "O_DIRECTORY"):  # elsewhere folders cannot be opened
            _sync(path.parent)
    finally:
        part.unlink(missing_ok=True)


@contextmanager
def atomic_folder(path: Path) -> Iterator[Path]:
    """A new folder to fill; it becomes ``path``, replacing what stood there, when the block ends well.

    A process that is killed leaves the earlier folder whole, or none.
    """
    part, earlier = _part_of(path), _part_of(path)
    part.mkdir(parents=True)
    try:
        yield part
        if path.exists():
            path.replace(earlier)
        part.replace(path)
    finally:
        shutil.rmtree(part, ignore_errors=True)
        shutil.rmtree(earlier, ignore_errors=True)


def write_bytes(path: Path, content: bytes, *, lasting: bool = True) -> None:
    """Write a file whole or not at all; `lasting` as for `atomic_file`."""
    with atomic_file(path, lasting=lasting) as part:
        part.write_bytes(content)


def write_text(path: Path, text: str) -> None:
    """Write UTF-8 text whole or not at all, with Unix line ends on every system."""
    write_bytes(path, text.encode())


def remove_parts(folder: Path) -> None:
    """Remove the unfinished files and folders that killed processes left directly in a folder."""
    for part in folder.glob(f"{PART_PREFIX}*"):
        if part.is_dir() and not part.is_symlink():
            shutil.rmtree(part, ignore_errors=True)
        else:
            part.unlink(missing_ok=True)


def file_hash(path: Path) -> str:
    """SHA-256 of a file's bytes in hexadecimal."""
    digest = sha256()
    with path.open("rb") as file:
        while block := file.read(1 << 20):
            digest.update(block)
    return digest.hexdigest()


def _part_of(path: Path) -> Path:
    """An unused name beside a path; short, since that of the path may be as long as a name can be."""
    return path.with_name(f"{PART_PREFIX}{secrets.token_hex(8)}{path.suffix}")


def _sync(path: Path) -> None:
    """Wait until a file, or the names in a folder, are on the disk."""
    descriptor = os.open(path, os.O_RDONLY if path.is_dir() else os.O_RDWR)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
