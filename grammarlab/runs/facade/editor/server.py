"""The page that edits a facade, over HTTP and a WebSocket."""

from __future__ import annotations

from pathlib import Path

from grammarlab import scoring
from grammarlab.runs.serving.server import PLAIN, Page

_FOLDER = Path(__file__).parent / "page"
# Buttons, menus and colours are those of the scoring page.
_SHARED = Path(str(scoring.__file__)).parent / "page"
PAGE = Page(
    index=PLAIN,
    files={"base.css": _SHARED / "page.css", "page.css": _FOLDER / "page.css", "page.js": _FOLDER / "page.js"},
    command="grammarlab facade open",
    max_bytes=64 << 10,
)
