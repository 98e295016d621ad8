"""Model files at places that the user chose."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from tempfile import SpooledTemporaryFile
from typing import IO

from grammarlab.errors import UsageError
from grammarlab.files import atomic_file

IN_MEMORY = 4 << 20
"""Bytes of a part up to which it needs no temporary file."""


@dataclass(frozen=True, slots=True)
class Output:
    """A file in the making, and the parts that are to be put into it at its end."""

    stream: IO[bytes]
    folder: str | None
    """Where parts that grow large lie until then; None for the system's folder of temporary files."""
    _parts: ExitStack

    def part(self) -> IO[bytes]:
        """An empty stream to write, and to read again, as long as the file is open."""
        return self._parts.enter_context(SpooledTemporaryFile(max_size=IN_MEMORY, dir=self.folder))


@contextmanager
def whole_file(path: Path) -> Iterator[Output]:
    """A file that appears under its name at the end of the block, complete, or never.

    Folders on the way are made. A file of this name is replaced at once.

    Raises:
        UsageError: the place cannot be written to.
    """
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        # Models can be made again, and waiting for the disk would take longer than making them.
        with atomic_file(path, lasting=False) as part, part.open("xb") as stream, ExitStack() as parts:
            yield Output(stream, str(path.parent), parts)
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise UsageError(f"cannot write {str(path)!r}: {reason}; choose a folder that you may write to") from error


def write_whole(path: Path, content: bytes) -> None:
    """Write a file so that it never exists half-written, whatever interrupts the writing; see `whole_file`."""
    with whole_file(path) as output:
        output.stream.write(content)
