"""Folder of a run: one run at a time writes into it, and removes the files of the run before and nothing else."""

from __future__ import annotations

import json
import os
import platform
import stat
import sys
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from grammarlab.errors import AssetError, UsageError
from grammarlab.files import file_below, file_hash, folder_below, read_bounded, remove_parts, write_text
from grammarlab.locks import try_lock

WRITTEN = ".grammarlab.json"
"""SHA-256 of each file by command and by path relative to the folder."""
LOCK = ".grammarlab.lock"
"""Empty file in the folder of a running command; removed at its end. A killed command leaves it, without a lock."""
_MAX_BYTES = 1 << 24
"""Largest size of the record in bytes."""


def replace_written(folder: Path, command: str, files: Iterable[Path], sources: Iterable[Path] = ()) -> None:
    """Remove files of the earlier run of a command that are not among its new files, and record the new ones.

    A file that was changed since stays, and so does one that a link leads to.

    Args:
        folder: folder of the command's output.
        command: name of the command.
        files: all files below the folder that the command has written now.
        sources: inputs of the command, which are not removed even if an earlier run wrote them.
    """
    record = _record(folder)
    inputs = [path for path in sources if path.exists()]
    written = {path.relative_to(folder).as_posix(): file_hash(path) for path in files}
    for name, digest in record.get(command, {}).items():
        file = None if name in written else file_below(folder, name)
        if file is None or any(map(file.samefile, inputs)):
            continue
        if file_hash(file) == digest:
            file.unlink()
    record[command] = dict(sorted(written.items()))
    write_text(folder / WRITTEN, json.dumps(record, indent=1, ensure_ascii=False) + "\n")


@contextmanager
def only_run_in(folder: Path, inner: Sequence[str] = ()) -> Iterator[None]:
    """Let no other command that uses this function write into a folder during a block.

    The system ends the lock with the process, however that ends. What killed commands left unfinished is removed.
    Worker processes of the caller may write into the folder.

    Args:
        folder: made if missing.
        inner: names of folders in it that the caller fills too.

    Raises:
        UsageError: If another command is writing into it, or it or an inner folder is a file or a link to nothing.
        OSError: If it cannot be written to.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except FileExistsError as error:
        raise UsageError(
            f"{folder} is a file or a link to nothing: expected a folder. Write into another folder."
        ) from error
    path = folder / LOCK
    descriptor = _locked(path)
    try:
        for part_of in (folder, *filter(None, (own_folder(folder, name) for name in inner))):
            remove_parts(part_of)
        yield
    finally:
        _release(path, descriptor)


def check_shared(folder: Path) -> None:
    """Check, in a process that works for a run, that it sees the folder that the run has locked (`only_run_in`).

    Raises:
        UsageError: If it does not: it is on another machine, where the path names nothing or another folder.
    """
    if not (folder / LOCK).exists():
        raise UsageError(
            f"{folder}: machine {platform.node()!r} does not see the run's folder. Write into a folder that all "
            "machines of the cluster share, by a path that is the same on all of them."
        )


def own_folder(folder: Path, name: str) -> Path | None:
    """A folder in the folder of a run, that the run may fill; None if there is none yet.

    Raises:
        UsageError: If a link or a file is in its place: what a link leads to is not the run's.
    """
    inner = folder_below(folder, name)
    if inner is None and os.path.lexists(folder / name):
        raise UsageError(
            f"{folder / name}: expected a folder, since the run writes into it; found a link or a file. Remove it, or "
            "write into another folder."
        )
    return inner


def _record(folder: Path) -> dict[str, Mapping[str, Any]]:
    """The record in a folder, perhaps of a stranger; empty if there is none."""
    try:
        values = json.loads(read_bounded(folder / WRITTEN, _MAX_BYTES))
    except (AssetError, OSError, ValueError, RecursionError):
        return {}
    if not isinstance(values, dict):
        return {}
    return {command: files for command, files in values.items() if isinstance(files, dict)}


def _locked(path: Path) -> int:
    """Descriptor of the locked file."""
    while True:
        descriptor = _opened(path)
        try:
            free, current = try_lock(descriptor), _is_at(path, descriptor)
        except BaseException:
            os.close(descriptor)
            raise
        if free and current:
            return descriptor
        os.close(descriptor)
        if not free:
            raise UsageError(
                f"another run is writing into {path.parent}: wait until it has ended, or write into another folder."
            )

        # The run before has just removed this file.


def _opened(path: Path) -> int:
    flags = os.O_RDWR | os.O_CREAT
    if sys.platform != "win32":
        flags |= os.O_NOFOLLOW | os.O_NONBLOCK
    try:
        if path.is_symlink():
            raise _not_a_lock(path)
        descriptor = os.open(path, flags, 0o666)
    except OSError as error:
        if path.is_symlink() or path.is_dir():
            raise _not_a_lock(path) from error
        raise OSError(error.errno, error.strerror, str(path if path.exists() else path.parent)) from error
    status = os.fstat(descriptor)
    if not stat.S_ISREG(status.st_mode) or status.st_size:
        os.close(descriptor)
        raise _not_a_lock(path)
    return descriptor


def _not_a_lock(path: Path) -> UsageError:
    return UsageError(
        f"{path}: expected no file of this name, or an empty one that a stopped run left; found another. Remove it, or "
        "write into another folder."
    )


def _is_at(path: Path, descriptor: int) -> bool:
    """Whether the open file has a name."""
    try:
        return os.path.samestat(path.lstat(), os.fstat(descriptor))
    except FileNotFoundError:
        return False


def _release(path: Path, descriptor: int) -> None:
    if sys.platform == "win32":  # an open file cannot be removed there, so the next run's file stays
        os.close(descriptor)
        with suppress(OSError):
            path.unlink()
        return
    with suppress(OSError):
        if _is_at(path, descriptor):
            path.unlink()
    os.close(descriptor)
