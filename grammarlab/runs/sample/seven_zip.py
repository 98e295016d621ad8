"""Files of 7z archives, as CityEngine writes its rule packages: stored, or compressed by LZMA or LZMA2.

An archive from a stranger is hostile: sizes, memory, numbers and names are bounded before anything is unpacked.
Format: "7zFormat.txt" of the LZMA SDK.
"""

from __future__ import annotations

import lzma
import struct
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from typing import NamedTuple
from zlib import crc32

from grammarlab.errors import AssetError

MAX_PACKED, MAX_UNPACKED = 1 << 29, 1 << 29
"""Largest size in bytes of an archive, and of all its files."""
MAX_FILES = 10_000
"""Largest number of files of an archive."""
_MAX_HEADER, _MAX_DICTIONARY = 1 << 24, 1 << 26
"""Largest size in bytes of a header, and of the memory of a decoder."""
_MAX_NAME = 1_000
_SIGNATURE = b"7z\xbc\xaf\x27\x1c"
_END, _HEADER, _STREAMS, _FILES, _PACKED, _UNPACKED, _SUBSTREAMS, _SIZES, _DIGESTS = 0, 1, 4, 5, 6, 7, 8, 9, 10
_FOLDER, _UNPACKED_SIZES, _COUNTS, _EMPTY, _EMPTY_FILES, _NAMES, _ATTRIBUTES, _ENCODED = 11, 12, 13, 14, 15, 17, 21, 23
_COPY, _LZMA, _LZMA2 = b"\x00", b"\x03\x01\x01", b"\x21"
_LINK = 0o120000
"""Kind of a file in Unix attributes: a link."""


class ArchiveFile(NamedTuple):
    """A file of an archive."""

    name: PurePosixPath
    """Relative path that leads nowhere but below the archive's folder."""
    content: bytes


def files_of(path: Path) -> Iterator[ArchiveFile]:
    """The files of an archive, one after the other; folders are left out.

    Raises:
        AssetError: If it is not an archive of this kind, is damaged, or exceeds a bound. Nothing that was read before
            is wrong then, but it is not all.
    """
    try:
        if path.stat().st_size > MAX_PACKED:
            raise AssetError(f"expected at most {MAX_PACKED:,} bytes, found {path.stat().st_size:,}")
        data = path.read_bytes()
    except OSError as error:
        raise AssetError(f"cannot be read: {error.strerror or error}") from error
    try:
        yield from _files(data)
    except (IndexError, struct.error, lzma.LZMAError, UnicodeDecodeError, OverflowError, ValueError) as error:
        raise AssetError("the 7z archive is damaged") from error


def _files(data: bytes) -> Iterator[ArchiveFile]:
    if not data.startswith(_SIGNATURE):
        raise AssetError("expected a 7z archive")
    offset, size, digest = struct.unpack_from("<QQI", data, 12)
    if crc32(data[12:32]) != struct.unpack_from("<I", data, 8)[0]:
        raise AssetError("the 7z archive is damaged: the checksum of its start differs")
    header = data[32 + offset : 32 + offset + size]
    if len(header) != size or size > _MAX_HEADER or crc32(header) != digest:
        raise AssetError("the 7z archive is damaged: the checksum of its header differs")
    if header[:1] == bytes([_ENCODED]):
        streams = _Reader(header, 1).streams()
        header = b"".join(content for content in _contents(data, streams, _MAX_HEADER))
    streams, names, is_empty = _Reader(header, 1).header()
    contents = _contents(data, streams, MAX_UNPACKED)
    for name, empty in zip(names, is_empty, strict=True):
        if not empty:
            yield ArchiveFile(_safe(name), next(contents))


def _contents(data: bytes, streams: _Streams, bound: int) -> Iterator[bytes]:
    """What the streams of an archive contain, in order."""
    if sum(folder.size for folder in streams.folders) > bound:
        raise AssetError(f"expected at most {bound:,} bytes after unpacking")
    begin = 32 + streams.start
    for folder, packed in zip(streams.folders, streams.packed_sizes, strict=True):
        whole = _decoded(data[begin : begin + packed], folder)
        begin, at = begin + packed, 0
        if sum(size for size, _ in folder.parts) != folder.size:
            raise AssetError("the 7z archive is damaged: sizes differ")
        for size, digest in folder.parts:
            part = whole[at : at + size]
            if digest is not None and crc32(part) != digest:
                raise AssetError("the 7z archive is damaged: the checksum of a file differs")
            yield part
            at += size


