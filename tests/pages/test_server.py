"""Clients that stop halfway, do not read, or ask for too much: they end, and the server goes on."""

from __future__ import annotations

import asyncio
import gc
import json
import os
import signal
import socket
import struct
import sys
from collections.abc import Awaitable, Callable, Sequence
from contextlib import suppress
from dataclasses import replace
from urllib.parse import urlsplit

import pytest

from grammarlab.pages import server
from grammarlab.pages.scoring.serving import PAGE
from grammarlab.pages.server import Page, serving
from grammarlab.pages.windows import Send
from tests.pages.scoring.test_server import Page as Visited
from tests.waiting import PATIENCE

IMPATIENT = replace(PAGE, patience=0.2)


class Echo:
    """Answers every request with as many bytes as it asks for."""

    def __init__(self) -> None:
        self.windows: list[Send] = []

    def handle(self, message: object, buffers: Sequence[bytes], send: Send) -> None:
        assert isinstance(message, dict)
        if message.get("silent"):
            return
        if message.get("refuse"):
            send({"id": message.get("id"), "ok": False, "error": message["refuse"]}, ())
            return
        send({"id": message.get("id"), "ok": True, "result": "x" * message.get("size", 1)}, buffers)

    def listen(self, send: Send) -> Callable[[], None]:
        self.windows.append(send)
        send({"event": "state"}, ())
        return lambda: self.windows.remove(send)


def visit(page: Page, visitor: Callable[[Visited, Echo], Awaitable[None]]) -> None:
    async def main() -> None:
        ready: asyncio.Future[str] = asyncio.get_running_loop().create_future()
        echo = Echo()
        task = asyncio.create_task(serving(echo, page, 0, ready.set_result))
        try:
            visited = Visited(await ready)
            await visitor(visited, echo)
            await expect_answer(visited)
            await visited.leave()
        finally:
            task.cancel()
            with suppress(asyncio.CancelledError):
                await task

    asyncio.run(main())


async def expect_answer(page: Visited) -> None:
    window = await page.connect()
    await window.send({"id": "last"})
    await window.hear(lambda message: message.get("id") == "last")


async def raw(page: Visited, data: bytes) -> tuple[asyncio.StreamReader, asyncio.StreamWriter]:
    host, _, port = page.host.partition(":")
    reader, writer = await asyncio.open_connection(host, int(port))
    writer.write(data)
    return reader, writer


def handshake(page: Visited) -> bytes:
    return (
        f"GET /socket?{page.query} HTTP/1.1\r\nHost: {page.host}\r\nOrigin: http://{page.host}\r\n"
        "Connection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\n"
        "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n"
    ).encode()


def frame(text: bytes) -> bytes:
    """A masked text frame."""
    return struct.pack("!BBH4x", 0x81, 0x80 | 126, len(text)) + text


@pytest.mark.parametrize(
    "start",
    [
        b"",
        b"GET / HT",
        b"GET / HTTP/1.1\r\nHost: localhost\r\n",
        b"POST / HTTP/1.1\r\nHost: localhost\r\nContent-Length: 10\r\n\r\nhalf",
    ],
)
def test_a_request_that_stops_halfway_is_closed(start: bytes, capfd: pytest.CaptureFixture[str]):
    async def visitor(page: Visited, _echo: Echo) -> None:
        reader, writer = await raw(page, start)
        await asyncio.wait_for(reader.read(), PATIENCE)
        writer.close()

    visit(IMPATIENT, visitor)
    assert "Traceback" not in capfd.readouterr().err


