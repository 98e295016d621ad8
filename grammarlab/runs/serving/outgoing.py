"""Frames on their way to one window."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable, Sequence
from contextlib import suppress

from tornado.websocket import WebSocketClosedError

Frame = str | bytes

MAX_UNSENT = 256 << 20
"""Bytes that may wait for a window. A window that reads has far fewer: the largest message is a file of 64 MiB."""


class Outgoing:
    """Writes frames to a window in their order, each after the one before it is out; used on the event loop only.

    A window that closes ends the writing. A window that does not read is given up when `MAX_UNSENT` is exceeded.
    """

    def __init__(self, write: Callable[[Frame], Awaitable[None]], give_up: Callable[[], None]) -> None:
        """Start writing.

        Args:
            write: writes one frame, and returns when it is out.
            give_up: called once when too much waits.
        """
        self._write, self._give_up = write, give_up
        self._frames: asyncio.Queue[Frame] = asyncio.Queue()
        self._num_bytes = 0
        self._task = asyncio.create_task(self._run())

    def put(self, frames: Sequence[Frame]) -> None:
        """Add the frames of a message."""
        if self._task.done():
            return
        self._num_bytes += sum(map(len, frames))
        if self._num_bytes > MAX_UNSENT:
            self.close()
            self._give_up()
            return
        for frame in frames:
            self._frames.put_nowait(frame)

    def close(self) -> None:
        """End the writing; what waits is dropped."""
        self._task.cancel()
        self._frames = asyncio.Queue()

    async def _run(self) -> None:
        with suppress(WebSocketClosedError):
            while True:
                frame = await self._frames.get()
                await self._write(frame)
                self._num_bytes -= len(frame)
