"""Model files at paths chosen by the user, and the interface of all formats: models are added one after the other."""

from __future__ import annotations

import abc
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from tempfile import SpooledTemporaryFile
from typing import IO

import numpy as np
from numpy.typing import NDArray

from grammarlab.errors import UsageError
from grammarlab.files import FULL_DISK, atomic_file
from grammarlab.scene import Scene, TriangleBatch

GENERATOR = "grammarlab"
IN_MEMORY = 4 << 20
"""Largest size of a part in memory, in bytes; larger parts use temporary files."""


class AbstractWriter(abc.ABC):
    """One file in the making. It depends on the models and their order, and not on how they came in batches."""

    @abc.abstractmethod
    def add(self, scene: Scene, batch: TriangleBatch, name: str, offset: NDArray[np.float64]) -> None:
        """Add one model.

        Args:
            scene: the model.
            batch: triangles of the model.
            name: name of the model in the file.
            offset: [3] origin of its coordinates, in metres from the origin of the file.

        Raises:
            AssetError: a texture is unusable.
        """

    @abc.abstractmethod
    def finish(self) -> tuple[Path, ...]:
        """Write what is not yet written, after the last model.

        Returns:
            Further files beside the file.
        """


@dataclass(frozen=True, slots=True)
class Output:
    """An unfinished file, and the parts that are appended at its end."""

    stream: IO[bytes]
    folder: str | None
    """Folder of large parts; None for the system's folder of temporary files."""
    _parts: ExitStack

    def part(self) -> IO[bytes]:
        """An empty stream to write and read again while the file is open."""
        return self._parts.enter_context(_Part(max_size=IN_MEMORY, dir=self.folder))


@contextmanager
def whole_file(path: Path) -> Iterator[Output]:
    """A file that appears under its name, complete, at the end of the block, or not at all.

    Parent folders are made. An existing file is replaced atomically.

    Raises:
        UsageError: If the path cannot be written to.
        OSError: If the disk is full; it names the path.
    """
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        # Models can be made again, faster than a flush to the disk takes.
        with atomic_file(path, lasting=False) as part, part.open("wb") as stream, ExitStack() as parts:
            yield Output(stream, str(path.parent), parts)
    except (OSError, ValueError) as error:
        if isinstance(error, OSError) and error.errno in FULL_DISK:
            raise
        reason = getattr(error, "strerror", None) or str(error)
        raise UsageError(f"cannot write {str(path)!r}: {reason}; choose a folder that you may write to") from error


def write_whole(path: Path, content: bytes) -> None:
    """Write a file atomically; see `whole_file`."""
    with whole_file(path) as output:
        output.stream.write(content)


class _Part(SpooledTemporaryFile[bytes]):
    """A temporary file whose destructor, which asks whether it is closed, works after Ctrl-C in its constructor."""

    @property
    def closed(self) -> bool:
        try:
            return super().closed
        except AttributeError:
            return True  # there is no file yet
