"""Tables and lists of `show` in terminals of any width."""

import re
import textwrap
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st
from rich.cells import cell_len

from grammarlab.cli.fitted_table import wrapped

INDENTS = st.integers(0, 4).map(" ".__mul__)


@given(st.lists(st.text("ab-:;", min_size=1, max_size=12)), st.integers(1, 40), INDENTS)
def test_words_of_narrow_letters_are_wrapped_as_text_is(words, width, indent):
    by_letters = textwrap.TextWrapper(
        width, initial_indent=indent, subsequent_indent=indent, break_long_words=False, break_on_hyphens=False
    )
    text = " ".join(words)
    assert wrapped(text, width, indent) == by_letters.wrap(text)


PART = "[高さか。][\u0301\u3099]*|[ae\u0301\u3099]+"
"""A wide letter with its marks, or narrow ones."""


@given(st.text("a 高さ。e\u0301か\u3099"), st.integers(1, 40), INDENTS)
def test_wide_letters_fill_lines_by_their_cells_and_none_is_lost(text, width, indent):
    lines = wrapped(text, width, indent)
    assert "".join("".join(lines).split()) == "".join(text.split())
    assert all(line.startswith(indent) and line.strip() for line in lines)
    for line in lines:
        assert cell_len(line) <= width or re.fullmatch(PART, line.strip())
    for line, after in pairwise(lines):
        first = re.match(PART, after.strip())
        assert first
        assert cell_len(line) + 1 + cell_len(first[0]) > width


JAPANESE = "建物の高さをメートルで表した値です。屋根は含みません。"


@pytest.mark.parametrize("columns", [30, 40, 60, 80, 120])
def test_japanese_descriptions_are_no_wider_than_the_terminal(run, rules, monkeypatch, columns):
    monkeypatch.setenv("COLUMNS", str(columns))
    path = rules(f'@Description("{JAPANESE * 3}")\nattr {"h" * 26} = 3\nLot --> extrude(3) X')
    text = run("show", path).stdout
    assert max(map(cell_len, text.splitlines()[1:])) <= columns  # The first one is a path.
    letters = [letter for letter in text if letter in JAPANESE]
    assert letters == list(JAPANESE * 3)


@pytest.mark.parametrize("columns", [30, 200])
def test_words_between_colons_are_no_names_of_pictures(run, rules, monkeypatch, columns):
    monkeypatch.setenv("COLUMNS", str(columns))
    path = rules(f'@Description("ratio :car: wide, 1:b:2 [red]")\nattr {"h" * 36} = 3\nLot --> extrude(3) X')
    assert "ratio :car: wide, 1:b:2 [red]" in " ".join(run("show", path).stdout.split())


@pytest.mark.parametrize("name", ["toy", "oak"])
def test_no_columns_say_nothing_about_the_terminal(run, name, monkeypatch):
    monkeypatch.delenv("COLUMNS", raising=False)
    text = run("show", name).stdout
    monkeypatch.setenv("COLUMNS", "0")
    assert run("show", name).stdout == text


def test_every_width_has_every_word(run, rules, monkeypatch):
    path = rules(f'@Description("a{"b" * 40} c")\nattr {"h" * 9} = 3\nLot --> extrude(3) X')
    for columns in range(1, 12):
        monkeypatch.setenv("COLUMNS", str(columns))
        assert {f"a{'b' * 40}", "h" * 9, "Lot"} <= set(re.split(r"[\s;]+", run("show", path).stdout))
