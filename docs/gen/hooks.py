"""Hooks of mkdocs: documents of the repository become pages, and generated text is inserted into pages.

A comment `<!-- generated: NAME -->` or `<!-- generated: NAME ARGUMENT -->` is replaced by the text of one of
`GENERATORS`.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files
from mkdocs.structure.pages import Page

sys.path.insert(0, str(Path(__file__).parents[2]))

from docs.gen import api, cga, commands, documents, formats

GENERATORS: dict[str, Callable[..., str]] = {
    "api": api.sections,
    "cga": cga.tables,
    "commands": commands.overview,
    "formats": formats.table,
    "options": commands.options,
}
_PLACE = re.compile(r"^<!-- generated: (\w+)(?: ([^>]+))? -->$", re.MULTILINE)


def on_config(config: MkDocsConfig) -> MkDocsConfig:
    """Adds a page for each command and each README of a folder to the navigation."""
    for part in config.nav or []:
        if "Commands" in part:
            part["Commands"] += [{name: f"commands/{commands.page_of(name)}"} for name in commands.commands()]
        if "Project" in part:
            inside = [page for source, page in documents.pages().items() if source.endswith("/README.md")]
            part["Project"].append({"Inside": inside})
    return config


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Adds documents of the repository to the site, and a page for each command without one."""
    for source, page in documents.pages().items():
        files.append(File.generated(config, page, abs_src_path=str(documents.ROOT / source)))
    for name in commands.commands():
        page = f"commands/{commands.page_of(name)}"
        if page not in files.src_uris:
            files.append(File.generated(config, page, content=commands.page(name)))
    return files


def on_page_markdown(markdown: str, page: Page, **_: Any) -> str:
    """The text of a page with its generated parts, and with the links of the site."""
    filled = _PLACE.sub(lambda place: GENERATORS[place[1]](*filter(None, [place[2]])), markdown)
    pages = documents.pages()
    source = {there: here for here, there in pages.items()}.get(page.file.src_uri, f"docs/{page.file.src_uri}")
    return documents.linked(filled, source, page.file.src_uri, pages)
