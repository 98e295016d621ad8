"""A kernel that is killed while it scores has lost nothing that the page was told is saved, and leaves no process."""

from __future__ import annotations

import os
import signal
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from queue import Empty
from typing import Any

from jupyter_client.blocking.client import BlockingKernelClient
from jupyter_client.manager import KernelManager
from jupyter_client.provisioning.local_provisioner import LocalProvisioner

from tests.pages.scoring.kills import MANY, Acknowledged
from tests.runs.processes import descendants, expect_gone
from tests.waiting import PATIENCE

KILLS = MANY // 4 or 2
UNDER_WAY = 8
QUIET = 1.0
"""Seconds after which nothing more comes from a kernel that was killed."""


class Widget:
    """A scoring widget in a kernel of its own, and the other end of its channel."""

    def __init__(self, client: BlockingKernelClient, process: int, session: Path) -> None:
        self._client, self.process = client, process
        client.execute(
            f"from grammarlab.notebook import ScoringSession\nsession = ScoringSession('toy', {str(session)!r}, jobs=1)"
        )
        self._channel = self._wait(_channel_of_widget)

    def ask(self, request: object) -> None:
        """Sends what the page would send."""
        content = {"comm_id": self._channel, "data": {"method": "custom", "content": request}}
        self._client.shell_channel.send(self._client.session.msg("comm_msg", content))

    def answer(self, patience: float = PATIENCE) -> dict[str, Any] | None:
        """The next answer; None when none comes."""
        try:
            return self._wait(self._answer_in, patience)
        except Empty:
            return None

    def _answer_in(self, message: dict[str, Any]) -> dict[str, Any] | None:
        content = message["content"]
        if message["msg_type"] != "comm_msg" or content["comm_id"] != self._channel:
            return None
        data = content["data"]
        return data["content"] if data["method"] == "custom" and "id" in data["content"] else None

    def _wait(self, find: Any, patience: float = PATIENCE) -> Any:
        while True:
            message = self._client.get_iopub_msg(timeout=patience)
            assert message["msg_type"] != "error", message["content"]
            if found := find(message):
                return found


def _channel_of_widget(message: dict[str, Any]) -> str | None:
    content = message["content"]
    is_widget = message["msg_type"] == "comm_open" and "_esm" in content["data"]["state"]
    return content["comm_id"] if is_widget else None


@contextmanager
def widget(session: Path) -> Iterator[Widget]:
    """A widget in a new kernel, which the test kills."""
    manager = KernelManager()
    manager.start_kernel(cwd=str(session.parent))
    client = manager.blocking_client()
    client.start_channels()
    client.wait_for_ready(PATIENCE)
    assert isinstance(manager.provisioner, LocalProvisioner)
    assert manager.provisioner.pid is not None
    yield Widget(client, manager.provisioner.pid, session)
    client.stop_channels()
    manager.shutdown_kernel(now=True)
    manager.cleanup_resources()


def test_nothing_acknowledged_to_the_page_is_lost_when_kernels_are_killed(tmp_path: Path, monkeypatch):
    monkeypatch.setenv("IPYTHONDIR", str(tmp_path / "ipython"))
    monkeypatch.setenv("JUPYTER_RUNTIME_DIR", str(tmp_path / "runtime"))
    scores = Acknowledged(tmp_path / "s.db")
    for kill in range(KILLS):
        with widget(scores.path) as page:
            for _ in range(UNDER_WAY):
                page.ask(scores.next())
            acknowledge(scores, page.answer())
            end = time.monotonic() + 0.0031 * (kill % 13)
            while time.monotonic() < end:
                page.ask(scores.next())
                acknowledge(scores, page.answer())
            workers = descendants(page.process)
            os.kill(page.process, signal.SIGKILL)
            while answer := page.answer(QUIET):
                acknowledge(scores, answer)
            assert workers
            expect_gone(workers)
        scores.check(UNDER_WAY)
    assert len(scores.saved) >= 2 * KILLS


def acknowledge(scores: Acknowledged, answer: dict[str, Any] | None) -> None:
    assert answer
    assert answer["ok"], answer
    scores.acknowledge(answer["id"], answer["result"]["revision"])