def test_windows_that_do_not_answer_or_do_not_read_are_closed(
    monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
):
    monkeypatch.setattr(server, "MAX_UNSENT", 1 << 20)

    async def visitor(page: Visited, echo: Echo) -> None:
        starts = (b"", b"\x81", frame(b"{}" * 200)[:50])
        silent = [await raw(page, handshake(page) + start) for start in starts]
        while len(echo.windows) < len(starts):
            await asyncio.sleep(0)
        for _ in range(200):  # 20 MB, more than the system keeps for a connection
            echo.windows[0]({"event": "state", "state": "x" * 100_000}, ())
            await asyncio.sleep(0)
        await asyncio.gather(*(asyncio.wait_for(reader.read(), PATIENCE) for reader, _ in silent[1:]))
        while echo.windows:
            await asyncio.sleep(0.01)
        for _, writer in silent:
            writer.close()

    visit(IMPATIENT, visitor)
    assert capfd.readouterr().err == ""


def test_windows_that_vanish_amid_a_flood_leave_no_traceback(capfd: pytest.CaptureFixture[str]):
    async def visitor(page: Visited, echo: Echo) -> None:
        for _ in range(5):
            _, writer = await raw(page, handshake(page) + 50 * frame(json.dumps({"id": 1, "size": 100_000}).encode()))
            while not echo.windows:
                await asyncio.sleep(0)
            for _ in range(200):
                echo.windows[0]({"event": "state", "state": "x" * 10_000}, (b"y" * 10_000,))
            await asyncio.sleep(0.01)
            # The connection is reset, not closed in an orderly way.
            writer.get_extra_info("socket").setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
            writer.transport.abort()
            while echo.windows:
                await asyncio.sleep(0.01)
        gc.collect()  # a task whose exception nobody retrieved reports it when it is collected

    visit(PAGE, visitor)
    assert capfd.readouterr().err == ""


def test_requests_beyond_a_number_wait_until_others_are_answered(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(server, "MAX_UNANSWERED", 3)

    async def visitor(page: Visited, _echo: Echo) -> None:
        window = await page.connect()
        for number in range(100):
            await window.send({"id": number})
        await window.hear(lambda message: message.get("id") == 99)
        # One that is never answered does not stop the page for ever.
        for _ in range(4):
            await window.send({"silent": True})
        assert await window.is_closed()

    visit(IMPATIENT, visitor)


def test_refusals_name_options():
    async def visitor(page: Visited, _echo: Echo) -> None:
        window = await page.connect()
        await window.send({"id": 1, "refuse": "give `stored_grammar=True`, or `oak`"})
        answer, _ = await window.hear(lambda message: message.get("id") == 1)
        assert answer["error"] == "give --stored-grammar, or `oak`"

    visit(PAGE, visitor)


def test_connections_beyond_a_number_are_closed_at_once(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(server, "MAX_CONNECTIONS", 4)

    async def visitor(page: Visited, _echo: Echo) -> None:
        opened = [await raw(page, b"GET") for _ in range(4)]
        reader, writer = await raw(page, b"")
        assert await asyncio.wait_for(reader.read(), PATIENCE) == b""
        for _, other in [*opened, (reader, writer)]:
            other.close()
        while (await page.get(f"/?{page.query}")).code != 200:
            await asyncio.sleep(0.01)

    visit(PAGE, visitor)


def test_a_bug_is_reported_without_the_token(monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]):
    async def visitor(page: Visited, _echo: Echo) -> None:
        monkeypatch.setattr(server, "_INDEX", None)
        assert (await page.get(f"/?{page.query}")).code == 500
        token = urlsplit(page.address).query.partition("=")[2]
        reported = capfd.readouterr().err
        assert "AttributeError" in reported
        assert token not in reported

    visit(PAGE, visitor)


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no such signals")
@pytest.mark.parametrize("name", ["SIGTERM", "SIGHUP", "SIGINT"])
def test_a_server_that_is_ended_from_outside_ends_as_with_ctrl_c(name: str):
    number = signal.Signals[name]
    usual = signal.default_int_handler if name == "SIGINT" else signal.SIG_DFL
    before = signal.signal(number, usual)  # it may be ignored: by nohup, or in the background of a script
    try:
        with pytest.raises(KeyboardInterrupt):
            server.serve(Echo(), PAGE, 0, lambda _: os.kill(os.getpid(), number))
        assert signal.getsignal(number) is usual
    finally:
        signal.signal(number, before)
