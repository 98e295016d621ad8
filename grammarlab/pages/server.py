"""Server of a page over HTTP and a WebSocket, for this machine and this person only.

It is bound to 127.0.0.1. All requests need the token of the run, compared in constant time; host names other than this
machine's own are refused, against DNS rebinding; other origins get no socket. Requests that do not arrive in full,
windows that do not answer, and windows that ask without reading the answers are closed.
"""

from __future__ import annotations

import asyncio
import json
import os
import re
import secrets
import signal
import socket
import traceback
from collections.abc import Awaitable, Callable, Coroutine, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from types import TracebackType
from typing import Any, Protocol

from tornado.httpserver import HTTPServer
from tornado.ioloop import IOLoop
from tornado.iostream import IOStream
from tornado.web import Application, HTTPError, RequestHandler
from tornado.websocket import WebSocketClosedError, WebSocketHandler

from grammarlab.errors import AssetError, UsageError
from grammarlab.files import file_below, read_bounded
from grammarlab.option_names import with_options
from grammarlab.pages import STATIC
from grammarlab.pages.windows import Message, Send

Frame = str | bytes
MAX_UNSENT = 256 << 20
"""Bytes that may wait for a window. A window that reads has far fewer: the largest message is a file of 64 MiB."""
ADDRESS = "127.0.0.1"
MAX_CONNECTIONS = 200
"""Connections that may send requests at once; more are closed. A window has about six, and one WebSocket."""
MAX_UNANSWERED = 1000
"""Requests of a window whose answers may be outstanding; its next request is read when there are fewer."""
_ENVIRONMENT_VARIABLE = "GRAMMARLAB_TOKEN"
"""Environment variable with the token to use."""
_MAX_BUFFERS = 4
"""Largest number of buffers of one request."""
_TYPES = {".js": "text/javascript", ".css": "text/css"}
_FOLDER_TYPES = {
    ".json": "application/json",
    ".glb": "model/gltf-binary",
    ".subtree": "application/octet-stream",
    ".bin": "application/octet-stream",
    ".png": "image/png",
    ".jpg": "image/jpeg",
    ".jpeg": "image/jpeg",
}
"""Kinds of files of a served folder; others are not served."""
MAX_FOLDER_FILE = 64 << 20
"""Largest size of a file of a served folder in bytes."""
_GZIP = b"\x1f\x8b"
_HOSTS = {ADDRESS, "localhost"}
_POLICY = (
    "default-src 'none'; script-src 'self' blob:; style-src 'self'; "
    "img-src 'self' blob: data:; connect-src 'self' ws://{host} blob: data:; worker-src blob:; font-src 'self'; "
    "base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
)
_INDEX = Path(__file__).with_name("index.html")
"""An empty page with `page.css` and `page.js`."""


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


@dataclass(frozen=True, slots=True)
class Page:
    """Files and settings of a page."""

    files: dict[str, Path]
    """Scripts and style sheets, by their names in the page."""
    command: str
    """Command that prints the address."""
    max_bytes: int
    """Largest size of one message in bytes."""
    patience: float = 30.0
    """Seconds until a request has to be there in full, and within which a window has to answer a ping."""
    folder: Path | None = None
    """Folder whose files of the kinds `_FOLDER_TYPES` are served below ``/folder/``; None for none."""


class Served(Protocol):
    """Subject of a page, such as a scoring session."""

    def handle(self, message: object, buffers: Sequence[bytes], send: Send) -> None:
        """Accept a request of a window, with any content; `send` receives the answer. Returns at once."""
        ...

    def listen(self, send: Send) -> Callable[[], None]:
        """Notify a window of every change, and once initially; the result ends the notifications."""
        ...


def built_page(name: str, command: str, max_bytes: int) -> Page:
    """Page that `pages_src/bundle.js` has built in a folder of `STATIC`, by the name of that folder."""
    return Page({file: STATIC / name / file for file in ("page.css", "page.js")}, command, max_bytes)


def serve(session: Served, page: Page, port: int, on_ready: Callable[[str], None]) -> None:
    """Serve a session until the process is interrupted.

    Args:
        session: the session; it is not closed here.
        page: the page.
        port: port to listen on; 0 for any free one.
        on_ready: called with the address of the page when it can be opened.

    Raises:
        UsageError: If the port is in use.
        KeyboardInterrupt: If the user ends it.
    """
    asyncio.run(_run_until_interrupted(serving(session, page, port, on_ready)))


