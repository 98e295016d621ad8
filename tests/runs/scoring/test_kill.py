"""A server that is killed at any moment has lost nothing that it said was saved."""

from __future__ import annotations

import multiprocessing
import os
import signal
import struct
import time
from collections.abc import Sequence
from contextlib import closing, suppress
from multiprocessing.connection import Connection
from pathlib import Path

from grammarlab.runs.scoring.server import serve
from grammarlab.runs.scoring.session import Session
from grammarlab.runs.scoring.store import Store

KILLS = 40


def scripted(path: Path, first: int, acknowledged: Connection) -> None:
    """A server with a window that scores without end, and says on a pipe what it was told is saved."""
    session = Session("toy", path, size=100, jobs=0)

    def on_ready(_address: str) -> None:
        number = first

        def send(message: dict, _buffers: Sequence[bytes]) -> None:
            nonlocal number
            if "id" not in message:
                return
            assert message["ok"], message
            acknowledged.send_bytes(struct.pack("<2I", message["id"], message["result"]["revision"]))
            number += 1
            ask(number)

        def ask(number: int) -> None:
            models = [f"g7-{number}", f"g7-{number + 1_000_000}"]
            session.handle({"id": number, "command": "score", "models": models, "score": number % 101}, (), send)

        ask(number)

    serve(session, 0, on_ready)


def test_nothing_acknowledged_is_lost_in_forty_kills(tmp_path: Path):
    # Forked from a process that has loaded everything, since the test is not about loading Python forty times.
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload(["__main__", __name__])
    path = tmp_path / "s.db"
    expected: dict[str, float] = {}
    for kill in range(KILLS):
        here, there = context.Pipe(duplex=False)
        process = context.Process(target=scripted, args=(path, kill * 10_000, there))
        process.start()
        there.close()
        acknowledged = [here.recv_bytes()]
        # Somewhere within the next few commits.
        time.sleep(0.0007 * (kill % 13))
        assert process.pid is not None
        os.kill(process.pid, signal.SIGKILL)
        with suppress(EOFError):
            while True:
                acknowledged.append(here.recv_bytes())
        here.close()
        process.join()
        revisions = [0]
        for number, revision in map(struct.Struct("<2I").unpack, acknowledged):
            expected |= {f"g7-{number}": number % 101, f"g7-{number + 1_000_000}": number % 101}
            revisions.append(revision)
        with closing(Store.open(path)) as store:
            scores = store.record.factors["overall"]
            assert store.record.revision >= max(revisions)
            assert {model: scores.get(model) for model in expected} == expected
            # At most the one score that was being saved is there beyond what was acknowledged.
            assert len(scores) <= len(expected) + 2
            expected = dict(scores)
    assert len(expected) >= 2 * KILLS
