"""Code blocks of a page, and how they are run.

- `console`: lines after `$ ` are commands of grammarlab; the lines below a command, if any, are its expected output,
  in which `...` matches any text.
- `python`: runs after the Python blocks above it on the page.
- a block with a `title`: a file of that name, for the blocks below.
- a block after a comment `<!-- not run: why -->` is not run; neither are `text` and `json` blocks.
"""

from __future__ import annotations

import contextlib
import doctest
import re
import shlex
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from markdown_it import MarkdownIt
from typer.testing import CliRunner

from grammarlab.cli.commands import app_for

SHOWN_ONLY = {"text", "json", ""}
_SKIP = re.compile(r"<!-- not run: \S.* -->\s*")
_TITLE = re.compile(r'title="([\w.-]+)"')
_OUTPUT = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE


@dataclass(frozen=True, slots=True)
class Block:
    """A code block that is run."""

    page: Path
    line: int
    language: str
    title: str
    """Name of the file; empty for code that runs."""
    text: str

    def run(self, names: dict[str, Any]) -> None:
        """Runs it in the current folder.

        Args:
            names: variables of the Python blocks so far; this block adds its own.
        """
        if self.title:
            Path(self.title).write_text(self.text, encoding="utf-8")
        elif self.language == "python":
            exec(compile("\n" * self.line + self.text, str(self.page), "exec"), names)  # noqa: S102 - our own pages
        else:
            advice = "use `console` or `python`, or put `<!-- not run: why -->` before the block"
            assert self.language == "console", f"{self}: unknown language '{self.language}'; {advice}"
            self._run_commands()

    def _run_commands(self) -> None:
        before, *commands = re.split(r"^\$ ", self.text, flags=re.MULTILINE)
        assert not before.strip(), f"{self}: expected commands after `$ `"
        assert commands, f"{self}: expected commands after `$ `"
        for command, _, expected in (each.replace("\\\n", " ").partition("\n") for each in commands):
            program, *arguments = shlex.split(command, comments=True)
            assert program == "grammarlab", f"{self}: {command}"
            result = CliRunner().invoke(app_for(arguments), arguments, catch_exceptions=False)
            assert result.exit_code == 0, f"{self}: {command}\n{result.output}"
            if expected.strip():
                assert doctest.OutputChecker().check_output(expected, result.output, _OUTPUT), (
                    f"{self}: {result.output}"
                )

    def __str__(self) -> str:
        return f"{self.page.name}:{self.line}"


def blocks_of(page: Path) -> tuple[Block, ...]:
    """The code blocks of a page that are run, in order."""
    found, skipped = [], False
    for token in MarkdownIt().parse(page.read_text(encoding="utf-8")):
        if token.type in ("fence", "code_block"):
            language, _, attributes = token.info.strip().partition(" ")
            title = _TITLE.search(attributes)
            if not skipped and (title or language not in SHOWN_ONLY or token.type == "code_block"):
                line = (token.map or [0])[0] + 1
                found.append(Block(page, line, language, title[1] if title else "", token.content))
        if token.level == 0:
            skipped = token.type == "html_block" and bool(_SKIP.fullmatch(token.content))
    return tuple(found)


def run_page(page: Path, folder: Path) -> None:
    """Runs the blocks of a page in a folder; blocks with titles become files there.

    Args:
        page: Markdown.
        folder: created if it is missing.
    """
    blocks, names = blocks_of(page), {}
    folder.mkdir(parents=True, exist_ok=True)
    with contextlib.chdir(folder):
        for block in blocks:
            block.run(names)


if __name__ == "__main__":
    run_page(Path(sys.argv[1]), Path(sys.argv[2]))
