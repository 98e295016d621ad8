"""Exclusive locks on open files, held by the operating system: they end with their process, however it ends."""

from __future__ import annotations

import errno
import os
import sys

_BUSY = (errno.EACCES, errno.EAGAIN, errno.EDEADLK)
"""Errors of a lock that another descriptor holds; other errors come from file systems without locks."""


def try_lock(descriptor: int) -> bool:
    """Lock an open file or folder until its descriptor is closed.

    Two descriptors exclude each other within one process too, except for duplicates. A file system without locks, such
    as some network drives, counts as free.

    Args:
        descriptor: open for writing if it is a file. On Windows it cannot be a folder.

    Returns:
        Whether no other descriptor holds the lock.
    """
    try:
        _lock(descriptor)
    except OSError as error:
        return error.errno not in _BUSY
    return True


if sys.platform == "win32":
    import msvcrt

    def _lock(descriptor: int) -> None:
        os.lseek(descriptor, 0, os.SEEK_SET)
        msvcrt.locking(descriptor, msvcrt.LK_NBLCK, 1)  # the first byte, which need not exist

else:
    import fcntl

    def _lock(descriptor: int) -> None:
        # Not lockf: its locks end when any descriptor of the file is closed, and threads do not exclude each other.
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
