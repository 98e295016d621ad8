"""Atomic writing of files and folders: they are complete or absent, even after a crash."""

from __future__ import annotations

import errno
import io
import os
import re
import secrets
import shutil
import stat
import sys
from collections.abc import Collection, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager, suppress
from hashlib import sha256
from pathlib import Path, PurePosixPath
from typing import BinaryIO

from grammarlab.errors import AssetError, UsageError
from grammarlab.locks import try_lock

PART_PREFIX = ".part-"
"""Prefix of the names of unfinished files and folders."""
FULL_DISK = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO)
"""Errors of a disk that does not take more, whatever the user asked for."""
_PART = re.compile(re.escape(PART_PREFIX) + r"[0-9a-f]{16}(\..*)?", re.DOTALL)
_SYNC_THREADS = 16
"""Files flushed at a time: the file system writes its journal once for all that wait."""


@contextmanager
def atomic_file(path: Path, *, lasting: bool = True) -> Iterator[Path]:
    """A temporary path to write to; it is renamed to ``path`` after the block, or deleted if the block raises.

    The temporary path is in the same folder and has the same suffix, since writers choose their format by it. It is
    unique among processes and threads. An empty file is there already, which `remove_parts` leaves alone until the
    process ends.

    Args:
        path: the final path; an existing file is replaced atomically. A link is replaced, not followed.
        lasting: whether the file survives a power failure after the block. This takes 10 ms or more per file,
            too long for thousands of files that can be made again; `sync_files` is faster for many.

    Raises:
        OSError: If it cannot be written; the error names `path`.
    """
    part = _part_of(path)
    with _errors_about(path, part), _claimed(os.open(part, os.O_RDWR | os.O_CREAT | os.O_EXCL, 0o666)):
        try:
            yield part
            if lasting:
                _sync(part)
            part.replace(path)
        finally:
            part.unlink(missing_ok=True)
    if lasting:
        _sync_folder(path.parent)


@contextmanager
def atomic_folder(path: Path, names: Collection[str]) -> Iterator[Path]:
    """A new folder to fill with files, which are in ``path`` after the block, unless the block raises.

    In an existing folder, the files of these names are replaced, and all others stay. If the process is killed, the
    folder is complete, or lacks the first of the names.

    Args:
        path: the final path.
        names: names of all files.

    Raises:
        OSError: If it cannot be written; the error names `path` or a file in it.
    """
    part = _part_of(path)
    with _errors_about(path, part):
        part.mkdir(parents=True)
        with _claimed(os.open(part, os.O_RDONLY) if sys.platform != "win32" else None):
            try:
                yield part
                if path.is_dir():
                    _replace_files(part, path, names)
                else:
                    part.replace(path)
            finally:
                shutil.rmtree(part, ignore_errors=True)


@contextmanager
def whole_tree(path: Path) -> Iterator[Path]:
    """A path for a new folder with folders in it, which is renamed to ``path`` after the block.

    Args:
        path: the final path, where nothing exists.

    Raises:
        OSError: If it cannot be written; the error names `path` or a file in it.
    """
    part = _part_of(path)
    with _errors_about(path, part):
        try:
            yield part
            part.replace(path)
        finally:
            shutil.rmtree(part, ignore_errors=True)


def write_bytes(path: Path, content: bytes, *, lasting: bool = True) -> None:
    """Write a file atomically; see `atomic_file` for `lasting`."""
    with atomic_file(path, lasting=lasting) as part:
        part.write_bytes(content)


def write_text(path: Path, text: str) -> None:
    r"""Write UTF-8 text atomically, with Unix line ends on every system.

    Bytes of file names that are not UTF-8, lone surrogates in Python, are written as ``\udcff``, as in JSON.
    """
    write_bytes(path, text.encode(errors="backslashreplace"))


def rewrite_text(path: Path, text: str) -> None:
    """Replace the text of a file that was opened for editing, as an editor does.

    A link stays a link: the file that it leads to is written. The file keeps its permissions and its owner.

    Args:
        path: an existing file, or a new one.
        text: written as UTF-8, atomically.
    """
    target = path.resolve()
    with atomic_file(target) as part:
        part.write_bytes(text.encode())
        with suppress(FileNotFoundError):
            shutil.copymode(target, part)
            if sys.platform != "win32":
                owner = target.stat()
                with suppress(PermissionError):  # only an administrator may give files away
                    os.chown(part, owner.st_uid, owner.st_gid)


def sync_files(files: Iterable[Path], folder: Path) -> None:
    """Make files and their names survive a power failure; faster than `lasting` for each of many files.

    Args:
        files: files below the folder.
        folder: the folder.
    """
    paths = tuple(files)
    folders = {above for path in paths for above in path.parents if above.is_relative_to(folder)}
    with ThreadPoolExecutor(_SYNC_THREADS) as threads:
        list(threads.map(_sync, paths))
        list(threads.map(_sync_folder, folders))


