"""The page over HTTP and a WebSocket: by the rules of the scoring page."""

from __future__ import annotations

import asyncio
import json
from contextlib import suppress

from grammarlab.runs.facade.editor.editor import Editor
from grammarlab.runs.facade.editor.server import PAGE
from grammarlab.runs.serving.server import serving
from tests.scoring.test_server import Page


async def visit(editor: Editor) -> None:
    ready: asyncio.Future[str] = asyncio.get_running_loop().create_future()
    task = asyncio.create_task(serving(editor, PAGE, 0, ready.set_result))
    try:
        page = Page(await ready)
        index = await page.get(f"/?{page.query}")
        for name in PAGE.files:
            assert f'"{name}?{page.query}"'.encode() in index.body
            assert (await page.get(f"/{name}?{page.query}")).code == 200
            assert (await page.get(f"/{name}")).code == 403
        assert b"grammarlab facade open" in (await page.get("/")).body
        window = await page.connect()
        state, (columns, boxes) = await window.hear(lambda message: message.get("event") == "state")
        assert len(columns) == 64 * len(state["state"]["leaves"])
        assert len(boxes) == 32 * len(state["state"]["parent"])
        await window.send({"id": 1, "command": "drag", "width": 9.0, "height": 5.0})
        answer, (boxes,) = await window.hear(lambda message: message.get("id") == 1)
        assert answer["ok"]
        await window.connection.write_message(json.dumps({"id": 2, "command": "x" * PAGE.max_bytes}))
        assert await window.is_closed()
        await page.leave()
    finally:
        task.cancel()
        with suppress(asyncio.CancelledError):
            await task


def test_the_page_is_served_to_those_who_know_its_address_and_large_messages_end_it(editor: Editor):
    asyncio.run(visit(editor))
