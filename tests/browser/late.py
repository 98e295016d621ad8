"""Pages that hear late of what the server says."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from playwright.sync_api import Page

LATE = """
window.late = null;
window.punctual = 0;
window.hear = () => { const waiting = late; late = null; for (const message of waiting) message(); };
window.WebSocket = class extends WebSocket {
  set onmessage(listener) {
    super.onmessage = (event) => (late && punctual-- <= 0 ? late.push(() => listener(event)) : listener(event));
  }
};
"""
"""Script of every window: while `late` is a list, what the server says waits in it, less the next `punctual` messages;
`hear` tells it all."""
FROM_THE_FIRST_STATE = "late = []; punctual = 1;"
"""Script after `LATE`: a page of one text frame per state is built, and hears no more until `hear`."""


@contextmanager
def deaf(page: Page) -> Iterator[None]:
    """A time during which the page does not hear what the server says."""
    page.evaluate("void (late = [])")
    yield
    page.evaluate("hear()")