@contextmanager
def open_regular(path: Path, most: int | None = None) -> Iterator[BinaryIO]:
    """A regular file, open for reading.

    A pipe or a device is refused without reading it: it may wait, or have no end.

    Args:
        path: the file; links are followed.
        most: largest size in bytes; None if only a part of the file is read.

    Raises:
        AssetError: If it is not a regular file, or longer.
        OSError: If it cannot be opened.
    """
    with io.BufferedReader(io.FileIO(path, opener=_open_at_once)) as file:
        status = os.fstat(file.fileno())
        if not stat.S_ISREG(status.st_mode):
            raise AssetError(f"{path}: expected a regular file, found a pipe or a device.")
        if most is not None and status.st_size > most:
            raise AssetError(f"{path}: expected at most {most:,} bytes.")
        yield file


def read_bounded(path: Path, most: int) -> bytes:
    """Content of a regular file; see `open_regular`.

    Raises:
        AssetError: If it is not a regular file, or longer than `most` bytes.
        OSError: If it cannot be opened or read.
    """
    with open_regular(path, most) as file:
        content = file.read(most + 1)
    if len(content) > most:  # it has grown
        raise AssetError(f"{path}: expected at most {most:,} bytes.")
    return content


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


def file_below(folder: Path, name: str) -> Path | None:
    """The regular file of a name below a folder; None if there is none, or only through a link.

    Args:
        folder: a folder, which may be a link itself.
        name: any text, perhaps from a stranger: expected is a relative path with slashes.
    """
    path = _below(folder, name)
    return path if path is not None and stat.S_ISREG(path.lstat().st_mode) else None


def folder_below(folder: Path, name: str) -> Path | None:
    """The folder of a name below another one; None if there is none, or only through a link."""
    path = _below(folder, name)
    return path if path is not None and stat.S_ISDIR(path.lstat().st_mode) else None


def is_inside(name: str) -> bool:
    """Whether a text is a relative path with slashes that does not lead out of its folder on any system."""
    path = PurePosixPath(name)
    outside = path.is_absolute() or ".." in path.parts or any(letter in name for letter in "\\:\0")
    return bool(path.parts) and not outside


def remove_parts(folder: Path) -> None:
    """Remove unfinished files and folders directly in a folder, whose processes were killed.

    What a running process is still writing stays, and so does everything with another name. Links are not followed.
    """
    for part in folder.glob(f"{PART_PREFIX}*"):
        if _PART.fullmatch(part.name) and not _is_claimed(part):
            if folder_below(folder, part.name):
                shutil.rmtree(part, ignore_errors=True)
            else:
                with suppress(PermissionError):  # on Windows it is open
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


@contextmanager
def _claimed(descriptor: int | None) -> Iterator[None]:
    """Hold the lock of an unfinished file or folder, which `remove_parts` respects; closes the descriptor."""
    if descriptor is None:
        yield
        return
    if sys.platform == "win32":  # an open file can be neither removed nor renamed there
        os.close(descriptor)
        yield
        return
    try:
        try_lock(descriptor)
        yield
    finally:
        os.close(descriptor)


def _is_claimed(part: Path) -> bool:
    """Whether a running process is writing to an unfinished file or folder."""
    if sys.platform == "win32":
        return False
    try:
        descriptor = os.open(part, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK)
    except OSError:  # gone, or a link
        return False
    try:
        return not try_lock(descriptor)
    finally:
        os.close(descriptor)


@contextmanager
def _errors_about(path: Path, part: Path) -> Iterator[None]:
    """Errors of the system that name the final path, not the temporary one or none."""
    try:
        yield
    except OSError as error:
        name = None if error.filename is None else os.fspath(error.filename)
        unnamed = name is None and (error.errno is not None or type(error) is OSError)
        if not unnamed and not (isinstance(name, str) and name.startswith(str(part))):
            raise
        final = str(path) + (name or "").removeprefix(str(part))
        reason = os.strerror(error.errno) if error.errno else str(error)
        raise OSError(error.errno or errno.EIO, reason, final) from error


def _replace_files(part: Path, path: Path, names: Collection[str]) -> None:
    """Move the files of a folder into another one, the first of the names last."""
    for name in names:
        (path / name).unlink(missing_ok=True)
    for name in reversed(tuple(names)):
        if (part / name).exists():
            (part / name).replace(path / name)


def _below(folder: Path, name: str) -> Path | None:
    """The path of an existing file or folder, if no component of its name is a link."""
    if not is_inside(name):
        return None
    path = folder
    parts = PurePosixPath(name).parts
    for index, part in enumerate(parts):
        path = path / part
        try:
            status = path.lstat()
        except (OSError, ValueError):  # missing, too long, or not a name
            return None
        junction = getattr(status, "st_reparse_tag", 0) == getattr(stat, "IO_REPARSE_TAG_MOUNT_POINT", -1)
        if stat.S_ISLNK(status.st_mode) or junction or (index + 1 < len(parts) and not stat.S_ISDIR(status.st_mode)):
            return None
    return path


def _open_at_once(path: str, flags: int) -> int:
    """Descriptor of a file; a pipe without a writer is opened without waiting for one."""
    return os.open(path, flags | getattr(os, "O_NONBLOCK", 0))


def _sync(path: Path) -> None:
    """Flush a file to the disk."""
    _flush(path, os.O_RDWR)


def _sync_folder(path: Path) -> None:
    """Flush the names in a folder to the disk."""
    if hasattr(os, "O_DIRECTORY"):  # other systems cannot open folders
        _flush(path, os.O_RDONLY)


def _flush(path: Path, flags: int) -> None:
    descriptor = os.open(path, flags)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
