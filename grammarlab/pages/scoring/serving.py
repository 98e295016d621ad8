"""Server of the page of a scoring session, over HTTP and a WebSocket."""

from __future__ import annotations

from collections.abc import Callable

from grammarlab.pages import server
from grammarlab.pages.scoring.session import Session

PAGE = server.built_page("scoring", "grammarlab score", max_bytes=64 << 20)


def serve(session: Session, port: int, on_ready: Callable[[str], None]) -> None:
    """Serve a session until the process is interrupted; see `server.serve` for arguments and errors."""
    server.serve(session, PAGE, port, on_ready)


async def serving(session: Session, port: int, on_ready: Callable[[str], None]) -> None:
    """The same on a running event loop, until it is cancelled."""
    await server.serving(session, PAGE, port, on_ready)