async def _run_until_interrupted(served: Coroutine[None, None, None]) -> None:
    """Wait for a server; that the process is terminated, or loses its terminal, counts as an interruption."""
    task = asyncio.ensure_future(served)
    with _handled_signals(task.cancel):
        try:
            await task
        except asyncio.CancelledError:
            raise KeyboardInterrupt from None


@contextmanager
def _handled_signals(end: Callable[[], object]) -> Iterator[None]:
    loop = asyncio.get_running_loop()
    handled: list[signal.Signals] = []
    for name in ("SIGTERM", "SIGHUP"):
        number: signal.Signals | None = getattr(signal, name, None)
        # A signal that was set to be ignored, as by nohup, stays so.
        if number is None or signal.getsignal(number) is not signal.SIG_DFL:
            continue
        with suppress(NotImplementedError, RuntimeError, ValueError):  # on Windows, and on other threads
            loop.add_signal_handler(number, end)
            handled.append(number)
    try:
        yield
    finally:
        for number in handled:
            loop.remove_signal_handler(number)


async def serving(session: Served, page: Page, port: int, on_ready: Callable[[str], None]) -> None:
    """The same on a running event loop, until it is cancelled."""
    token = _token()
    listener = _bound_socket(port)
    shared = {"session": session, "page": page, "token": token}
    application = Application(
        [
            (r"/", _IndexHandler, shared),
            (r"/socket", _SocketHandler, shared),
            (rf"/({'|'.join(map(_escaped, page.files))})", _FileHandler, shared),
            (r"/folder/(.+)", _FolderHandler, shared),
        ],
        default_handler_class=_NothingHandler,
        default_handler_args=shared,
        websocket_max_message_size=page.max_bytes,
        websocket_ping_interval=page.patience,
        websocket_ping_timeout=page.patience,
        log_function=lambda handler: None,
    )
    server = _BoundedServer(
        application,
        max_body_size=1024,
        max_header_size=16_384,
        idle_connection_timeout=page.patience,
        body_timeout=page.patience,
    )
    server.add_socket(listener)
    on_ready(f"http://{ADDRESS}:{listener.getsockname()[1]}/?token={token}")
    try:
        await asyncio.Event().wait()
    finally:
        server.stop()
        await server.close_all_connections()


def _token() -> str:
    """A new token for each run, unless the environment sets one so that open pages find the next run."""
    token = os.environ.get(_ENVIRONMENT_VARIABLE, "")
    if token and not re.fullmatch(r"[\w-]{16,128}", token, re.ASCII):
        raise UsageError(f"{_ENVIRONMENT_VARIABLE}: expected 16 to 128 letters, digits, - and _.")
    return token or secrets.token_urlsafe(24)


def _bound_socket(port: int) -> socket.socket:
    try:
        listener = socket.create_server((ADDRESS, port))
    except (OSError, OverflowError) as error:
        raise UsageError(
            f"port {port} cannot be used ({error}). Give another one, or leave `port=` out for any that is free."
        ) from error
    listener.setblocking(False)
    return listener


class _GuardedHandler(RequestHandler):
    """Refuses all requests without the token."""

    def initialize(self, session: Served, page: Page, token: str) -> None:
        self.session, self.page, self.token = session, page, token

    def prepare(self) -> None:
        if self.request.host_name not in _HOSTS:
            raise HTTPError(403, reason="Unknown host")
        token = self.get_query_argument("token", "")
        if not secrets.compare_digest(token.encode(), self.token.encode()):
            raise HTTPError(403, reason="Wrong or missing token")

    def log_exception(
        self, typ: type[BaseException] | None, value: BaseException | None, tb: TracebackType | None
    ) -> None:
        """Report a bug without the address of the request, which has the token."""
        if not isinstance(value, HTTPError):
            traceback.print_exception(typ, value, tb)

    def set_default_headers(self) -> None:
        self.set_header("Server", "grammarlab")
        self.set_header("Content-Security-Policy", _POLICY.format(host=self.request.host))
        self.set_header("X-Content-Type-Options", "nosniff")
        self.set_header("Referrer-Policy", "no-referrer")
        self.set_header("Cross-Origin-Resource-Policy", "same-origin")
        self.set_header("Cache-Control", "no-store")

    def write_error(self, status_code: int, **_: object) -> None:
        self.set_header("Content-Type", "text/plain; charset=utf-8")
        self.finish(f"{status_code} {self._reason}. Open the address that {self.page.command} printed.\n")


class _IndexHandler(_GuardedHandler):
    def get(self) -> None:
        text = _INDEX.read_text(encoding="utf-8")
        for name in self.page.files:
            text = text.replace(f'"{name}"', f'"{name}?token={self.token}"')
        self.finish(text)


