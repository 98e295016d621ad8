"""The page over HTTP and a WebSocket: by the rules of the scoring page."""

from __future__ import annotations

import asyncio
import json

from grammarlab.pages.editor.editor import PAGE, Editor
from tests.runs.facade.served import served


async def visit(editor: Editor) -> None:
    async with served(editor, PAGE) as page:
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


def test_the_page_is_served_to_those_who_know_its_address_and_large_messages_end_it(editor: Editor):
    asyncio.run(visit(editor))
