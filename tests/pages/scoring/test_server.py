"""The page over HTTP and a WebSocket: who is served, and what."""

from __future__ import annotations

import asyncio
import io
import json
import socket
from collections.abc import Awaitable, Callable
from contextlib import closing, suppress
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import numpy as np
import pytest
from PIL import Image
from tornado.httpclient import AsyncHTTPClient, HTTPClientError, HTTPRequest, HTTPResponse
from tornado.websocket import WebSocketClientConnection, websocket_connect

from grammarlab.errors import UsageError
from grammarlab.learning.designs.addresses import Address
from grammarlab.pages.scoring.serving import serve, serving
from grammarlab.pages.scoring.session import Session
from tests.waiting import PATIENCE


class Page:
    """A page that was opened."""

    def __init__(self, address: str) -> None:
        self.address = address
        self.host = urlsplit(address).netloc
        self.query = urlsplit(address).query
        self.sockets: list[Socket] = []

    async def get(self, path: str, **headers: str) -> HTTPResponse:
        request = HTTPRequest(
            f"http://{self.host}{path}", headers=headers, connect_timeout=PATIENCE, request_timeout=PATIENCE
        )
        return await AsyncHTTPClient().fetch(request, raise_error=False)

    async def connect(self, query: str | None = None, **headers: str) -> Socket:
        address = f"ws://{self.host}/socket?{self.query if query is None else query}"
        request = HTTPRequest(address, headers={"Origin": f"http://{self.host}"} | headers, connect_timeout=PATIENCE)
        self.sockets.append(Socket(await websocket_connect(request)))
        return self.sockets[-1]

    async def leave(self) -> None:
        for window in self.sockets:
            window.connection.close()
            assert await window.is_closed()


class Socket:
    """A WebSocket that speaks the protocol."""

    def __init__(self, connection: WebSocketClientConnection) -> None:
        self.connection = connection
        self.ended = False

    async def send(self, message: dict[str, Any], *buffers: bytes) -> None:
        await self.connection.write_message(json.dumps(message | {"buffers": len(buffers)}))
        for buffer in buffers:
            await self.connection.write_message(buffer, binary=True)

    async def hear(self, fits: Callable[[dict[str, Any]], Any]) -> tuple[dict[str, Any], list[bytes]]:
        """The next message that fits."""
        while True:
            text = await asyncio.wait_for(self.connection.read_message(), PATIENCE)
            assert isinstance(text, str), "the connection was closed"
            message = json.loads(text)
            buffers = [await self.connection.read_message() for _ in range(message["buffers"])]
            assert all(isinstance(buffer, bytes) for buffer in buffers)
            if fits(message):
                return message, [buffer for buffer in buffers if isinstance(buffer, bytes)]

    async def is_closed(self) -> bool:
        """Whether the server ends the connection, sooner or later."""
        while not self.ended:
            self.ended = (await asyncio.wait_for(self.connection.read_message(), PATIENCE)) is None
        return True


def visit(path: Path, visitor: Callable[[Page], Awaitable[None]], jobs: int = 0) -> None:
    """Serves a session to a visitor."""

    async def main(session: Session) -> None:
        ready: asyncio.Future[str] = asyncio.get_running_loop().create_future()
        task = asyncio.create_task(serving(session, 0, ready.set_result))
        try:
            await asyncio.wait([task, ready], return_when=asyncio.FIRST_COMPLETED)
            if task.done():
                task.result()
            page = Page(await ready)
            await visitor(page)
            await page.leave()
        finally:
            task.cancel()
            with suppress(asyncio.CancelledError):
                await task

    with closing(Session("toy", path / "toy.db", size=100, jobs=jobs)) as session:
        asyncio.run(main(session))


