"""Server of a page over HTTP and a WebSocket, for this machine and this person only.

It is bound to 127.0.0.1. All requests need the token of the run, compared in constant time; host names other than this
machine's own are refused, against DNS rebinding; other origins get no socket.
"""

from __future__ import annotations

import asyncio
import json
import os
import re
import secrets
import socket
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Protocol

from tornado.httpserver import HTTPServer
from tornado.ioloop import IOLoop
from tornado.web import Application, HTTPError, RequestHandler
from tornado.websocket import WebSocketClosedError, WebSocketHandler

from grammarlab.errors import UsageError
from grammarlab.runs.serving.windows import Message, Send

ADDRESS = "127.0.0.1"
KEPT = "GRAMMARLAB_TOKEN"
"""Environment variable with the token to use."""
MAX_BUFFERS = 4
_TYPES = {".js": "text/javascript", ".css": "text/css"}
_HOSTS = {ADDRESS, "localhost"}
_POLICY = (
    "default-src 'none'; script-src 'self' blob:; style-src 'self'; "
    "img-src 'self' blob: data:; connect-src 'self' ws://{host} blob: data:; worker-src blob:; font-src 'self'; "
    "base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
)


_INDEX = Path(__file__).with_name("index.html")
"""An empty page with `page.css` and `page.js`."""


@dataclass(frozen=True, slots=True)
class Page:
    """Files and settings of a page."""

    files: dict[str, Path]
    """Scripts and style sheets, by their names in the page."""
    command: str
    """Command that prints the address."""
    max_bytes: int
    """Largest size of one message in bytes."""


def built_page(module: str, command: str, max_bytes: int) -> Page:
    """Page built by `pages/bundle.js` in the folder `static` beside a module, given by its file."""
    static = Path(module).with_name("static")
    return Page({name: static / name for name in ("page.css", "page.js")}, command, max_bytes)


class Served(Protocol):
    """Subject of a page, such as a scoring session."""

    def handle(self, message: object, buffers: Sequence[bytes], send: Send) -> None:
        """Accept a request of a window, with any content; `send` receives the answer. Returns at once."""
        ...

    def listen(self, send: Send) -> Callable[[], None]:
        """Notify a window of every change, and once initially; the result ends the notifications."""
        ...


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
    asyncio.run(serving(session, page, port, on_ready))


async def serving(session: Served, page: Page, port: int, on_ready: Callable[[str], None]) -> None:
    """The same on a running event loop, until it is cancelled."""
    token = _token()
    listening = _listening(port)
    shared = {"session": session, "page": page, "token": token}
    application = Application(
        [
            (r"/", _IndexHandler, shared),
            (r"/socket", _SocketHandler, shared),
            (rf"/({'|'.join(map(_escaped, page.files))})", _FileHandler, shared),
        ],
        default_handler_class=_NothingHandler,
        default_handler_args=shared,
        websocket_max_message_size=page.max_bytes,
        websocket_ping_interval=30,
        log_function=lambda handler: None,
    )
    server = HTTPServer(application, max_body_size=1024, max_header_size=16_384)
    server.add_socket(listening)
    on_ready(f"http://{ADDRESS}:{listening.getsockname()[1]}/?token={token}")
    try:
        await asyncio.Event().wait()
    finally:
        server.stop()
        await server.close_all_connections()


def _token() -> str:
    """A new token for each run, unless the environment sets one so that open pages find the next run."""
    given = os.environ.get(KEPT, "")
    if given and not re.fullmatch(r"[\w-]{16,128}", given, re.ASCII):
        raise UsageError(f"{KEPT}: expected 16 to 128 letters, digits, - and _.")
    return given or secrets.token_urlsafe(24)


def _listening(port: int) -> socket.socket:
    try:
        listening = socket.create_server((ADDRESS, port))
    except (OSError, OverflowError) as error:
        raise UsageError(
            f"port {port} cannot be used ({error}). Give another one, or leave --port out for any that is free."
        ) from error
    listening.setblocking(False)
    return listening


def _escaped(name: str) -> str:
    return name.replace(".", r"\.")


class _GuardedHandler(RequestHandler):
    """Refuses all requests without the token."""

    def initialize(self, session: Served, page: Page, token: str) -> None:
        self.session, self.page, self.token = session, page, token

    def prepare(self) -> None:
        if self.request.host_name not in _HOSTS:
            raise HTTPError(403, reason="Unknown host")
        given = self.get_query_argument("token", "")
        if not secrets.compare_digest(given.encode(), self.token.encode()):
            raise HTTPError(403, reason="Wrong or missing token")

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


class _NothingHandler(_GuardedHandler):
    """All other addresses."""

    def prepare(self) -> None:
        super().prepare()
        raise HTTPError(404)


class _IndexHandler(_GuardedHandler):
    def get(self) -> None:
        text = _INDEX.read_text(encoding="utf-8")
        for name in self.page.files:
            text = text.replace(f'"{name}"', f'"{name}?token={self.token}"')
        self.finish(text)


class _FileHandler(_GuardedHandler):
    def get(self, name: str) -> None:
        self.set_header("Content-Type", f"{_TYPES[self.page.files[name].suffix]}; charset=utf-8")
        self.finish(self.page.files[name].read_bytes())


class _SocketHandler(_GuardedHandler, WebSocketHandler):
    """One window."""

    def check_origin(self, origin: str) -> bool:
        return origin == f"http://{self.request.host}"

    def open(self) -> None:
        self.set_nodelay(True)
        self._loop = IOLoop.current()
        self._message: object = None
        self._missing = 0
        self._buffers: list[bytes] = []
        self._unlisten = self.session.listen(self.send)

    def on_message(self, message: str | bytes) -> None:
        if isinstance(message, bytes):
            self._buffers.append(message)
            self._missing -= 1
        elif not self._begin(message):
            self.close(1007, "expected JSON")
            return
        if self._missing < 0:
            self.close(1002, "unexpected buffer")
        elif not self._missing:
            self.session.handle(self._message, tuple(self._buffers), self.send)

    def _begin(self, text: str) -> bool:
        """Check the first frame of a message; returns whether it is valid."""
        if self._missing:
            return False
        try:
            self._message = json.loads(text)
        except (ValueError, RecursionError):
            return False
        number = self._message.get("buffers", 0) if isinstance(self._message, dict) else 0
        if isinstance(number, bool) or not isinstance(number, int) or not 0 <= number <= MAX_BUFFERS:
            return False
        self._missing, self._buffers = number, []
        return True

    def send(self, message: Message, buffers: Sequence[bytes]) -> None:
        """Sends a message to the page; called on the session's thread."""
        text = json.dumps(message | {"buffers": len(buffers)}, allow_nan=False)
        self._loop.add_callback(partial(self._write, text, tuple(buffers)))

    def _write(self, text: str, buffers: Sequence[bytes]) -> None:
        try:
            self.write_message(text)
            for buffer in buffers:
                self.write_message(buffer, binary=True)
        except WebSocketClosedError:
            pass

    def on_close(self) -> None:
        self._unlisten()
