"""Atomic writing of files and folders: they are complete or absent, even after a crash."""

from __future__ import annotations

import io
import os
import secrets
import shutil
import stat
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from hashlib import sha256
from pathlib import Path
from typing import BinaryIO

from grammarlab.errors import AssetError, UsageError

PART_PREFIX = ".part-"
"""Prefix of the names of unfinished files and folders."""


@contextmanager
def atomic_file(path: Path, *, lasting: bool = True) -> Iterator[Path]:
    """A temporary path to write to; it is renamed to ``path`` after the block, or deleted if the block raises.

    The temporary path is in the same folder and has the same suffix, since writers choose their format by it. It is
    unique among processes and threads.

    Args:
        path: the final path; an existing file is replaced atomically.
        lasting: whether the file survives a power failure after the block. This takes 10 ms or more per file,
            too long for thousands of files that can be made again.
    """
    part = _part_of(path)
    try:
        yield part
        if lasting:
            _sync(part)
        part.replace(path)
        if lasting and hasattr(os, "O_DIRECTORY"):  # other systems cannot open folders
            _sync(path.parent)
    finally:
        part.unlink(missing_ok=True)


@contextmanager
def atomic_folder(path: Path) -> Iterator[Path]:
    """A new folder to fill; it replaces ``path`` after the block, unless the block raises.

    If the process is killed, the earlier folder is complete or absent.
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
    """Write a file atomically; see `atomic_file` for `lasting`."""
    with atomic_file(path, lasting=lasting) as part:
        part.write_bytes(content)


def write_text(path: Path, text: str) -> None:
    """Write UTF-8 text atomically, with Unix line ends on every system."""
    write_bytes(path, text.encode())


def read_bounded(path: Path, most: int) -> bytes:
    """Content of a regular file.

    A pipe or a device is refused without reading it: it may wait, or have no end.

    Args:
        path: the file; links are followed.
        most: largest size in bytes.

    Raises:
        AssetError: If it is not a regular file, or longer.
        OSError: If it cannot be opened or read.
    """
    with open_regular(path) as file:
        size = os.fstat(file.fileno()).st_size
        content = b"" if size > most else file.read(most + 1)
    if max(size, len(content)) > most:
        raise AssetError(f"{path}: expected at most {most:,} bytes.")
    return content


def open_regular(path: Path) -> BinaryIO:
    """A regular file, open for reading bytes.

    Args:
        path: the file; links are followed.

    Raises:
        AssetError: If it is a pipe or a device.
        OSError: If it cannot be opened.
    """
    file = io.BufferedReader(io.FileIO(path, opener=_open_at_once))
    if not stat.S_ISREG(os.fstat(file.fileno()).st_mode):
        file.close()
        raise AssetError(f"{path}: expected a regular file, found a pipe or a device.")
    return file


def check_overwrites(targets: Iterable[Path], inputs: Iterable[Path]) -> None:
    """Refuse to write over a file that is read.

    Args:
        targets: files to be written, that may exist already.
        inputs: files that are read; those that do not exist count as none.

    Raises:
        UsageError: If a target is one of the inputs, also by another name.
    """
    existing = [path for path in inputs if path.exists()]
    for target in targets:
        if target.exists() and any(target.samefile(path) for path in existing):
            raise UsageError(f"{target} is the input file: write to another one.")


def existing(text: str) -> Path | None:
    """The file or folder that a text names; None if there is none, also if the text is too long for a name.

    A person may write a name where other text is possible too, for example an outline of many corners.
    """
    path = Path(text)
    try:
        return path if path.exists() else None
    except OSError:
        return None


def remove_parts(folder: Path) -> None:
    """Remove unfinished files and folders of killed processes directly in a folder."""
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
    """An unused short name beside a path; the name of the path may already have the maximum length."""
    return path.with_name(f"{PART_PREFIX}{secrets.token_hex(8)}{path.suffix}")


def _open_at_once(path: str, flags: int) -> int:
    """Descriptor of a file; a pipe without a writer is opened without waiting for one."""
    return os.open(path, flags | getattr(os, "O_NONBLOCK", 0))


def _sync(path: Path) -> None:
    """Flush a file, or the names in a folder, to the disk."""
    descriptor = os.open(path, os.O_RDONLY if path.is_dir() else os.O_RDWR)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
