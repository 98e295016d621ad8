"""Model files at places that the user chose."""

from __future__ import annotations

from pathlib import Path

from grammarlab.errors import UsageError
from grammarlab.files import write_bytes


def write_whole(path: Path, content: bytes) -> None:
    """Write a file so that it never exists half-written, whatever interrupts the writing.

    Folders on the way are made. A file of this name is replaced at once when the new one is complete.

    Raises:
        UsageError: the place cannot be written to.
    """
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        write_bytes(path, content, lasting=False)
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise UsageError(f"cannot write {str(path)!r}: {reason}; choose a folder that you may write to") from error
