"""A window that remembers what it was told."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from threading import Condition
from typing import Any

from grammarlab.pages.scoring.session import Session
from grammarlab.pages.windows import Message
from tests.waiting import PATIENCE


class Window:
    """Talks to a session as a page does."""

    def __init__(self, session: Session) -> None:
        self._session = session
        self._arrived = Condition()
        self.heard: list[tuple[Message, Sequence[bytes]]] = []
        self.close = session.listen(self.send)
        self.wait(lambda message: message.get("event") == "state")

    def send(self, message: Message, buffers: Sequence[bytes]) -> None:
        json.dumps(message, allow_nan=False)
        with self._arrived:
            self.heard.append((message, buffers))
            self._arrived.notify_all()

    def ask(self, message: object, *buffers: bytes) -> None:
        self._session.handle(message, buffers, self.send)

    def wait(self, fits: Callable[[Message], Any]) -> tuple[Message, Sequence[bytes]]:
        """The first message that fits, of those heard and those to come."""

        def found() -> list[tuple[Message, Sequence[bytes]]]:
            return [entry for entry in self.heard if fits(entry[0])]

        with self._arrived:
            assert self._arrived.wait_for(found, PATIENCE), "nothing of the kind was said"
            return found()[0]

    def state(self, fits: Callable[[Message], Any]) -> Message:
        """The first state that fits, of those heard since `forget` and those to come."""
        return self.wait(lambda message: message.get("event") == "state" and fits(message["state"]))[0]["state"]

    def forget(self) -> None:
        with self._arrived:
            self.heard.clear()


class BrokenWindow:
    """Fails once it has heard so many messages, as a closed connection does."""

    def __init__(self, answers: int) -> None:
        self._answers = answers
        self.heard: list[Message] = []

    def send(self, message: Message, _buffers: Sequence[bytes]) -> None:
        self.heard.append(message)
        if len(self.heard) > self._answers:
            raise ConnectionError("the window has gone")


def shown_models(state: Message) -> list[str]:
    """All models of the grids, in order."""
    return [model for grid in state["grids"] for model in grid["models"]]