def test_the_page_and_its_files_are_served_with_a_strict_policy(tmp_path: Path):
    async def visitor(page: Page) -> None:
        for path, kind in (("/", "text/html"), ("/page.js", "text/javascript"), ("/page.css", "text/css")):
            response = await page.get(f"{path}?{page.query}")
            assert response.code == 200
            assert response.headers["Content-Type"].startswith(kind)
            policy = response.headers["Content-Security-Policy"]
            assert "default-src 'none'" in policy
            assert "script-src 'self' blob:;" in policy
            assert "frame-ancestors 'none'" in policy
            assert response.headers["Cache-Control"] == "no-store"
            if path == "/":
                assert f'"page.js?{page.query}"'.encode() in response.body
                assert f'"page.css?{page.query}"'.encode() in response.body

    visit(tmp_path, visitor)


def test_nothing_is_served_without_the_token_or_under_another_host(tmp_path: Path):
    async def visitor(page: Page) -> None:
        wrong = "token=" + "A" * len(page.query.removeprefix("token="))
        for path in ("/", "/page.js", "/page.css", "/socket", "/nothing"):
            for query in ("", wrong, page.query[:-1], "token=%ff%c3", "token=é"):
                response = await page.get(f"{path}?{query.encode().decode('latin-1')}")
                assert response.code in (400, 403), (path, query)
                assert page.query.removeprefix("token=").encode() not in (response.body or b"")
            response = await page.get(f"{path}?{page.query}", Host="evil.example")
            assert response.code == 403
        port = page.host.rpartition(":")[2]
        assert (await page.get(f"/?{page.query}", Host=f"localhost:{port}")).code == 200

    visit(tmp_path, visitor)


def test_nothing_but_the_page_is_served(tmp_path: Path):
    async def visitor(page: Page) -> None:
        for path in ("/toy.db", "/page/page.js", "/../store.py", "/%2e%2e/store.py", "/viewer.js", "//etc/passwd"):
            assert (await page.get(f"{path}?{page.query}")).code == 404, path
        request = HTTPRequest(f"http://{page.host}/?{page.query}", method="POST", body="x")
        assert (await AsyncHTTPClient().fetch(request, raise_error=False)).code == 405

    visit(tmp_path, visitor)


def test_sockets_are_for_the_page_only(tmp_path: Path):
    async def visitor(page: Page) -> None:
        refused: list[tuple[str | None, dict[str, str]]] = [
            ("", {}),
            ("token=x", {}),
            (None, {"Origin": "http://evil.example"}),
            (None, {"Origin": "http://127.0.0.1:1"}),
            (None, {"Origin": "null"}),
            (None, {"Host": "evil.example", "Origin": "http://evil.example"}),
        ]
        for query, headers in refused:
            with pytest.raises(HTTPClientError, match="403"):
                await page.connect(query, **headers)

    visit(tmp_path, visitor)


def test_two_windows_score_and_agree(tmp_path: Path):
    async def visitor(page: Page) -> None:
        one, other = await page.connect(), await page.connect()
        state, _ = await one.hear(lambda message: message.get("event") == "state")
        model = state["state"]["grids"][0]["models"][0]
        await one.send({"id": 7, "command": "score", "models": [model], "score": 64})
        answer, _ = await one.hear(lambda message: message.get("id") == 7)
        assert answer["ok"]
        revision = answer["result"]["revision"]
        for window in (one, other):
            told, _ = await window.hear(
                lambda message: message.get("event") == "state" and message["state"]["revision"] == revision
            )
            assert told["state"]["models"][model]["score"] == 64.0

    visit(tmp_path, visitor)


def test_files_travel_as_buffers(tmp_path: Path):
    async def visitor(page: Page) -> None:
        window = await page.connect()
        state, _ = await window.hear(lambda message: message.get("event") == "state")
        models = state["state"]["grids"][0]["models"][:3]
        await window.send({"id": 1, "command": "score", "models": models, "score": 90})
        await window.send({"id": 2, "command": "export", "format": "parquet"})
        answer, (content,) = await window.hear(lambda message: message.get("id") == 2)
        assert answer["result"] == {"file": "toy.parquet"}
        await window.send({"id": 3, "command": "import", "format": "parquet"}, content)
        answer, _ = await window.hear(lambda message: message.get("id") == 3)
        assert answer["result"] == {"added": 3}
        await window.send({"id": 4, "command": "import", "format": "parquet"}, content, content)
        answer, _ = await window.hear(lambda message: message.get("id") == 4)
        assert "expected one label file" in answer["error"]

    visit(tmp_path, visitor)


