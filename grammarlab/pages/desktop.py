"""Shared document of several windows, for any transport: one thread processes all requests in order.

Messages from a session to its windows.
"""

from __future__ import annotations

import traceback
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from queue import SimpleQueue
from threading import Thread
from typing import Any, Generic, Protocol, TypeAlias, TypeGuard, TypeVar

Message = dict[str, Any]
Argument: TypeAlias = str | float | bool | Sequence["Argument"] | Mapping[str, "Argument"] | None
"""A value of a request, as JSON has it."""
Send = Callable[[Message, Sequence[bytes]], None]
"""Sends a message and binary buffers to one window. Called on the session's thread; it must not block."""
Answer = Callable[[Message, Sequence[bytes]], None]
"""Send the result of a command."""
Refuse = Callable[[str], None]
"""Send the reason why there is no result."""


class Counted(Protocol):
    """An object with a counter of its changes."""

    revision: int


Desk = TypeVar("Desk", bound=Counted)
"""Where everything lies."""


class Desktop(Generic[Desk]):
    """A desk that windows work on together.

    `handle` and `listen` may be called from any thread and return at once. Functions given to send messages with are
    called on the desktop's own thread, one after the other, and must not block.
    """

    def __init__(
        self,
        desk: Desk,
        run: Callable[[Desk, object, Sequence[bytes], Send], None],
        state_of: Callable[[Desk], tuple[Message, Sequence[bytes]]],
        idle: Callable[[Desk], None] = lambda _: None,
    ) -> None:
        """Start the thread.

        Args:
            desk: changed on the desktop's thread only.
            run: runs a request and answers; only the latest `drag` is run, earlier ones become `skip`.
            state_of: the event, with buffers, sent to windows initially and whenever `revision` has changed.
            idle: does what can wait until nothing is asked for; only while there is a window.
        """
        self.desk, self._run_request, self._state_of, self._idle = desk, run, state_of, idle
        self._inbox: SimpleQueue[Callable[[], None] | None] = SimpleQueue()
        self._windows: dict[Send, None] = {}
        self._dragged: dict[Send, object] = {}
        """The latest request of each window for a size on the way."""
        self._told = -1
        self._thread = Thread(target=self._run, daemon=True)
        self._thread.start()

    def handle(self, message: object, buffers: Sequence[bytes], send: Send) -> None:
        """Accept a request of a window."""
        if _is_drag(message):
            self._dragged[send] = message
        self._inbox.put(partial(self._handle, message, buffers, send))

    def listen(self, send: Send) -> Callable[[], None]:
        """Notify a window of every change, and once initially; the result ends the notifications."""
        self._inbox.put(partial(self._open, send))
        return lambda: self._inbox.put(partial(self._close, send))

    def post(self, job: Callable[[], None]) -> None:
        """Run a function on the desktop's thread; may be called from any thread."""
        self._inbox.put(job)

    def tell(self, message: Message) -> None:
        """Send an event to all windows; called on the desktop's thread."""
        for send in tuple(self._windows):
            send(message, ())

    def close(self) -> None:
        """End the thread after all earlier requests."""
        self._inbox.put(None)
        self._thread.join()

    def _run(self) -> None:
        while job := self._inbox.get():
            try:
                job()
                self._tell_state()
                if self._windows and self._inbox.empty():
                    self._idle(self.desk)
                    self._tell_state()
            except Exception:  # a bug must not end the desktop
                traceback.print_exc()

    def _handle(self, message: object, buffers: Sequence[bytes], send: Send) -> None:
        # Only the latest size of a drag is solved, so that a slow solution leaves no queue.
        if _is_drag(message) and self._dragged.get(send) is not message:
            message = {**message, "command": "skip"}
        self._run_request(self.desk, message, buffers, send)

    def _open(self, send: Send) -> None:
        self._windows[send] = None
        send(*self._state_of(self.desk))

    def _close(self, send: Send) -> None:
        self._windows.pop(send, None)
        self._dragged.pop(send, None)

    def _tell_state(self) -> None:
        if self._told == self.desk.revision:
            return
        self._told = self.desk.revision
        message, buffers = self._state_of(self.desk)
        for send in tuple(self._windows):
            send(message, buffers)


def _is_drag(message: object) -> TypeGuard[Message]:
    return isinstance(message, dict) and message.get("command") == "drag"
