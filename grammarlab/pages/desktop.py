"""Windows around a desk, for any transport: one thread processes all their requests in order."""

from __future__ import annotations

import time
import traceback
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Future
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from queue import Empty, SimpleQueue
from threading import Thread
from typing import Generic, TypeGuard

from grammarlab.errors import GrammarlabError
from grammarlab.pages.desk import Command, DeskT
from grammarlab.pages.requests import run_request, unexpected
from grammarlab.pages.windows import Argument, Message, Send

StateEvent = tuple[Message, Sequence[bytes]]
"""The event with the whole state of a page, and its buffers."""
CLOSED = "The page has been closed. Open its file again to go on."


def _nothing(*_: object) -> None:
    """Does nothing."""


@dataclass(frozen=True)
class DeskHooks(Generic[DeskT]):
    """What a desk does besides commands; all functions are called on the desktop's thread."""

    idle: Callable[[DeskT], None] = _nothing
    """Does what can wait until no request waits; called only while there is a window."""
    poll: Callable[[DeskT], None] = _nothing
    """Looks for changes from elsewhere."""
    poll_seconds: float | None = None
    """Interval of polls; None for no polls."""
    forget: Callable[[DeskT, Send], None] = _nothing
    """Drops the requests of a window that has gone."""
    close: Callable[[DeskT], None] = _nothing
    """Ends the workers of the desk."""
    closed: str = CLOSED
    """Message to windows at the end, and to later requests."""


