"""A page of facades over HTTP, opened as a browser opens it."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager, suppress

from grammarlab.pages.server import Page as ServedPage
from grammarlab.pages.server import Served, serving
from tests.pages.scoring.test_server import Page


@asynccontextmanager
async def served(desk: Served, kind: ServedPage) -> AsyncIterator[Page]:
    """The page while it is served. Its files are there for those who know its address, and for nobody else."""
    ready: asyncio.Future[str] = asyncio.get_running_loop().create_future()
    task = asyncio.create_task(serving(desk, kind, 0, ready.set_result))
    try:
        page = Page(await ready)
        index = await page.get(f"/?{page.query}")
        for name in kind.files:
            assert f'"{name}?{page.query}"'.encode() in index.body
            assert (await page.get(f"/{name}?{page.query}")).code == 200
            assert (await page.get(f"/{name}")).code == 403
        yield page
        await page.leave()
    finally:
        task.cancel()
        with suppress(asyncio.CancelledError):
            await task
