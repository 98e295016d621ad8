"""The page that corrects an example, over HTTP and a WebSocket."""

from __future__ import annotations

from pathlib import Path

from grammarlab import scoring
from grammarlab.runs.serving.server import PLAIN, Page

_FOLDER = Path(__file__).parent / "page"
# Buttons, colours, the connection and elements are those of the scoring page.
_SHARED = Path(str(scoring.__file__)).parent / "page"
PAGE = Page(
    index=PLAIN,
    files={
        "base.css": _SHARED / "page.css",
        "page.css": _FOLDER / "page.css",
        "page.js": _FOLDER / "page.js",
        **{name: _SHARED / "source" / name for name in ("channel.js", "element.js", "transports.js")},
    },
    command="grammarlab facade open",
    max_bytes=64 << 10,
)