def _decoded(packed: bytes, folder: _Folder) -> bytes:
    """The content of a folder, never more than it says."""
    if folder.method == _COPY:
        content = packed
    else:
        decoder = lzma.LZMADecompressor(lzma.FORMAT_RAW, filters=[_filter(folder)])
        content = decoder.decompress(packed, folder.size)
        while len(content) < folder.size and not decoder.eof:
            more = decoder.decompress(b"", folder.size - len(content))
            if not more:
                break
            content += more
    if len(content) != folder.size:
        raise AssetError("the 7z archive is damaged: a file is too short")
    return content


def _filter(folder: _Folder) -> dict[str, int]:
    properties = folder.properties
    if folder.method == _LZMA and len(properties) == 5:
        flags, size = properties[0], struct.unpack_from("<I", properties, 1)[0]
        choice = {"id": lzma.FILTER_LZMA1, "lc": flags % 9, "lp": flags // 9 % 5, "pb": flags // 45}
    elif folder.method == _LZMA2 and len(properties) == 1 and properties[0] <= 40:
        size = (2 | properties[0] & 1) << (properties[0] // 2 + 11)
        choice = {"id": lzma.FILTER_LZMA2}
    else:
        raise AssetError("the 7z archive is compressed by another method than LZMA; unpack it with a program for 7z")
    if size > _MAX_DICTIONARY:
        raise AssetError(f"the 7z archive needs {size:,} bytes of memory, more than {_MAX_DICTIONARY:,}")
    return {**choice, "dict_size": max(size, 1 << 12)}


def _safe(name: str) -> PurePosixPath:
    """A name as a relative path.

    Raises:
        AssetError: If it leads out of the folder that the archive is unpacked to, or is no name of a file.
    """
    path = PurePosixPath(name.replace("\\", "/"))
    bad = path.is_absolute() or not path.parts or ".." in path.parts or len(name) > _MAX_NAME
    if bad or any(ord(letter) < 32 or letter in ':*?"<>|' for letter in name):
        raise AssetError(f"the 7z archive has a file with the name {name[:80]!r}, which leads out of its folder")
    return path


@dataclass(slots=True)
class _Folder:
    """One compressed stream."""

    method: bytes
    properties: bytes
    size: int = 0
    digest: int | None = None
    parts: Sequence[tuple[int, int | None]] = ()
    """Size and checksum of each file in it."""


class _Streams(NamedTuple):
    start: int
    packed_sizes: list[int]
    folders: list[_Folder]


class _Reader:
    """Numbers and lists of a header."""

    def __init__(self, data: bytes, at: int) -> None:
        self._data, self._at = data, at

    def header(self) -> tuple[_Streams, list[str], list[bool]]:
        """Streams, names of files, and which files have no stream."""
        streams = _Streams(0, [], [])
        if self._data[:1] != bytes([_HEADER]):
            raise AssetError("the 7z archive is damaged: it has no header")
        while (kind := self._byte()) != _END:
            if kind == _STREAMS:
                streams = self.streams()
            elif kind == _FILES:
                return (streams, *self._files())
            else:
                raise AssetError("the 7z archive has a part that is not read here; unpack it with a program for 7z")
        return streams, [], []

    def streams(self) -> _Streams:
        """Compressed streams and what is in them."""
        start, sizes, folders = 0, list[int](), list[_Folder]()
        while (kind := self._byte()) != _END:
            if kind == _PACKED:
                start, sizes = self._packed()
            elif kind == _UNPACKED:
                folders = self._folders()
                for folder in folders:
                    folder.parts = [(folder.size, folder.digest)]
            elif kind == _SUBSTREAMS:
                self._substreams(folders)
            else:
                raise ValueError(kind)
        if len(sizes) != len(folders):
            raise AssetError("the 7z archive is compressed by several methods; unpack it with a program for 7z")
        return _Streams(start, sizes, folders)

    def _packed(self) -> tuple[int, list[int]]:
        start, count, sizes = self._number(), self._count(), list[int]()
        while (kind := self._byte()) != _END:
            if kind == _SIZES:
                sizes = [self._number() for _ in range(count)]
            elif kind == _DIGESTS:
                self._digests(count)
            else:
                raise ValueError(kind)
        return start, sizes

    def _folders(self) -> list[_Folder]:
        folders: list[_Folder] = []
        while (kind := self._byte()) != _END:
            if kind == _FOLDER:
                count = self._count()
                if self._byte():
                    raise ValueError("external")
                folders = [self._folder() for _ in range(count)]
            elif kind == _UNPACKED_SIZES:
                for folder in folders:
                    folder.size = self._number()
            elif kind == _DIGESTS:
                for folder, digest in zip(folders, self._digests(len(folders)), strict=True):
                    folder.digest = digest
            else:
                raise ValueError(kind)
        return folders

    def _folder(self) -> _Folder:
        coders, flags = self._number(), self._byte()
        if coders != 1 or flags & 0x10:
            raise AssetError("the 7z archive is compressed by several methods; unpack it with a program for 7z")
        method = self._bytes(flags & 0x0F)
        return _Folder(method, self._bytes(self._count()) if flags & 0x20 else b"")

    def _substreams(self, folders: list[_Folder]) -> None:
        counts, kind = [1] * len(folders), self._byte()
        if kind == _COUNTS:
            counts, kind = [self._count() for _ in folders], self._byte()
        if sum(counts) > MAX_FILES:
            raise AssetError(f"expected at most {MAX_FILES:,} files, found {sum(counts):,}")
        sizes = [[0] * count for count in counts]
        for folder, own in zip(folders, sizes, strict=True):
            for index in range(len(own) - 1):
                own[index] = self._number() if kind == _SIZES else 0
            if own:
                own[-1] = folder.size - sum(own)
        kind = self._byte() if kind == _SIZES else kind
        digests: list[list[int | None]] = [
            [f.digest] if len(own) == 1 else [None] * len(own) for f, own in zip(folders, sizes, strict=True)
        ]
        while kind != _END:
            if kind != _DIGESTS:
                raise ValueError(kind)
            unknown = [(i, j) for i, own in enumerate(digests) for j, digest in enumerate(own) if digest is None]
            for (i, j), digest in zip(unknown, self._digests(len(unknown)), strict=True):
                digests[i][j] = digest
            kind = self._byte()
        for folder, own, checks in zip(folders, sizes, digests, strict=True):
            if any(size < 0 for size in own):
                raise ValueError("size")
            folder.parts = list(zip(own, checks, strict=True))
            folder.size = folder.size if own else sum(own)

    def _files(self) -> tuple[list[str], list[bool]]:
        count = self._count()
        names, empty = list[str](), [False] * count
        while (kind := self._byte()) != _END:
            size = self._number()
            content = _Reader(self._bytes(size), 0)
            if kind == _EMPTY:
                empty = content._bits(count)
            elif kind == _NAMES:
                names = content._names(count)
            elif kind == _ATTRIBUTES:
                content._refuse_links(count)
        if len(names) != count:
            raise ValueError("names")
        return names, empty

    def _names(self, count: int) -> list[str]:
        if self._byte():
            raise ValueError("external")
        text = self._data[self._at :].decode("utf-16-le")
        return text.split("\0")[:count]

    def _refuse_links(self, count: int) -> None:
        is_known = self._optional_bits(count)
        if self._byte():
            raise ValueError("external")
        for _ in range(sum(is_known)):
            (attributes,) = struct.unpack("<I", self._bytes(4))
            if attributes >> 16 & 0o170000 == _LINK:
                raise AssetError("the 7z archive contains a link, which could lead out of its folder")

    def _digests(self, count: int) -> list[int | None]:
        is_known = self._optional_bits(count)
        return [struct.unpack("<I", self._bytes(4))[0] if known else None for known in is_known]

    def _optional_bits(self, count: int) -> list[bool]:
        return [True] * count if self._byte() else self._bits(count)

    def _bits(self, count: int) -> list[bool]:
        packed = self._bytes((count + 7) // 8)
        return [bool(packed[index // 8] >> (7 - index % 8) & 1) for index in range(count)]

    def _count(self) -> int:
        """A number of entries, which cannot exceed the bytes that follow by much."""
        count = self._number()
        if count > MAX_FILES:
            raise AssetError(f"expected at most {MAX_FILES:,} files, found {count:,}")
        return count

    def _number(self) -> int:
        """A number of up to 64 bits: the leading ones of the first byte count the bytes that follow."""
        first, value, mask = self._byte(), 0, 0x80
        for index in range(8):
            if not first & mask:
                return value | (first & (mask - 1)) << (8 * index)
            value |= self._byte() << (8 * index)
            mask >>= 1
        return value

    def _byte(self) -> int:
        value = self._data[self._at]
        self._at += 1
        return value

    def _bytes(self, count: int) -> bytes:
        part = self._data[self._at : self._at + count]
        if len(part) != count:
            raise IndexError(count)
        self._at += count
        return part
