"""Editing a facade, usable by any transport: one thread on which everything happens in order."""

from __future__ import annotations

import traceback
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from queue import SimpleQueue
from threading import Thread
from typing import TypeGuard

from grammarlab.errors import FacadeError
from grammarlab.facade.file import load_facade
from grammarlab.runs.facade.editor.commands import run
from grammarlab.runs.facade.editor.desk import Desk
from grammarlab.runs.facade.editor.exporting import SUFFIX, checked_target, stem_of, unused_path
from grammarlab.runs.facade.editor.state import state_of
from grammarlab.runs.serving.windows import Message, Send

MOST_LEAVES = 20_000
"""Of a facade that is edited by hand."""


class Editor:
    """A facade that windows edit together.

    `handle` and `listen` may be called from any thread and return at once. Functions given to send messages with are
    called on the editor's own thread, one after the other, and must not block.
    """

    def __init__(self, file: Path, output: Path | None = None) -> None:
        """Opens the file of a facade.

        Args:
            file: read only, unless it is also the output.
            output: where it is saved; a new file in the current folder when left out.

        Raises:
            FacadeError: when the file is not a facade, or too large to be edited by hand.
            UsageError: when the output is not the name of such a file.
        """
        facade = load_facade(file)
        if len(facade.leaves) > MOST_LEAVES:
            raise FacadeError(
                f"{file.name}: {len(facade.leaves):,} leaves; expected at most {MOST_LEAVES:,} on the page. "
                "grammarlab facade edit takes larger ones."
            )
        target = checked_target(output) if output else unused_path(Path(f"{stem_of(file)}.edited.json"), SUFFIX)
        self.desk = Desk.of(facade, file, target)
        self._inbox: SimpleQueue[Callable[[], None] | None] = SimpleQueue()
        self._windows: dict[Send, None] = {}
        self._dragged: dict[Send, object] = {}
        """The latest request of each window for a size on the way."""
        self._told = -1
        self._thread = Thread(target=self._run, daemon=True)
        self._thread.start()

    def handle(self, message: object, buffers: Sequence[bytes], send: Send) -> None:
        """Takes a request of a window; see `grammarlab.runs.facade.editor.commands`."""
        if _is_drag(message):
            self._dragged[send] = message
        self._inbox.put(partial(self._handle, message, buffers, send))

    def listen(self, send: Send) -> Callable[[], None]:
        """Has a window told whenever something changes, and once at first; the result ends it."""
        self._inbox.put(partial(self._open, send))
        return lambda: self._inbox.put(partial(self._close, send))

    def close(self) -> None:
        """Ends it, after all that was asked for before."""
        self._inbox.put(None)
        self._thread.join()

    def _run(self) -> None:
        while job := self._inbox.get():
            try:
                job()
                if self._told != self.desk.revision:
                    self._tell()
            except Exception:  # a mistake of ours must not end the editor
                traceback.print_exc()

    def _handle(self, message: object, buffers: Sequence[bytes], send: Send) -> None:
        # Of sizes on the way only the latest counts, so that a slow solution never leaves a queue behind.
        if _is_drag(message) and self._dragged.get(send) is not message:
            message = {**message, "command": "skip"}
        run(self.desk, message, buffers, send)

    def _open(self, send: Send) -> None:
        self._windows[send] = None
        send(*state_of(self.desk))

    def _close(self, send: Send) -> None:
        self._windows.pop(send, None)
        self._dragged.pop(send, None)

    def _tell(self) -> None:
        self._told = self.desk.revision
        message, buffers = state_of(self.desk)
        for send in tuple(self._windows):
            send(message, buffers)


def _is_drag(message: object) -> TypeGuard[Message]:
    return isinstance(message, dict) and message.get("command") == "drag"
