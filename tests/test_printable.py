"""Text that a terminal may show."""

from __future__ import annotations

import unicodedata

import pytest
from hypothesis import given
from hypothesis import strategies as st

from grammarlab.errors import Finding, Location
from grammarlab.printable import printable

DIRECTIONS = {"LRE", "RLE", "PDF", "LRO", "RLO", "LRI", "RLI", "FSI", "PDI"}


def is_safe(character: str) -> bool:
    """Whether Unicode's own tables call a character harmless."""
    is_direction = unicodedata.bidirectional(character) in DIRECTIONS or character in "\u061c\u200e\u200f"
    return character in "\t\n" or not (is_direction or unicodedata.category(character) in {"Cc", "Cs", "Zl", "Zp"})


def test_exactly_the_characters_that_unicode_calls_unsafe_are_escaped():
    escaped = {code for code in range(0x110000) if printable(chr(code)) != chr(code)}
    assert escaped == {code for code in range(0x110000) if not is_safe(chr(code))} | {0xFEFF}


@given(st.text(st.characters()))
def test_printable_text_is_safe_stays_as_it_is_and_can_be_encoded(text):
    shown = printable(text)
    assert all(is_safe(character) for character in shown)
    assert printable(shown) == shown
    shown.encode()


@pytest.mark.parametrize("before", ["", "\x1b[31m", "\t\x07", "\u202e", "\x9b", "x" * 300 + "\x1b"])
@pytest.mark.parametrize("word", ["Wall", "\x1b", "a\x00b"])
def test_carets_stand_under_the_escapes_of_a_word(before, word):
    line = f"{before}{word} after"
    finding = Finding("error", "code", f"found {word}", Location(1, len(before) + 1, len(word), "a\x1b.cga"), "\x1b")
    head, shown, carets, hint = finding.render([line]).split("\n")
    assert shown[carets.index("^") : carets.rindex("^") + 1] == printable(word)
    assert all(is_safe(character) for character in head + shown + carets + hint)
