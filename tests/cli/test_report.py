"""What the command line prints of files from strangers."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

import grammarlab as gl
from grammarlab.option_names import with_options

ESCAPE = "\x1b]0;title changed\x07 \x1b[31m"


@pytest.mark.parametrize("options", [[], ["--json"]])
def test_check_shows_escape_sequences_of_a_file_as_text(run, rules, options):
    result = run("check", rules(f"Lot --> {ESCAPE} X("), *options, code=1)
    assert not {"\x1b", "\x07"} & set(result.stdout + result.stderr)


def test_show_prints_escape_sequences_and_markup_of_a_file_as_text(run, rules):
    path = rules(f'@Description("{ESCAPE} [/red]")\nattr a = 3\nLot --> Wall')
    result = run("show", path.rename(path.with_name("[bold]a.cga")))
    assert "\x1b" not in result.stdout
    assert "[bold]a.cga" in result.stdout.replace("\n", "")


def test_a_formatted_file_keeps_its_characters_where_a_program_reads_it(run, rules):
    result = run("format", rules(f"// {ESCAPE}\nLot --> Wall\n"))
    assert "\x1b]0;title changed" in result.stdout


def test_a_terminal_without_every_character_still_gets_all_messages(rules):
    command = [sys.executable, "-m", "grammarlab", "check", os.fspath(rules("Lot --> “x”("))]
    result = subprocess.run(
        command, env={**os.environ, "PYTHONIOENCODING": "latin-1"}, capture_output=True, check=False
    )
    assert result.returncode == 1
    assert b"Traceback" not in result.stderr
    assert b"'\\u201c'" in result.stdout


@pytest.mark.parametrize(
    ("message", "shown"),
    [
        ("nothing to do: give `width=`, `rows=`.", "nothing to do: give --width, --rows."),
        ("the millimetre (`unit='mm'`)", "the millimetre (--unit mm)"),
        ("leave `stored_grammar=True` out", "leave --stored-grammar out"),
        ("(`jobs=1`, `workers=1`)", "(--jobs 1, --workers 1)"),
        ("the rule `Lot-->` and `weight=3` of `width`", "the rule `Lot-->` and `weight=3` of `width`"),
    ],
)
def test_arguments_are_shown_as_options(message: str, shown: str) -> None:
    assert with_options(message) == shown


def test_the_library_names_arguments_and_the_command_line_options(run, tmp_path) -> None:
    facade = gl.load_facade(gl.examples_folder() / "facades" / "arcade.json")
    with pytest.raises(gl.GrammarlabError, match="give `width=`, `height=`, `columns=` or `rows=`"):
        gl.edit_facade(facade)
    told = run("facade", "edit", gl.save_facade(facade, tmp_path / "arcade.json"), "-o", tmp_path / "out", code=2)
    assert "give --width, --height, --columns or --rows." in told.stderr
