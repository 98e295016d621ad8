"""Correcting an example, usable by any transport: one thread on which everything happens in order."""

from __future__ import annotations

import traceback
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from queue import SimpleQueue
from threading import Thread

from grammarlab.runs.facade.example_page.commands import run, state_of
from grammarlab.runs.facade.example_page.desk import ExampleDesk
from grammarlab.runs.serving.windows import Send


class Corrector:
    """An example that windows correct together.

    `handle` and `listen` may be called from any thread and return at once. Functions given to send messages with are
    called on a thread of its own, one after the other, and must not block.
    """

    def __init__(self, file: Path, output: Path | None = None) -> None:
        """Opens the mesh of a building.

        Args:
            file: read only.
            output: where corrections are saved; `NAME.example.json` in the current folder when left out. Corrections
                that are there are gone on with.

        Raises:
            FacadeError: when the file cannot be read or nothing is found on it.
        """
        self.desk = ExampleDesk.of(file, output or Path(f"{file.stem}.example.json"))
        self._inbox: SimpleQueue[Callable[[], None] | None] = SimpleQueue()
        self._windows: dict[Send, None] = {}
        self._told = -1
        self._thread = Thread(target=self._run, daemon=True)
        self._thread.start()

    def handle(self, message: object, buffers: Sequence[bytes], send: Send) -> None:
        """Takes a request of a window; see `grammarlab.runs.facade.example_page.commands`."""
        self._inbox.put(partial(run, self.desk, message, buffers, send))

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
                if self._told != self.desk.revision:
                    self._told = self.desk.revision
                    for send in tuple(self._windows):
                        send(state_of(self.desk), ())
            except Exception:  # a mistake of ours must not end the page
                traceback.print_exc()

    def _open(self, send: Send) -> None:
        self._windows[send] = None
        send(state_of(self.desk), ())
