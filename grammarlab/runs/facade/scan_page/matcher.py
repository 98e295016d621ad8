"""Matching with a person, usable by any transport: one thread on which everything happens in order."""

from __future__ import annotations

import traceback
from collections.abc import Callable, Sequence
from functools import partial
from queue import SimpleQueue
from threading import Thread

from grammarlab.facade.templates.kinds.corrections import correction_of
from grammarlab.runs.facade.scan_page.desk import ScanDesk
from grammarlab.runs.serving.requests import Request, answered
from grammarlab.runs.serving.server import built_page
from grammarlab.runs.serving.windows import Message, Send

PAGE = built_page(__file__, "grammarlab facade open", max_bytes=1 << 20)


class Matcher:
    """Elements that windows correct together.

    `handle` and `listen` may be called from any thread and return at once. Functions given to send messages with are
    called on a thread of its own, one after the other, and must not block.
    """

    def __init__(self, desk: ScanDesk) -> None:
        self.desk = desk
        self._inbox: SimpleQueue[Callable[[], None] | None] = SimpleQueue()
        self._windows: dict[Send, None] = {}
        self._told = -1
        self._thread = Thread(target=self._run, daemon=True)
        self._thread.start()

    def handle(self, message: object, buffers: Sequence[bytes], send: Send) -> None:
        """Takes a request of a window; see `COMMANDS`."""
        self._inbox.put(partial(answered, COMMANDS, self.desk, message, buffers, send))

    def listen(self, send: Send) -> Callable[[], None]:
        """Has a window told whenever something changes, and once at first; the result ends it."""
        self._inbox.put(partial(self._open, send))
        return lambda: self._inbox.put(lambda: self._windows.pop(send, None) and None)

    def close(self) -> None:
        """Ends it, after all that was asked for before."""
        self._inbox.put(None)
        self._thread.join()

    def _run(self) -> None:
        while job := self._inbox.get():
            try:
                job()
                self._tell()
                # What was asked for meanwhile comes first, so that one match is enough for all of it.
                if self.desk.is_stale and self._windows and self._inbox.empty():
                    self.desk.rematch()
                    self._tell()
            except Exception:  # a mistake of ours must not end the page
                traceback.print_exc()

    def _open(self, send: Send) -> None:
        self._windows[send] = None
        send({"event": "state", "state": self.desk.state()}, ())

    def _tell(self) -> None:
        if self._told != self.desk.revision:
            self._told = self.desk.revision
            message = {"event": "state", "state": self.desk.state()}
            for send in tuple(self._windows):
                send(message, ())


def _correct(desk: ScanDesk, request: Request) -> Message:
    said = correction_of(request.values.get("correction"), "correction")
    desk.say((*desk.corrections, said))
    return _done(desk)


def _remove(desk: ScanDesk, request: Request) -> Message:
    place = request.whole("number", 0, len(desk.corrections) - 1, -1)
    desk.say((*desk.corrections[:place], *desk.corrections[place + 1 :]))
    return _done(desk)


def _undo(desk: ScanDesk, _request: Request) -> Message:
    desk.undo()
    return _done(desk)


def _done(desk: ScanDesk) -> Message:
    return {"revision": desk.revision}


COMMANDS: dict[str, Callable[[ScanDesk, Request], Message | None]] = {
    "correct": _correct,
    "remove": _remove,
    "undo": _undo,
}
"""What each command does."""
