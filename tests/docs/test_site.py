"""The site is built strictly, and nothing that it is made of is missing on it."""

import inspect
import logging
import re
import subprocess
import sys
from pathlib import Path

import pytest

import grammarlab
from docs.gen import api, cga, commands, documents, formats, hooks
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


def test_the_site_has_every_page_and_loads_nothing_from_elsewhere(site):
    pages = {path.relative_to(site).as_posix() for path in site.rglob("*.html")}
    assert {target.replace(".md", ".html") for target in documents.pages().values()} <= pages
    assert {f"commands/{commands.page_of(name)}".replace(".md", ".html") for name in COMMANDS} <= pages
    for page in pages:
        text = (site / page).read_text(encoding="utf-8")
        assert not re.findall(r'<(?:script|img|link)[^>]*(?:src|href)="https?:', text), f"{page} loads from elsewhere"


def test_a_quiet_build_counts_its_warnings():
    logger = logging.getLogger("mkdocs")
    before = logger.level
    try:
        logger.setLevel(logging.ERROR)
        hooks.on_startup()
        assert logger.level == logging.WARNING
    finally:
        logger.setLevel(before)


def test_every_public_name_is_on_the_site_with_its_documentation(site):
    page = (site / "api.html").read_text(encoding="utf-8")
    for name in api.names():
        assert f'id="{api.anchor(f"gl.{name}")}"' in page
        assert inspect.getdoc(getattr(grammarlab, name)), f"grammarlab.{name} is not documented"
    assert "Edited" in {each.__name__ for each in api.returned()}
    assert all(f'id="{api.anchor(each.__name__)}"' in page and inspect.getdoc(each) for each in api.returned())


def test_the_pages_name_no_option_that_does_not_exist():
    options = {
        name: {option for parameter in command.parameters for option in parameter.names}
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
    assert {name for name, _ in formats.VERSIONS.values()} <= set(formats.FILES)


def test_links_to_files_outside_the_site_become_their_paths():
    text = "[the map](../ARCHITECTURE.md#decisions) ![p](images/a.png) [rules](../grammars/toy.cga) [no](../none.md)"
    linked = documents.linked(text, "docs/guide.md", "guide.md", documents.pages())
    assert linked == (
        "[the map](project/ARCHITECTURE.md#decisions) ![p](images/a.png) rules (`grammars/toy.cga`) [no](../none.md)"
    )


@pytest.mark.parametrize(
    "system", ["grammars", "trees", "scoring", "learning", "evaluation", "facades", "layers", "synthesis", "matching"]
)
def test_each_system_has_a_folder_that_says_what_how_and_how_far(system):
    """What it is, how to use it, its files, its limits; the first page leads to all others."""
    folder = ROOT / "docs" / system
    pages = {path.name for path in folder.glob("*.md")}
    assert {"index.md", "how-to.md", "file.md", "limits.md"} <= pages
    first = (folder / "index.md").read_text(encoding="utf-8")
    assert all(f"]({page})" in first for page in pages - {"index.md"})
    assert f"](docs/{system}/index.md)" in (ROOT / "README.md").read_text(encoding="utf-8")