class Desktop(Generic[DeskT]):
    """A desk that windows work on together.

    `handle`, `listen`, `post`, `call` and `close` may be called from any thread; all except `call` and `close` return
    at once. Functions that send messages are called on the desktop's own thread, one after the other; they must not
    block and must not use `call`. A window whose function fails hears no more; the others are not affected.
    """

    def __init__(
        self,
        make: Callable[[Desktop[DeskT]], DeskT],
        commands: Mapping[str, Command[DeskT]],
        state_of: Callable[[DeskT], StateEvent],
        hooks: DeskHooks[DeskT] | None = None,
    ) -> None:
        """Make the desk, then start the thread.

        Args:
            make: makes the desk; it may use `post`, `tell` and `run_until`. The desk is then used on the thread only.
            commands: commands by name; of the requests for a `drag` only the latest is run, earlier ones become `skip`.
            state_of: the event sent to windows initially and whenever `revision` has changed.
            hooks: what the desk does besides.
        """
        self._commands, self._state_of, self._hooks = commands, state_of, hooks or DeskHooks()
        self._inbox: SimpleQueue[Callable[[], None] | None] = SimpleQueue()
        self._windows: dict[_Window, None] = {}
        self._dragged: dict[Send, object] = {}
        """The latest request of each window for a size on the way."""
        self._is_closed = False
        self.desk = make(self)
        self._revision = self.desk.revision
        """Revision that windows have."""
        self._thread = Thread(target=self._run, daemon=True)
        self._thread.start()

    def handle(self, message: object, buffers: Sequence[bytes], send: Send) -> None:
        """Accept a request of a window.

        Args:
            message: any value; an invalid request is run_request with an error.
            buffers: binary buffers of the message.
            send: receives the answer and later messages that were requested.
        """
        if _is_drag(message):
            self._dragged[send] = message
        self._inbox.put(partial(self._handle, message, buffers, self._window(send)))
        if not self._thread.is_alive():
            self._refuse_remaining()

    def listen(self, send: Send) -> Callable[[], None]:
        """Notify a window of every change, and once initially; the result ends the notifications."""
        window = self._window(send)
        self._inbox.put(partial(self._open, window))
        return lambda: self._inbox.put(partial(self._forget, window))

    def call(
        self, command: str, buffers: Sequence[bytes] = (), **arguments: Argument
    ) -> tuple[Message, Sequence[bytes]]:
        """Run a command and wait for its result, which may take long.

        Raises:
            GrammarlabError: If it is refused, with the reason.
        """
        answer: Future[tuple[Message, Sequence[bytes]]] = Future()

        def receive(message: Message, answer_buffers: Sequence[bytes]) -> None:
            if "id" not in message:
                return
            if message["ok"]:
                answer.set_result((message["result"], answer_buffers))
            else:
                answer.set_exception(GrammarlabError(message["error"]))

        self.handle({"id": 0, "command": command, **arguments}, buffers, receive)
        return answer.result()

    def post(self, job: Callable[[], None]) -> None:
        """Run a function on the desktop's thread."""
        self._inbox.put(job)

    def run_until(self, is_done: Callable[[], bool]) -> None:
        """Run posted functions until a condition holds; only while the desk is made."""
        while not is_done():
            if job := self._inbox.get():
                job()

    def tell(self, message: Message, buffers: Sequence[bytes] = ()) -> None:
        """Send an event to all windows; called on the desktop's thread."""
        for window in tuple(self._windows):
            window(message, buffers)

    def close(self) -> None:
        """End the thread after all earlier requests."""
        self._inbox.put(None)
        self._thread.join()

    def _run(self) -> None:
        hooks, poll_time = self._hooks, time.monotonic()
        while job := self._next():
            _attempt(job)
            if hooks.poll_seconds is not None and time.monotonic() - poll_time > hooks.poll_seconds:
                _attempt(partial(hooks.poll, self.desk))
                poll_time = time.monotonic()
            _attempt(self._tell_state)
            if self._windows and self._inbox.empty():
                _attempt(partial(hooks.idle, self.desk))
                _attempt(self._tell_state)
        self.tell({"event": "closed", "message": hooks.closed})
        _attempt(partial(hooks.close, self.desk))
        self._is_closed = True
        self._refuse_remaining()

    def _next(self) -> Callable[[], None] | None:
        """The next job; None at the end."""
        try:
            return self._inbox.get(timeout=self._hooks.poll_seconds)
        except Empty:
            return _nothing

    def _refuse_remaining(self) -> None:
        """Answer requests that arrive after the end."""
        with suppress(Empty):
            while True:
                if job := self._inbox.get_nowait():
                    _attempt(job)

    def _handle(self, message: object, buffers: Sequence[bytes], window: _Window) -> None:
        if self._is_closed:
            number = message.get("id") if isinstance(message, dict) else None
            window({"id": number, "ok": False, "error": self._hooks.closed}, ())
            return
        # Only the latest size of a drag is solved, so that a slow solution leaves no queue.
        if _is_drag(message) and self._dragged.get(window.send) is not message:
            message = {**message, "command": "skip"}
        run_request(self._commands, self.desk, message, buffers, window)

    def _window(self, send: Send) -> _Window:
        return _Window(send, self._forget)

    def _open(self, window: _Window) -> None:
        if self._is_closed:
            return
        self._windows[window] = None
        window(*self._state_of(self.desk))

    def _forget(self, window: _Window) -> None:
        self._windows.pop(window, None)
        self._dragged.pop(window.send, None)
        self._hooks.forget(self.desk, window)

    def _tell_state(self) -> None:
        if self._revision == self.desk.revision:
            return
        self._revision = self.desk.revision
        if self._windows:
            self.tell(*self._state_of(self.desk))


@dataclass(frozen=True, slots=True)
class _Window:
    """A window that cannot fail: one that cannot be reached is given up, so that all others hear of everything."""

    send: Send
    give_up: Callable[[_Window], None]

    def __call__(self, message: Message, buffers: Sequence[bytes]) -> None:
        try:
            return self.send(message, buffers)
        except Exception as error:  # of foreign code, so of any kind
            traceback.print_exc()
            reason = unexpected(error)
        if message.get("ok"):
            # A result may be what cannot be sent, such as a number that JSON does not have.
            return self({"id": message["id"], "ok": False, "error": reason}, ())
        return self.give_up(self)


def _is_drag(message: object) -> TypeGuard[Message]:
    return isinstance(message, dict) and message.get("command") == "drag"


def _attempt(job: Callable[[], None]) -> None:
    try:
        job()
    except Exception:  # a bug must not end the thread
        traceback.print_exc()
