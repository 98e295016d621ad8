"""7z archives written for tests, also damaged and hostile ones."""

from __future__ import annotations

import lzma
import struct
from collections.abc import Sequence
from zlib import crc32

LZMA_PROPERTIES = b"\x5d" + struct.pack("<I", 1 << 16)
"""Literal and position bits as usual, and a dictionary of 64 KiB."""


def archive(
    files: Sequence[tuple[str, bytes]],
    compressed: bool = True,
    properties: bytes = LZMA_PROPERTIES,
    size: int | None = None,
    attributes: Sequence[int] | None = None,
) -> bytes:
    """An archive of one folder for each file.

    Args:
        files: names and contents.
        compressed: by LZMA, or stored.
        properties: what the archive says of its decoder.
        size: what it says of the size of each file; the true one by default.
        attributes: of each file, in Windows' and Unix' form.
    """
    packed = [_compressed(content) if compressed else content for _, content in files]
    coder = b"\x23\x03\x01\x01" + number(len(properties)) + properties if compressed else b"\x01\x00"
    sizes = [len(content) if size is None else size for _, content in files]
    count = number(len(files))
    streams = b"\x06" + number(0) + count + b"\x09" + b"".join(number(len(part)) for part in packed) + b"\x00"
    streams += b"\x07\x0b" + count + b"\x00" + (b"\x01" + coder) * len(files)
    streams += b"\x0c" + b"".join(map(number, sizes)) + b"\x0a\x01"
    streams += b"".join(struct.pack("<I", crc32(content)) for _, content in files) + b"\x00\x08\x00"
    names = b"\x00" + b"".join(name.encode("utf-16-le") + b"\x00\x00" for name, _ in files)
    properties_of_files = b"\x11" + number(len(names)) + names
    if attributes is not None:
        content = b"\x01\x00" + b"".join(struct.pack("<I", value) for value in attributes)
        properties_of_files += b"\x15" + number(len(content)) + content
    header = b"\x01\x04" + streams + b"\x00\x05" + count + properties_of_files + b"\x00\x00"
    return enclosed(b"".join(packed), header)


def enclosed(body: bytes, header: bytes) -> bytes:
    """A start, compressed streams and a header as an archive."""
    start = struct.pack("<QQI", len(body), len(header), crc32(header))
    return b"7z\xbc\xaf\x27\x1c\x00\x04" + struct.pack("<I", crc32(start)) + start + body + header


def with_packed_header(data: bytes) -> bytes:
    """An archive whose header is compressed itself."""
    body, header = parts_of(data)
    packed = _compressed(header)
    streams = b"\x06" + number(len(body)) + b"\x01\x09" + number(len(packed)) + b"\x00"
    streams += (
        b"\x07\x0b\x01\x00\x01\x23\x03\x01\x01\x05" + LZMA_PROPERTIES + b"\x0c" + number(len(header)) + b"\x00\x00"
    )
    return enclosed(body + packed, b"\x17" + streams)


def parts_of(data: bytes) -> tuple[bytes, bytes]:
    """The compressed streams and the header of an archive."""
    offset, size, _ = struct.unpack_from("<QQI", data, 12)
    return data[32 : 32 + offset], data[32 + offset : 32 + offset + size]


def number(value: int) -> bytes:
    """A number of up to 64 bits."""
    for length in range(8):
        if value < 1 << 7 * (length + 1):
            first = (0xFF00 >> length & 0xFF) | value >> 8 * length
            return bytes([first]) + (value & ((1 << 8 * length) - 1)).to_bytes(length, "little")
    return b"\xff" + value.to_bytes(8, "little")


def _compressed(content: bytes) -> bytes:
    choice = {"id": lzma.FILTER_LZMA1, "dict_size": 1 << 16, "lc": 3, "lp": 0, "pb": 2}
    return lzma.compress(content, lzma.FORMAT_RAW, filters=[choice])
