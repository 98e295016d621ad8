"""TOML from strangers."""

from __future__ import annotations

import pickle
import random
import tomllib

import pytest

from grammarlab.errors import TomlError
from grammarlab.toml_text import MOST_KEY_PARTS, toml_table, toml_text

TEXT = '# a design\ntitle = "Grüße"\ncanvas = { width = 6.0, height = 3 }\n[symbols]\nA = 1.0\n[[layers]]\nx = "A^k"\n'


@pytest.mark.parametrize("mark", [b"", b"\xef\xbb\xbf"])
@pytest.mark.parametrize("end", ["\n", "\r\n"])
def test_text_is_the_same_with_a_byte_order_mark_and_windows_line_ends(mark, end):
    content = mark + TEXT.replace("\n", end).encode()
    assert toml_text(content) == TEXT
    assert toml_table(toml_text(content)) == tomllib.loads(TEXT)


@pytest.mark.parametrize("encoding", ["utf-16", "utf-16-le", "utf-16-be", "utf-32"])
def test_utf_16_is_refused_by_its_name(encoding):
    with pytest.raises(TomlError, match="expected text in UTF-8, found UTF-16: save the file as UTF-8"):
        toml_text(TEXT.encode(encoding))


def test_other_bytes_are_refused_with_their_place():
    content = "a = 1\n# é\nb = 'Bâtiment'\n".encode()
    at = content.rindex("â".encode())
    with pytest.raises(TomlError) as caught:
        toml_text(content[:at] + b"\xe2" + content[at + 2 :])
    assert (caught.value.line, caught.value.column) == (3, 7)
    assert f"byte {at} is not" in caught.value.message


@pytest.mark.parametrize(
    ("text", "message", "place"),
    [
        ("a = 1\n b = ", "this is not TOML: Invalid value", (2, 6)),
        ("a = 1\nb = [", "this is not TOML", (2, 6)),
        ("a = 1\na = 2", "Cannot overwrite a value", (2, 6)),
        ("a = 1\nb = " + "9" * 5_000, "integer of at most 64 bits", (2, 5)),
        ("a = 1\nb = [1, -" + "9" * 30 + "]", "integer of at most 64 bits", (2, 10)),
        ("a = 1\nb = 0x" + "f" * 5_000, "integer of at most 64 bits", (2, 5)),
        ("b = " + "[" * 20_000, "nested too deep", (None, None)),
        ("b = " + "{ a = " * 20_000, "nested too deep", (None, None)),
        ("b = 1\n" + "a." * 200_000 + "a = 1", f"at most {MOST_KEY_PARTS} parts", (2, 1)),
        ("[" + "'a' . " * 200_000 + "a]", f"at most {MOST_KEY_PARTS} parts", (1, 2)),
    ],
    ids=lambda value: str(value)[:20],
)
def test_mistakes_have_a_place_and_are_found_soon(text, message, place):
    with pytest.raises(TomlError, match=message) as caught:
        toml_table(text)
    assert (caught.value.line, caught.value.column) == place
    copy = pickle.loads(pickle.dumps(caught.value))  # noqa: S301  # our own bytes
    assert str(copy) == str(caught.value)


@pytest.mark.parametrize(
    "text", ["a" * 1_000_000, "a = '" + "a." * 10 + "'", "a = 18446744073709551615", "a" * 9 + " ="]
)
def test_the_bounds_refuse_no_ordinary_text(text):
    try:
        expected = tomllib.loads(text)
    except tomllib.TOMLDecodeError:
        with pytest.raises(TomlError, match="this is not TOML"):
            toml_table(text)
    else:
        assert toml_table(text) == expected


@pytest.mark.parametrize("seed", range(40))
def test_any_change_of_bytes_ends_in_a_table_or_an_error(seed):
    chance = random.Random(seed)
    content = bytearray(TEXT.encode())
    for _ in range(chance.randrange(1, 6)):
        at = chance.randrange(len(content))
        content[at : at + chance.randrange(3)] = chance.choice(
            [
                b"\0",
                b"\x1b",
                b"\xff",
                b"\xed\xa0\x80",
                b"9" * 4_301,
                b"1e999",
                b"[" * 2_000,
                b"\xe2\x80\xae",
                b"\xef\xbb\xbf",
            ]
        )
    try:
        table = toml_table(toml_text(bytes(content)))
    except TomlError as error:
        assert error.message  # noqa: PT017
    else:
        assert repr(table)
