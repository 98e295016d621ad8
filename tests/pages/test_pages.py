"""Built pages are those of their sources, which lie in `pages_src/`."""

from __future__ import annotations

import hashlib
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
SOURCES = ROOT / "pages_src"
BUILT = sorted((ROOT / "grammarlab").glob("pages/static/*/*"))


@pytest.mark.parametrize("built", BUILT, ids=lambda built: str(built.relative_to(ROOT)))
def test_built_files_are_those_of_their_sources(built: Path):
    """Else: npm install && npm run build in pages_src/."""
    stated = re.match(r"/\* Built from ([\w, ]+) by \S+; do not edit. Source ([0-9a-f]{16}) ", built.read_text("utf-8"))
    assert stated
    sources = [each for folder in stated[1].split(", ") for each in sorted((SOURCES / folder).iterdir())]
    digest = hashlib.sha256(b"".join(each.read_bytes() for each in (*sources, SOURCES / "package.json")))
    assert stated[2] == digest.hexdigest()[:16]


def test_every_page_is_built():
    assert len(BUILT) == 2 * len(list(SOURCES.glob("*/main.js"))) + 1


def test_the_licence_of_what_is_bundled_is_kept():
    (viewer,) = (built for built in BUILT if built.name == "viewer.js")
    assert "SPDX-License-Identifier: MIT" in viewer.read_text(encoding="utf-8")
