"""The generated parts of the documentation: those in the repository are those that would be made today."""

import inspect
import re
from pathlib import Path
from typing import Any

import pytest
import typer

import grammarlab
from docs.gen import api, commands, docstrings, reference
from grammarlab.cli import app

DOCS = reference.DOCS


@pytest.fixture(scope="module")
def pages() -> dict[Path, str]:
    return reference.pages()


def called(group: Any, before: str = "") -> dict[str, Any]:
    """Commands of typer by name, as the command line runs them."""
    if not hasattr(group, "commands"):
        return {before.strip(): group}
    return {
        name: found for key, each in group.commands.items() for name, found in called(each, f"{before} {key}").items()
    }


def test_the_pages_are_as_they_would_be_made_today(pages: dict[Path, str]):
    names = {
        "api",
        "cga",
        "formats",
        "functions",
        "index",
        "operations",
        "parameters",
        "file",
        *(name.replace(" ", "-") for name in commands.commands()),
    }
    assert {path.stem for path in pages} == names
    old = [path for path in pages if not path.exists() or path.read_text(encoding="utf-8") != pages[path]]
    assert old == [], "run `make reference` and commit these pages"


def test_every_mark_of_a_generated_part_has_an_end_and_a_text():
    for path in DOCS.rglob("*.md"):
        text = path.read_text(encoding="utf-8")
        starts = re.findall(r"^<!-- generated: .*-->$", text, re.MULTILINE)
        assert len(starts) == text.count(reference.END), path
        assert not re.search(rf"<!-- generated: .*-->\s*{reference.END}", text), path


def test_parts_are_replaced_and_the_rest_is_kept():
    page = f"# Title\n\n<!-- generated: formats -->\nold\n{reference.END}\n\nrest\n"
    filled = reference.filled(page)
    assert "old" not in filled
    assert filled.startswith("# Title\n\n<!-- generated: formats -->\n\n| file | suffix | version |\n")
    assert filled.endswith(f"\n\n{reference.END}\n\nrest\n")
    assert reference.filled(filled) == filled


def test_the_tables_have_all_commands_with_their_options_and_help_texts():
    found = called(typer.main.get_command(app))
    assert list(commands.commands()) == list(found)
    for name, command in commands.commands().items():
        assert command.help == inspect.cleandoc(found[name].help)
        shown = [each for each in found[name].params if not getattr(each, "hidden", False)]
        options = [(*each.opts, *each.secondary_opts) for each in shown if each.opts[0].startswith("-")]
        assert [each.names for each in command.parameters if each.is_option] == options
        assert [each.help for each in command.parameters] == [each.help for each in shown]
        assert all(each.help for each in command.parameters)


@pytest.mark.parametrize("columns", ["40", "300"])
def test_the_tables_do_not_depend_on_the_terminal(columns: str, monkeypatch: pytest.MonkeyPatch):
    before = commands.options("facade read")
    monkeypatch.setenv("COLUMNS", columns)
    monkeypatch.setenv("FORCE_COLOR", "1")
    commands.commands.cache_clear()
    assert commands.options("facade read") == before


def test_a_signature_has_the_arguments_of_the_function(pages: dict[Path, str]):
    sections = re.split(r"^## ", pages[DOCS / "api.md"], flags=re.MULTILINE)
    for name in api.names():
        (section,) = (each for each in sections if each.startswith(f"`gl.{name}`\n"))
        value = getattr(grammarlab, name)
        if inspect.isfunction(value):
            assert all(re.search(rf"[(* ]{each}[:=,)]", section) for each in inspect.signature(value).parameters), name


def test_a_docstring_becomes_markdown():
    text = (
        "One.\n\nArgs:\n    first: the first\n        of two.\n    **rest: others.\n\nReturns:\n    A number.\n\n"
        ">>> 1 + 1\n2"
    )
    assert docstrings.markdown(text) == (
        "One.\n\n**Arguments**\n\n- `first`: the first of two.\n- `**rest`: others.\n\n**Returns**\n\nA number.\n\n"
        "```pycon\n>>> 1 + 1\n2\n```"
    )


def test_examples_of_docstrings_become_code():
    text = "One.\n\n    >>> 1 + 1\n    2\n    >>> 3\n    3\n\nTwo."
    code = "    ```pycon\n    >>> 1 + 1\n    2\n    >>> 3\n    3\n    ```"
    assert docstrings.fenced(text) == f"One.\n\n\n{code}\n\n\nTwo."
