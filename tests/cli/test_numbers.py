"""Numbers of options."""

from collections.abc import Iterator
from typing import Any

import pytest
from typer.main import get_command

from grammarlab.cli import app
from grammarlab.cli.numbers import PlainNumbers
from tests.cli.commands import COMMANDS

LONG = "9" * 5_000


@pytest.mark.parametrize("text", ["1_000", "1_0", "٣", "９", LONG, "1e999", "nan"])
@pytest.mark.parametrize("option", ["--model", "--seed"])
def test_numbers_that_only_python_reads_are_refused(run, option, text):
    result = run("show", "toy", "--model", "0", option, text, code=2)
    assert option in result.stderr
    assert len(result.stderr) < 1_000


@pytest.mark.parametrize("text", ["1_0", "٣", LONG, "nan", "inf", "1e-320", "1e308", "-1"])
def test_sizes_that_only_python_reads_are_refused(run, tmp_path, text):
    (tmp_path / "a.csv").write_text("label,left,bottom,right,top\nwindow,1,1,2,3\n")
    result = run("facade", "read", tmp_path / "a.csv", "-o", tmp_path / "a.json", "--width", text, code=2)
    assert "--width" in result.stderr
    assert not (tmp_path / "a.json").exists()


def commands_of(group: Any) -> Iterator[Any]:
    for command in group.commands.values():
        yield from commands_of(command) if hasattr(command, "commands") else [command]


def test_every_command_refuses_such_numbers():
    commands = list(commands_of(get_command(app)))
    assert len(commands) == len(COMMANDS)
    assert [command.name for command in commands if not isinstance(command, PlainNumbers)] == []
