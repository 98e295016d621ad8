"""Hooks of mkdocs: documents of the repository become pages, with links that work on the site."""

from __future__ import annotations

import logging
import sys
from pathlib import Path
from typing import Any

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files
from mkdocs.structure.pages import Page

sys.path.insert(0, str(Path(__file__).parents[2]))

from docs.gen import documents


def on_startup(**_: Any) -> None:
    """Warnings fail a strict build with `--quiet` as well, which otherwise drops them before they are counted."""
    logger = logging.getLogger("mkdocs")
    logger.setLevel(min(logger.level, logging.WARNING))


def on_config(config: MkDocsConfig) -> MkDocsConfig:
    """Adds each README of a folder to the navigation."""
    for part in config.nav or []:
        if "Project" in part:
            inside = [page for source, page in documents.pages().items() if source.endswith("/README.md")]
            part["Project"].append({"Inside": inside})
    return config


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Adds documents of the repository to the site."""
    for source, page in documents.pages().items():
        files.append(File.generated(config, page, abs_src_path=str(documents.ROOT / source)))
    return files


def on_page_markdown(markdown: str, page: Page, **_: Any) -> str:
    """The text of a page with the links of the site."""
    pages = documents.pages()
    source = {there: here for here, there in pages.items()}.get(page.file.src_uri, f"docs/{page.file.src_uri}")
    return documents.linked(markdown, source, page.file.src_uri, pages)
