"""Places of the files of a run that many machines write: a folder that they share, or a store of objects (fsspec).

A file is written whole or not at all, so that a finished file needs no other sign that it is finished.
"""

from __future__ import annotations

import errno
import os
from abc import ABC, abstractmethod
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from secrets import token_hex
from typing import Any

from grammarlab.errors import AssetError, UsageError
from grammarlab.files import PART_PREFIX, file_below, folder_below, read_bounded, remove_parts, write_bytes
from grammarlab.runs.work.run_folder import check_shared, only_run_in

_FOLDER_PROTOCOLS = ("file", "local")
_WHOLE_PUTS = frozenset({"s3", "s3a", "gs", "gcs", "az", "abfs", "abfss", "adl", "oci", "oss"})
"""Stores in which a file appears when its last byte has arrived; elsewhere it is written beside its place and moved."""


class AbstractStore(ABC):
    """Files by relative name with slashes. It can be pickled, and is the same place on all machines."""

    @abstractmethod
    def __str__(self) -> str:
        """Its path or URL."""

    @abstractmethod
    def write(self, name: str, content: bytes) -> None:
        """Write a file, which is whole or missing afterwards; an earlier one is replaced.

        Raises:
            OSError: If the place does not take it.
            UsageError: If this machine does not see the place.
        """

    @abstractmethod
    def create(self, name: str, content: bytes) -> bool:
        """Write a file that is not there; of several runs that do so at once, one succeeds where the place can tell.

        Returns:
            Whether it was written; otherwise there is one now.

        Raises:
            OSError: If the place does not take it.
        """

    @abstractmethod
    def read(self, name: str, most: int) -> bytes | None:
        """Content of a file of at most `most` bytes; None if there is none.

        Raises:
            AssetError: If it is longer.
            OSError: If it cannot be read.
        """

    @abstractmethod
    def sizes(self, folder: str) -> Iterator[tuple[str, int]]:
        """Name and size in bytes of each file directly in a folder, in one listing."""

    @abstractmethod
    def only_run(self, folder: str) -> AbstractContextManager[None]:
        """Let no other run write into the place during a block, where that can be ensured.

        Args:
            folder: name of a folder in it that the run fills too.
        """


@dataclass(frozen=True, slots=True)
class FolderStore(AbstractStore):
    """A folder, which all machines of a cluster must share."""

    folder: Path

    def __str__(self) -> str:
        return str(self.folder)

    def write(self, name: str, content: bytes) -> None:
        check_shared(self.folder)
        path = self.folder / name
        path.parent.mkdir(exist_ok=True)
        write_bytes(path, content)

    def create(self, name: str, content: bytes) -> bool:
        self.write(name, content)  # no other run is in the folder: `only_run`
        return True

    def read(self, name: str, most: int) -> bytes | None:
        file = file_below(self.folder, name)
        return None if file is None else read_bounded(file, most)

    def sizes(self, folder: str) -> Iterator[tuple[str, int]]:
        inside = folder_below(self.folder, folder)
        if inside is None:
            return
        with os.scandir(inside) as entries:
            for entry in entries:
                if entry.is_file(follow_symlinks=False):
                    yield entry.name, entry.stat(follow_symlinks=False).st_size

    @contextmanager
    def only_run(self, folder: str) -> Iterator[None]:
        with only_run_in(self.folder, (folder,)):
            try:
                yield
            finally:  # unfinished files of killed workers
                remove_parts(self.folder / folder)


@dataclass(frozen=True, slots=True)
class UrlStore(AbstractStore):
    """A folder of a store of objects, which has no locks. Equal runs may write into it at once: they write equal files.

    Another run finds the plan of the first one (`create`).
    """

    url: str
    """``s3://bucket/folder`` or another URL that fsspec knows."""

    def __str__(self) -> str:
        return self.url

    def write(self, name: str, content: bytes) -> None:
        system, root = _opened(self.url)
        path = f"{root}/{name}"
        with _errors_about(f"{self.url}/{name}"):
            if _protocol(self.url) in _WHOLE_PUTS:
                system.pipe_file(path, content)
                return
            folder, _, last = path.rpartition("/")
            part = f"{folder}/{PART_PREFIX}{token_hex(8)}-{last}"
            system.makedirs(folder, exist_ok=True)
            system.pipe_file(part, content)
            system.mv(part, path)

    def create(self, name: str, content: bytes) -> bool:
        system, root = _opened(self.url)
        try:
            system.pipe_file(f"{root}/{name}", content, mode="create")
        except FileExistsError:
            return False
        except Exception:  # a store that cannot tell, or does not take files at all, as the next line says
            self.write(name, content)
        return True

    def read(self, name: str, most: int) -> bytes | None:
        system, root = _opened(self.url)
        try:
            with _errors_about(f"{self.url}/{name}"):
                content = system.cat_file(f"{root}/{name}", end=most + 1)
        except FileNotFoundError:
            return None
        if len(content) > most:
            raise AssetError(f"{self.url}/{name}: expected at most {most:,} bytes.")
        return content

    def sizes(self, folder: str) -> Iterator[tuple[str, int]]:
        system, root = _opened(self.url)
        try:
            with _errors_about(f"{self.url}/{folder}"):
                entries = system.find(f"{root}/{folder}", maxdepth=1, detail=True)
        except FileNotFoundError:
            return
        for path, entry in entries.items():
            yield path.rpartition("/")[2], int(entry.get("size") or 0)

    def only_run(self, folder: str) -> AbstractContextManager[None]:
        return nullcontext()


def store_at(target: str | Path) -> AbstractStore:
    """Place of a path or a URL.

    Raises:
        UsageError: If the URL has a protocol for which a package is missing.
    """
    text = str(target)
    if "://" not in text:
        return FolderStore(Path(target).absolute())
    if _protocol(text) in _FOLDER_PROTOCOLS:
        return FolderStore(Path(text.partition("://")[2]).absolute())
    url = text.rstrip("/")
    _opened(url)
    return UrlStore(url)


def _protocol(url: str) -> str:
    return url.partition("://")[0].partition("::")[0].lower()


@lru_cache(maxsize=8)
def _opened(url: str) -> tuple[Any, str]:
    """The file system of a URL and the path in it, opened once per process: it does not survive a fork.

    Listings are not cached, since other machines write too.
    """
    import fsspec  # noqa: PLC0415  # an extra

    try:
        system, root = fsspec.url_to_fs(url, use_listings_cache=False)
    except (ImportError, ValueError) as error:
        raise UsageError(f"{url:.200}: expected a folder or a URL that fsspec can open: {error!s:.200}") from error
    return system, root.rstrip("/")


@contextmanager
def _errors_about(url: str) -> Iterator[None]:
    """Errors of a store, of whatever type, as errors of the system that name the file."""
    try:
        yield
    except FileNotFoundError:
        raise
    except Exception as error:
        reason = f"{type(error).__name__}: {error!s:.300}"
        raise OSError(getattr(error, "errno", None) or errno.EIO, reason, url) from error
