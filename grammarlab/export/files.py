"""Files that are either whole or not there."""

from __future__ import annotations

import secrets
from pathlib import Path

from grammarlab.errors import UsageError


def write_whole(path: Path, content: bytes) -> None:
    """Write a file so that it never exists half-written, whatever interrupts the writing.

    Folders on the way are made. A file of this name is replaced at once when the new one is complete.

    Raises:
        UsageError: the place cannot be written to.
    """
    try:
        part = path.with_name(f".{path.name}.{secrets.token_hex(4)}.part")
        path.parent.mkdir(parents=True, exist_ok=True)
        try:
            with part.open("xb") as stream:
                stream.write(content)
            part.replace(path)
        except BaseException:
            part.unlink(missing_ok=True)
            raise
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise UsageError(f"cannot write {str(path)!r}: {reason}; choose a folder that you may write to") from error