class _SocketHandler(_GuardedHandler, WebSocketHandler):
    """One window."""

    def check_origin(self, origin: str) -> bool:
        return origin == f"http://{self.request.host}"

    def open(self) -> None:
        self.set_nodelay(True)
        self._loop = IOLoop.current()
        self._outgoing = Outgoing(self._write, partial(self.close, 1008, "answers are not read"))
        self._num_unanswered = 0
        self._answered = asyncio.Event()
        self._message: object = None
        self._missing = 0
        self._buffers: list[bytes] = []
        self._unlisten = self.session.listen(self.send)

    async def on_message(self, message: str | bytes) -> None:
        if isinstance(message, bytes):
            self._buffers.append(message)
            self._missing -= 1
        elif not self._begin(message):
            self.close(1007, "expected JSON")
            return
        if self._missing < 0:
            self.close(1002, "unexpected buffer")
        elif not self._missing:
            self._num_unanswered += 1
            self.session.handle(self._message, tuple(self._buffers), self.send)
            await self._until_answered()

    async def _until_answered(self) -> None:
        """Read no more requests while too many are unanswered, so that a flood waits at the window and not here."""
        while self._num_unanswered >= MAX_UNANSWERED and self.ws_connection is not None:
            self._answered.clear()
            try:
                await asyncio.wait_for(self._answered.wait(), self.page.patience)
            except TimeoutError:
                self.close(1013, "too many requests")
                return

    def _begin(self, text: str) -> bool:
        """Check the first frame of a message; returns whether it is valid."""
        if self._missing:
            return False
        try:
            self._message = json.loads(text)
        except (ValueError, RecursionError):
            return False
        number = self._message.get("buffers", 0) if isinstance(self._message, dict) else 0
        if isinstance(number, bool) or not isinstance(number, int) or not 0 <= number <= _MAX_BUFFERS:
            return False
        self._missing, self._buffers = number, []
        return True

    def send(self, message: Message, buffers: Sequence[bytes]) -> None:
        """Sends a message to the page; called on the session's thread.

        A refusal names options instead of arguments: pages are opened by commands, and notebooks have no server.
        """
        if isinstance(message.get("error"), str):
            message = message | {"error": with_options(message["error"])}
        text = json.dumps(message | {"buffers": len(buffers)}, allow_nan=False)
        self._loop.add_callback(self._put, (text, *buffers), is_answer="ok" in message)

    def _put(self, frames: Sequence[str | bytes], *, is_answer: bool) -> None:
        if is_answer:
            self._num_unanswered -= 1
            self._answered.set()
        self._outgoing.put(frames)

    async def _write(self, frame: str | bytes) -> None:
        await self.write_message(frame, binary=isinstance(frame, bytes))

    def on_close(self) -> None:
        self._unlisten()
        self._outgoing.close()
        self._answered.set()


def _escaped(name: str) -> str:
    return name.replace(".", r"\.")


class _FileHandler(_GuardedHandler):
    def get(self, name: str) -> None:
        self.set_header("Content-Type", f"{_TYPES[self.page.files[name].suffix]}; charset=utf-8")
        self.finish(self.page.files[name].read_bytes())


class _FolderHandler(_GuardedHandler):
    """Files below the folder of the page, never through a link. A browser asks each time whether one has changed."""

    def get(self, name: str) -> None:
        file = None if self.page.folder is None else file_below(self.page.folder, name)
        if file is None or file.suffix not in _FOLDER_TYPES:
            raise HTTPError(404)
        try:
            content = read_bounded(file, MAX_FOLDER_FILE)
        except (AssetError, OSError) as error:
            raise HTTPError(404) from error
        self.set_header("Content-Type", _FOLDER_TYPES[file.suffix])
        self.set_header("Cache-Control", "no-cache")
        if content.startswith(_GZIP):  # stored compressed under its plain name, as web servers serve it
            self.set_header("Content-Encoding", "gzip")
        self.finish(content)


class _NothingHandler(_GuardedHandler):
    """All other addresses."""

    def prepare(self) -> None:
        super().prepare()
        raise HTTPError(404)


class _BoundedServer(HTTPServer):
    """Closes connections beyond `MAX_CONNECTIONS`, so that none can use up the files that a process may open."""

    _num_open = 0

    def handle_stream(self, stream: IOStream, address: tuple[Any, ...]) -> None:
        if self._num_open >= MAX_CONNECTIONS:
            stream.close()
            return
        self._num_open += 1
        super().handle_stream(stream, address)

    def on_close(self, server_conn: object) -> None:
        self._num_open -= 1
        super().on_close(server_conn)
