"""The page that corrects an example, over HTTP and a WebSocket."""

from __future__ import annotations

from grammarlab.runs.serving.server import built_page

PAGE = built_page(__file__, "grammarlab facade open", max_bytes=64 << 10)
