"""Every code block of the README and of the guide runs as it stands there."""

import warnings
from pathlib import Path

import pytest

from docs.gen.blocks import blocks_of, run_page
from grammarlab.language.checking.check import check_text
from grammarlab.runs.sample.checks import SUPPORTED
from tests.cases import some

ROOT = Path(__file__).parents[2]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs" / "guide").glob("*.md")), ROOT / "docs" / "concepts.md"]
PAGES += sorted(page for folder in ("howto", "trees") for page in (ROOT / "docs" / folder).glob("*.md"))


@pytest.mark.parametrize("page", some(PAGES), ids=lambda page: page.relative_to(ROOT).as_posix())
def test_code_blocks_run_in_the_order_of_the_page(page, tmp_path, monkeypatch):
    # Starting processes takes longer.
    monkeypatch.setattr("grammarlab.runs.work.executor_choice.available_cores", lambda: 1)
    with warnings.catch_warnings(action="error"):
        run_page(page, tmp_path)


def test_the_grammars_on_the_pages_have_nothing_to_complain_about():
    grammars = [block for page in PAGES for block in blocks_of(page) if block.language == "cga"]
    assert grammars
    for block in grammars:
        assert check_text(block.text, str(block), SUPPORTED) == ()


def test_a_block_that_fails_is_reported(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    wrong = "```python\nassert False\n```\n\n```console\n$ grammarlab check nowhere.cga\n```\n\n```console\n"
    page = tmp_path / "page.md"
    page.write_text(wrong + "$ grammarlab list\nnothing\n```\n\n```zsh\nls\n```\n\n    indented code\n")
    blocks = blocks_of(page)
    assert len(blocks) == 5
    for block in blocks:
        with pytest.raises(AssertionError):
            block.run({})
