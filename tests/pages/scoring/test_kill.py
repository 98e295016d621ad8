"""A server that is killed at any moment has lost nothing that it said was saved, and leaves no process behind."""

from __future__ import annotations

import asyncio
import json
import signal
import subprocess
import sys
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager, closing, suppress
from pathlib import Path
from urllib.parse import urlsplit

from tornado.websocket import WebSocketClientConnection, WebSocketClosedError, websocket_connect

from grammarlab.pages.record.store import Store
from grammarlab.pages.scoring.knowledge import ModelPool
from grammarlab.pages.scoring.session import Session
from tests.pages.scoring.kills import MANY, Acknowledged
from tests.pages.scoring.rare import POSTS
from tests.pages.scoring.windows import Window, shown_models
from tests.runs.processes import descendants, expect_gone
from tests.waiting import PATIENCE

KILLS = MANY * 3 // 4 or 6
UNDER_WAY = 8
"""Scores that are sent before the first of them is acknowledged."""


def served(path: Path, grammar: str = "toy") -> subprocess.Popen[str]:
    """``grammarlab score`` in a process of its own."""
    grammarlab = str(Path(sys.executable).parent / "grammarlab")
    command = [grammarlab, "score", grammar, "--session", str(path), "--no-browser"]
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)


@asynccontextmanager
async def connected(server: subprocess.Popen[str]) -> AsyncIterator[WebSocketClientConnection]:
    """A window of a server, once that listens."""
    assert server.stdout is not None
    address = urlsplit(server.stdout.readline().strip())
    connection = await websocket_connect(f"ws://{address.netloc}/socket?{address.query}", connect_timeout=PATIENCE)
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


async def score_and_kill(scores: Acknowledged, server: subprocess.Popen[str], pause: float) -> None:
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
    scores = Acknowledged(tmp_path / "s.db")
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


async def update_and_kill(server: subprocess.Popen[str], is_time: Callable[[dict], bool]) -> None:
    """Kills once something is said during an update."""
    async with connected(server) as connection:
        await connection.write_message(json.dumps({"id": 1, "command": "update"}))
        while (message := await hear(connection)) and not is_time(message):
            pass
        assert message
        server.kill()
        while await hear(connection):
            pass


def of_stage(beginning: str) -> Callable[[dict], bool]:
    return lambda message: message.get("event") == "progress" and message["stage"].startswith(beginning)


def has_learned(message: dict) -> bool:
    return message.get("event") == "state" and bool(message["state"]["chart"])


def test_a_server_that_is_killed_while_or_after_the_pool_is_widened_shows_what_another_one_shows(tmp_path: Path):
    path, rules, size = tmp_path / "s.db", tmp_path / "posts.cga", 250
    rules.write_text(POSTS)
    with closing(Session(str(rules), path, size=size, jobs=0)) as session:
        session.call("score", models=list(ModelPool(0, size).names[:70]), score=0)
    (tmp_path / "twin.db").write_bytes(path.read_bytes())
    widening = of_stage(f"making {len(ModelPool(0, size, wide=True).names)} models")
    wide = False
    for is_time in (widening, of_stage("choosing"), has_learned):
        if wide:  # on a busy machine an update may end before it can be killed
            break
        with served(path, str(rules)) as server:
            asyncio.run(update_and_kill(server, is_time))
        with closing(Store.open(path)) as store:
            wide = store.record.wide
    assert wide
    with closing(Session(str(rules), tmp_path / "twin.db", jobs=0)) as twin:
        window = Window(twin)
        twin.call("update")
        unharmed = window.state(lambda state: state["chart"] and not state["updating"])
    with closing(Session(str(rules), path, jobs=0)) as session:
        found, _ = session.call("state")
    assert (found["grids"], found["chart"]) == (unharmed["grids"], unharmed["chart"])
    assert any(model not in ModelPool(0, size).index for model in shown_models(found))
