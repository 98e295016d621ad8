"""A page served from a thread of this process, which is there sooner than a process of its own."""

from __future__ import annotations

import asyncio
from concurrent.futures import Future
from contextlib import suppress
from threading import Thread
from typing import Protocol

from grammarlab.pages.server import Page, Served, serving


class Closable(Served, Protocol):
    """What a page is about, until it is closed."""

    def close(self) -> None: ...


class PageThread:
    """Serves until it is closed, and then closes what it served."""

    def __init__(self, served: Closable, page: Page) -> None:
        self._served = served
        self._loop = asyncio.new_event_loop()
        address: Future[str] = Future()
        self._task = self._loop.create_task(serving(served, page, 0, address.set_result))
        self._thread = Thread(target=self._run)
        self._thread.start()
        self.address = address.result()

    def _run(self) -> None:
        with suppress(asyncio.CancelledError):
            self._loop.run_until_complete(self._task)

    def close(self) -> None:
        self._loop.call_soon_threadsafe(self._task.cancel)
        self._thread.join()
        self._loop.close()
        self._served.close()
