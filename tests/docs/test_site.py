"""The site is built strictly, and nothing that it is made of is missing on it."""

import inspect
import re
import subprocess
import sys
from pathlib import Path

import pytest

import grammarlab
from docs.gen import api, cga, commands, doctests, documents, formats
from grammarlab.language.checking.check import check_text
from grammarlab.language.syntax.builtins import attributes, blocks, functions, operations
from grammarlab.runs.sample.checks import SUPPORTED
from tests.cli.commands import COMMANDS

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    """The folder of the site; warnings of the build fail the test."""
    folder = tmp_path_factory.mktemp("site")
    command = [sys.executable, "-m", "mkdocs", "--quiet", "build", "--site-dir", str(folder)]
    built = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert built.returncode == 0, built.stderr
    return folder


def test_the_site_has_every_page_and_every_place_is_filled_in(site):
    pages = {path.relative_to(site).as_posix() for path in site.rglob("*.html")}
    assert {target.replace(".md", ".html") for target in documents.pages().values()} <= pages
    assert {f"commands/{commands.page_of(name)}".replace(".md", ".html") for name in COMMANDS} <= pages
    for page in pages:
        text = (site / page).read_text(encoding="utf-8")
        assert "generated:" not in re.sub(r"<pre>.*?</pre>", "", text, flags=re.DOTALL), page
        assert not re.findall(r'<(?:script|img|link)[^>]*(?:src|href)="https?:', text), f"{page} loads from elsewhere"


def test_every_public_name_is_on_the_site_with_its_documentation(site):
    page = (site / "api.html").read_text(encoding="utf-8")
    for name in api.names():
        value = getattr(grammarlab, name)
        assert f'id="{name}"' in page
        assert inspect.getdoc(value), f"grammarlab.{name} is not documented"
    assert "Edited" in {each.__name__ for each in api.returned()}
    assert all(f'id="{each.__name__}"' in page and inspect.getdoc(each) for each in api.returned())


@pytest.mark.parametrize("name", COMMANDS)
def test_the_page_of_a_command_has_every_option_with_a_help_text(site, name):
    page = (site / "commands" / commands.page_of(name)).with_suffix(".html").read_text(encoding="utf-8")
    (command,) = (each for given, each in commands.commands().items() if given == name)
    for parameter in command.params:
        assert parameter.help, parameter.name
        for option in (*parameter.opts, *parameter.secondary_opts):
            assert f"<code>{option}</code>" in page or parameter.param_type_name == "argument", option


def test_the_pages_name_no_option_that_does_not_exist():
    options = {
        name: {option for parameter in command.params for option in (*parameter.opts, *parameter.secondary_opts)}
        for name, command in commands.commands().items()
    }
    pages = [ROOT / "README.md", *(ROOT / "docs").glob("**/*.md")]
    for page in pages:
        for line in re.findall(r"grammarlab ([a-z][^`\n|]*)", page.read_text(encoding="utf-8")):
            name = max((each for each in options if f"{line} ".startswith(f"{each} ")), key=len, default=None)
            if name is not None:
                unknown = set(re.findall(r"(?<!\S)--[a-z][a-z-]*", line)) - options[name] - {"--help"}
                assert not unknown, f"{page.name}: grammarlab {line}"


def test_the_table_of_cga_has_every_word_and_says_what_the_checker_says():
    page = cga.tables()
    for told in (cga.operations(), cga.functions(), cga.attributes()):
        assert all(f"| `{name}` |" in page for name in told)
    assert set(cga.operations()) == {*operations(), *blocks()}
    assert set(cga.functions()) == set(functions())
    assert set(cga.attributes()) == set(attributes())
    for name, told in cga.attributes().items():
        found = {each.severity for each in check_text(f"Lot --> print({name}) extrude(1) A.", "", SUPPORTED)}
        assert ("unsupported" in found) == (told == cga.NO), name


def test_the_page_of_files_has_every_format_with_a_version():
    """A version is a constant called FORMAT or VERSION, or the steps of a database."""
    versioned = re.compile(r"^(?:FORMAT, )?(?:VERSION|FORMAT) = .*\d$|^STEPS = \($", re.MULTILINE)
    modules = {
        path.relative_to(ROOT).with_suffix("").as_posix().replace("/", ".")
        for path in (ROOT / "grammarlab").glob("**/*.py")
        if versioned.search(path.read_text(encoding="utf-8"))
    }
    assert modules == set(formats.VERSIONS)


def test_examples_of_docstrings_become_code():
    text = "One.\n\n    >>> 1 + 1\n    2\n    >>> 3\n    3\n\nTwo."
    code = "    ```pycon\n    >>> 1 + 1\n    2\n    >>> 3\n    3\n    ```"
    assert doctests.fenced(text) == f"One.\n\n\n{code}\n\n\nTwo."


def test_links_to_files_outside_the_site_become_their_paths():
    text = "[the map](../ARCHITECTURE.md#decisions) ![p](images/a.png) [rules](../grammars/toy.cga) [no](../none.md)"
    linked = documents.linked(text, "docs/guide.md", "guide.md", documents.pages())
    assert linked == (
        "[the map](project/ARCHITECTURE.md#decisions) ![p](images/a.png) rules (`grammars/toy.cga`) [no](../none.md)"
    )
