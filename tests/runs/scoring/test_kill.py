"""A server that is killed at any moment has lost nothing that it said was saved, and leaves no process behind."""

from __future__ import annotations

import asyncio
import json
import signal
import subprocess
import sys
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager, suppress
from pathlib import Path
from urllib.parse import urlsplit

from tornado.websocket import WebSocketClientConnection, WebSocketClosedError, websocket_connect

from tests.runs.scoring.kills import MANY, Scores
from tests.runs.scoring.processes import descendants, expect_gone

KILLS = MANY * 3 // 4 or 6
UNDER_WAY = 8
"""Scores that are sent before the first of them is acknowledged."""
PATIENCE = 60.0


def served(path: Path) -> subprocess.Popen[str]:
    """``grammarlab score`` in a process of its own."""
    command = [str(Path(sys.executable).parent / "grammarlab"), "score", "toy", "--session", str(path), "--no-browser"]
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)


@asynccontextmanager
async def connected(server: subprocess.Popen[str]) -> AsyncIterator[WebSocketClientConnection]:
    """A window of a server, once that listens."""
    assert server.stdout is not None
    address = urlsplit(server.stdout.readline().strip())
    connection = await websocket_connect(f"ws://{address.netloc}/socket?{address.query}")
    yield connection
    connection.close()


async def hear(connection: WebSocketClientConnection) -> dict | None:
    """The next message, without its buffers; None at the end."""
    text = await asyncio.wait_for(connection.read_message(), PATIENCE)
    if text is None:
        return None
    message = json.loads(text)
    for _ in range(message["buffers"]):
        await connection.read_message()
    return message


async def score_and_kill(scores: Scores, server: subprocess.Popen[str], pause: float) -> None:
    """Scores over the socket as fast as it goes; the server is killed a moment after the first acknowledgement."""
    async with connected(server) as connection:
        for _ in range(UNDER_WAY):
            await connection.write_message(json.dumps(scores.next()))
        killed = False
        while message := await hear(connection):
            if "id" not in message:
                continue
            assert message["ok"], message
            scores.acknowledge(message["id"], message["result"]["revision"])
            if not killed:
                killed = True
                asyncio.get_running_loop().call_later(pause, server.kill)
            # Nothing hears it once the server is gone.
            with suppress(WebSocketClosedError):
                await connection.write_message(json.dumps(scores.next()))


def test_nothing_acknowledged_over_the_socket_is_lost_in_kills(tmp_path: Path):
    scores = Scores(tmp_path / "s.db")
    for kill in range(KILLS):
        with served(scores.path) as server:
            # Within the next few commits.
            asyncio.run(score_and_kill(scores, server, 0.0031 * (kill % 13)))
            assert server.wait(PATIENCE) == -signal.SIGKILL
        scores.check(UNDER_WAY)
    assert len(scores.saved) >= 2 * KILLS


async def kill_busy(server: subprocess.Popen[str]) -> set[int]:
    """Kills while pictures are drawn and an update begins; the processes that the server had started."""
    async with connected(server) as connection:
        first = await hear(connection)
        assert first is not None
        models = [model for grid in first["state"]["grids"] for model in grid["models"]]
        for request in (
            {"id": 1, "command": "score", "models": models, "score": 60},
            {"id": 2, "command": "update"},
            {"id": 3, "command": "pictures", "models": models, "size": 320},
        ):
            await connection.write_message(json.dumps(request))
        while (message := await hear(connection)) and message.get("event") != "pictures":
            pass
        assert message
        workers = descendants(server.pid)
        server.kill()
        while await hear(connection):
            pass
    return workers


def test_no_process_is_left_when_a_busy_server_is_killed(tmp_path: Path):
    with served(tmp_path / "s.db") as server:
        workers = asyncio.run(kill_busy(server))
    assert len(workers) >= 2
    expect_gone(workers)
