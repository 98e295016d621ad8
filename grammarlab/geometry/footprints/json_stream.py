"""Values of JSON from a file of any size, in bounded memory: those of lines, of records, or of one long list."""

from __future__ import annotations

import codecs
import json
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO

from grammarlab.errors import AssetError

_BLOCK_BYTES = 4 << 20
"""Bytes read at a time."""
_MAX_VALUE = 64 << 20
"""Characters of the longest value or line."""
_RECORD = "\x1e"
"""The separator of records (RFC 8142)."""
_SPACE = " \t\r\n"
_DIGITS = "0123456789+-.eE"
_LONGEST_EXPONENT = 32
"""Characters of a number behind its digits; none is longer."""
_UTF_16 = (codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)


@dataclass(frozen=True, slots=True)
class Document:
    """A line or record."""

    value: Any


@dataclass(frozen=True, slots=True)
class Damage:
    """A line or record that is not JSON."""

    number: int
    """Of lines from 1, of records from 0."""
    reason: str


@dataclass(frozen=True, slots=True)
class Member:
    """A member of the object that is the only document of a file, except its long list."""

    name: str
    value: Any


@dataclass(frozen=True, slots=True)
class Item:
    """An item of the long list of the only document of a file."""

    value: Any


Part = Document | Damage | Member | Item


def json_parts(path: Path, file: BinaryIO, list_name: str) -> Iterator[Part]:
    """The parts of a file, in their order.

    Args:
        path: name of the file, for messages.
        file: the file, read from its start.
        list_name: name of the member with the long list.

    Raises:
        AssetError: If the file is not text in UTF-8 or UTF-16, if its only document is broken, or a value is too long.
    """
    text = _Text(path, file)
    text.read()
    line, has_end, _ = text.content.lstrip(_SPACE + _RECORD).partition("\n")
    if _RECORD in text.content[: len(text.content) - len(line)] or text.content.lstrip(_SPACE).startswith(_RECORD):
        return _separate(text, _RECORD, 0)
    if has_end and _is_object(line):
        return _separate(text, "\n", 1)
    return _document(text, list_name)


class _Text:
    """The text of a file around a position.

    Args:
        path: name of the file, for messages.
        file: the file, read from its start.
    """

    def __init__(self, path: Path, file: BinaryIO) -> None:
        self.path = path
        self.content = ""
        self.position = 0
        self._file = file
        self._is_complete = False  # whether the content goes to the end of the file
        self._decoder: codecs.IncrementalDecoder | None = None
        self._scanner = json.JSONDecoder()

    def read(self) -> bool:
        """Read on, and drop what is before the position; False at the end of the file.

        Raises:
            AssetError: If what is behind the position is too long, or the file is not text.
        """
        if self._is_complete:
            return False
        self.content, self.position = self.content[self.position :], 0
        if len(self.content) > _MAX_VALUE:
            raise AssetError(f"{self.path}: expected values of at most {_MAX_VALUE:,} characters.")
        # As much again as there is, so that a long value is parsed in vain only a few times.
        block = self._file.read(max(_BLOCK_BYTES, len(self.content)))
        self._is_complete = not block
        if self._decoder is None:
            self._decoder = codecs.getincrementaldecoder("utf-16" if block[:2] in _UTF_16 else "utf-8-sig")()
        try:
            self.content += self._decoder.decode(block, final=self._is_complete)
        except UnicodeDecodeError as error:
            raise AssetError(f"{self.path}: expected text in UTF-8 or UTF-16 ({error.reason}).") from error
        return True

    def next_character(self) -> str:
        """The next character that is not space; empty at the end of the file."""
        while True:
            while self.position < len(self.content) and self.content[self.position] in _SPACE:
                self.position += 1
            if self.position < len(self.content):
                return self.content[self.position]
            if not self.read():
                return ""

    def skip(self, *characters: str) -> str:
        """Go behind the next character, which must be one of some.

        Raises:
            AssetError: If it is not.
        """
        character = self.next_character()
        if character not in characters or not character:
            expected = " or ".join(repr(one) for one in characters)
            raise self.broken(f"expected {expected}, found {repr(character) if character else 'the end of the file'}")
        self.position += 1
        return character

    def value(self) -> Any:
        """The next value.

        Raises:
            AssetError: If it is broken.
        """
        self.next_character()
        while True:
            try:
                value, end = self._scanner.raw_decode(self.content, self.position)
            except (ValueError, RecursionError) as error:
                if isinstance(error, RecursionError) or not self.read():
                    raise self.broken(_reason(error)) from error
                continue
            rest = self.content[end : end + _LONGEST_EXPONENT]
            if len(rest) < _LONGEST_EXPONENT and not rest.strip(_DIGITS) and self.read():  # a number may go on
                continue
            self.position = end
            return value

    def broken(self, reason: str) -> AssetError:
        """The error for a broken document."""
        return AssetError(f"{self.path}: expected GeoJSON, but this is not JSON ({reason}).")


def _document(text: _Text, list_name: str) -> Iterator[Part]:
    """The parts of the only document of a file."""
    if not text.next_character():
        raise AssetError(f"{text.path}: expected GeoJSON, found an empty file.")
    if text.next_character() == "[":
        yield from _items(text)
    elif text.next_character() == "{":
        yield from _members(text, list_name)
    else:
        yield Document(text.value())
    if text.next_character():
        raise text.broken("expected one value, found more")


def _members(text: _Text, list_name: str) -> Iterator[Part]:
    text.skip("{")
    if text.next_character() == "}":
        text.skip("}")
        return
    while True:
        name = text.value() if text.next_character() == '"' else text.skip('"')
        text.skip(":")
        if name == list_name and text.next_character() == "[":
            yield from _items(text)
        else:
            yield Member(name, text.value())
        if text.skip(",", "}") == "}":
            return


def _items(text: _Text) -> Iterator[Part]:
    text.skip("[")
    if text.next_character() == "]":
        text.skip("]")
        return
    while True:
        yield Item(text.value())
        if text.skip(",", "]") == "]":
            return


def _separate(text: _Text, separator: str, first: int) -> Iterator[Part]:
    """The lines or records of a file."""
    number = first
    while True:
        end = text.content.find(separator, text.position)
        if end < 0 and text.read():
            continue
        record = text.content[text.position : end if end >= 0 else None]
        if record.strip():
            try:
                yield Document(json.loads(record))
            except (ValueError, RecursionError) as error:
                yield Damage(number, _reason(error))
        if end < 0:
            return
        number += 1
        text.position = end + 1


def _is_object(text: str) -> bool:
    try:
        return isinstance(json.loads(text), dict)
    except (ValueError, RecursionError):
        return False


def _reason(error: Exception) -> str:
    return "it is nested too deeply" if isinstance(error, RecursionError) else str(error)