@pytest.mark.parametrize(
    "frames",
    [
        ["not JSON"],
        ["[" * 200_000],
        [b"\0"],
        ['{"id": 1, "buffers": 1}', '{"id": 2}'],
        ['{"id": 1, "buffers": 5}'],
        ['{"id": 1, "buffers": -1}'],
        ['{"id": 1, "buffers": true}'],
    ],
    ids=lambda frames: str(frames)[:30],
)
def test_what_is_no_message_ends_the_connection_only(tmp_path: Path, frames: list[str | bytes]):
    async def visitor(page: Page) -> None:
        window, other = await page.connect(), await page.connect()
        for frame in frames:
            await window.connection.write_message(frame, binary=isinstance(frame, bytes))
        assert await window.is_closed()
        await other.send({"id": 1, "command": "state"})
        answer, _ = await other.hear(lambda message: message.get("id") == 1)
        assert answer["ok"]

    visit(tmp_path, visitor)


def test_pictures_come_as_sprite_sheets_and_models_as_glb(tmp_path: Path):
    async def visitor(page: Page) -> None:
        window = await page.connect()
        state, _ = await window.hear(lambda message: message.get("event") == "state")
        models = state["state"]["grids"][0]["models"][:7]
        await window.send({"id": 1, "command": "pictures", "models": models, "size": 48})
        times = dict.fromkeys(models, 0)
        while min(times.values()) < 2:  # quickly drawn, then well
            sheet, (content,) = await window.hear(lambda message: message.get("event") == "pictures")
            picture = np.asarray(Image.open(io.BytesIO(content)))
            assert picture.shape == (sheet["rows"] * 48, sheet["columns"] * 48, 3)
            assert sheet["columns"] * sheet["rows"] >= len(sheet["models"])
            assert (sheet["size"], sheet["width"], sheet["height"]) == (48, 48, 48)
            assert picture[:48, :48].std() > 5.0
            for model in sheet["models"]:
                times[model] += 1
        assert max(times.values()) == 2
        await window.send({"id": 2, "command": "pictures", "models": models[:2], "size": 48})
        sheet, _ = await window.hear(lambda message: message.get("event") == "pictures")
        assert sheet["models"] == models[:2]
        await window.send({"id": 3, "command": "model", "model": models[0]})
        answer, (glb,) = await window.hear(lambda message: message.get("id") == 3)
        assert glb.startswith(b"glTF")
        assert answer["result"]["label"] == f"model 0 of seed {Address.parse(models[0]).seed}"
        await window.send({"id": 4, "command": "viewer"})
        answer, viewer = await window.hear(lambda message: message.get("id") == 4)
        assert b"show" in viewer[0]

    visit(tmp_path, visitor, jobs=1)


def test_the_token_is_new_in_each_run_unless_it_is_given(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    seen: list[str] = []

    async def visitor(page: Page) -> None:
        seen.append(page.query)

    visit(tmp_path, visitor)
    visit(tmp_path, visitor)
    monkeypatch.setenv("GRAMMARLAB_TOKEN", "a-token_of-my-own")
    visit(tmp_path, visitor)
    monkeypatch.setenv("GRAMMARLAB_TOKEN", "short")
    with pytest.raises(UsageError, match="16 to 128"):
        visit(tmp_path, visitor)
    assert len(set(seen)) == 3
    assert min(map(len, seen[:2])) >= 32
    assert seen[2] == "token=a-token_of-my-own"


def test_a_port_in_use_is_told(tmp_path: Path):
    with (
        closing(Session("toy", tmp_path / "toy.db", size=100, jobs=0)) as session,
        socket.create_server(("127.0.0.1", 0)) as taken,
        pytest.raises(UsageError, match=r"cannot be used.*another one"),
    ):
        serve(session, taken.getsockname()[1], print)
