"""A window that remembers what an editor told it."""

from __future__ import annotations

import json
from collections.abc import Sequence
from concurrent.futures import Future
from typing import Any

import numpy as np

from grammarlab.pages.desktop import Desktop
from grammarlab.pages.windows import Message
from tests.waiting import PATIENCE


class RefusedError(Exception):
    """What the editor would not do, and why."""


class Window:
    """Talks to an editor as a page does."""

    def __init__(self, editor: Desktop[Any]) -> None:
        self._editor = editor
        self._waiting: dict[int, Future[tuple[Message, Sequence[bytes]]]] = {}
        self.states: list[tuple[dict[str, Any], Sequence[bytes]]] = []
        self.close = editor.listen(self.send)

    def send(self, message: Message, buffers: Sequence[bytes]) -> None:
        json.dumps(message, allow_nan=False)
        if message.get("event") == "state":
            self.states.append((message["state"], buffers))
        elif "event" not in message:
            self._waiting.pop(message["id"]).set_result((message, buffers))

    def begin(self, command: object, **values: Any) -> Future[tuple[Message, Sequence[bytes]]]:
        """Sends a request; the answer comes later."""
        number = len(self._waiting) + 1
        self._waiting[number] = answered = Future[tuple[Message, Sequence[bytes]]]()
        self._editor.handle({"id": number, "command": command, **values}, (), self.send)
        return answered

    def ask(self, command: object, **values: Any) -> tuple[dict[str, Any], Sequence[bytes]]:
        message, buffers = self.begin(command, **values).result(PATIENCE)
        if not message["ok"]:
            raise RefusedError(message["error"])
        return message["result"], buffers

    @property
    def state(self) -> dict[str, Any]:
        """The last one; what was asked for before has been done."""
        self.ask("skip")
        return self.states[-1][0]

    @property
    def boxes(self) -> np.ndarray:
        """[N, 4] of all nodes, as told last."""
        self.ask("skip")
        return np.frombuffer(self.states[-1][1][1], dtype="<f8").reshape(-1, 4)
