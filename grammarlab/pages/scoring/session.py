"""Scoring session for any transport.

Threads: a session has its own thread, which processes all requests in order. `handle`, `listen`, `call` and
`close` may be called from any other thread; all except `call` and `close` return at once. Functions that send
messages are called on the session's thread, one after the other; they must not block and must not use `call`.
"""

from __future__ import annotations

import time
import traceback
from collections.abc import Callable, Sequence
from concurrent.futures import Future
from contextlib import suppress
from functools import partial
from pathlib import Path
from queue import Empty, SimpleQueue
from threading import Thread
from typing import TypedDict

from grammarlab.errors import GrammarlabError
from grammarlab.pages.desktop import Argument, Message, Send
from grammarlab.pages.record.opening import NUM_MODELS, Opening, open_session
from grammarlab.pages.record.store import Store
from grammarlab.pages.scoring.commands import run
from grammarlab.pages.scoring.rounds import Rounds
from grammarlab.pages.scoring.state import state_of
from grammarlab.pages.workers.tasks import Begin
from grammarlab.pages.workers.worker_pool import TaskOutcome, WorkerPool
from grammarlab.runs.work.workers import available_cores, end_if_unguarded

CLOSED = "The session has been closed; what was scored is saved. Open it again to go on."
LOOK_EVERY = 0.4
"""Interval in seconds of reading the file for events of other processes."""


class SessionOptions(TypedDict, total=False):
    """Options of a session; see `Session`."""

    seed: int
    size: int
    assets: Path | None
    stored_grammar: bool
    jobs: int | None


class Session:
    """A scoring session: models, scores, and predictions learned from them."""

    def __init__(
        self,
        grammar: str,
        path: Path | str,
        *,
        seed: int = 0,
        size: int = NUM_MODELS,
        assets: Path | None = None,
        stored_grammar: bool = False,
        jobs: int | None = None,
    ) -> None:
        """Open a session file, or create one.

        Args:
            grammar: a rule file or the name of a shipped grammar.
            path: the session file.
            seed: seed of the models of a new session, 0 <= seed < 2**64.
            size: size of the pool of a new session.
            assets: folder of meshes and images, if it is not the one beside the rule file.
            stored_grammar: use the grammar stored in the session, even if the rule file has changed.
            jobs: number of processes that draw; by default one per core, 0 for a session without pictures.

        Raises:
            UsageError: If the session was created with another grammar.
            LanguageError: If the grammar has errors.
            AssetError: If the file is not a session.
            GrammarlabError: If a script without ``if __name__ == "__main__":`` begins a session.
        """
        end_if_unguarded()
        opening = open_session(grammar, Path(path), seed=seed, size=size, assets=assets, stored_grammar=stored_grammar)
        about = opening.about
        self._inbox: SimpleQueue[Callable[[], None] | None] = SimpleQueue()
        self._windows: dict[Send, None] = {}
        self._is_closed = False
        place = (about.suffix, about.grammar, about.title, str(opening.assets))
        size = available_cores() if jobs is None else jobs
        self._artists = WorkerPool(
            make=f"{__package__}.workers.artist:artist", arguments=place, size=size, deliver=self._inbox.put
        )
        self._artists.start()
        started: Future[None] = Future()
        self._thread = Thread(target=self._run, args=(opening, started), daemon=True)
        self._thread.start()
        started.result()

    def handle(self, message: object, buffers: Sequence[bytes], send: Send) -> None:
        """Accept a request of a window; see `grammarlab.pages.scoring.commands`.

        Args:
            message: any value; an invalid request is answered with an error.
            buffers: binary buffers of the message.
            send: receives the answer and requested pictures.
        """
        self._inbox.put(partial(self._handle, message, buffers, send))
        if not self._thread.is_alive():
            self._refuse_rest()

    def listen(self, send: Send) -> Callable[[], None]:
        """Notify a window of every change, and once initially.

        Returns:
            A function that ends the notifications.
        """
        self._inbox.put(partial(self._open, send))
        return lambda: self._inbox.put(partial(self._close, send))

    def call(
        self, command: str, buffers: Sequence[bytes] = (), **arguments: Argument
    ) -> tuple[Message, Sequence[bytes]]:
        """Run a command and wait for its result, which may take long.

        Raises:
            GrammarlabError: If it is refused, with the reason.
        """
        answered: Future[tuple[Message, Sequence[bytes]]] = Future()

        def receive(message: Message, answer_buffers: Sequence[bytes]) -> None:
            if "id" not in message:
                return
            if message["ok"]:
                answered.set_result((message["result"], answer_buffers))
            else:
                answered.set_exception(GrammarlabError(message["error"]))

        self.handle({"id": 0, "command": command, **arguments}, buffers, receive)
        return answered.result()

    def close(self) -> None:
        """End the session; all answered requests are on disk."""
        self._inbox.put(None)
        self._thread.join()

    def _run(self, opening: Opening, started: Future[None]) -> None:
        store = opening.store
        try:
            store = store or self._begin(opening)
            self._rounds = rounds = Rounds(opening.path, store, opening.assets, self._artists, self._tell)
        except BaseException as error:  # raised again where the session is made
            self._artists.close()
            if store is not None:
                store.close()
            started.set_exception(error)
            return
        started.set_result(None)
        looked = time.monotonic()
        while True:
            try:
                job = self._inbox.get(timeout=LOOK_EVERY)
            except Empty:
                job = _nothing
            if job is None:
                break
            try:
                job()
            except Exception:  # a bug must not end the session
                traceback.print_exc()
            if time.monotonic() - looked > LOOK_EVERY:
                self._look()
                looked = time.monotonic()
            rounds.prepare_if_free()
            if rounds.desk.is_changed:
                rounds.desk.is_changed = False
                self._tell({"event": "state", "state": state_of(rounds)})
        self._tell({"event": "closed", "message": CLOSED})
        rounds.close()
        self._artists.close()
        self._is_closed = True
        self._refuse_rest()

    def _refuse_rest(self) -> None:
        """Answer requests that arrive after the end."""
        with suppress(Empty):
            while True:
                if job := self._inbox.get_nowait():
                    job()

    def _begin(self, opening: Opening) -> Store:
        """Make a new session file; none is made for a grammar with errors."""
        if self._artists.size:
            # The processes read the grammar in any case, so this process does not load those libraries.
            found: list[TaskOutcome] = []
            self._artists.submit(Begin(), found.append)
            while not found:
                job = self._inbox.get()
                if job is not None:
                    job()
            if found[0].error:
                raise GrammarlabError(found[0].error)
        return Store.open(opening.path, opening.about)

    def _look(self) -> None:
        try:
            self._rounds.desk.poll()
        except GrammarlabError as error:
            if self._rounds.desk.message != str(error):
                self._rounds.desk.tell(str(error))

    def _handle(self, message: object, buffers: Sequence[bytes], send: Send) -> None:
        if self._is_closed:
            number = message.get("id") if isinstance(message, dict) else None
            send({"id": number, "ok": False, "error": CLOSED}, ())
            return
        run(self._rounds, message, buffers, send)

    def _open(self, send: Send) -> None:
        if self._is_closed:
            return
        self._windows[send] = None
        send({"event": "state", "state": state_of(self._rounds)}, ())

    def _close(self, send: Send) -> None:
        self._windows.pop(send, None)
        self._rounds.thumbnails.forget(send)

    def _tell(self, message: Message) -> None:
        for send in tuple(self._windows):
            try:
                send(message, ())
            except Exception:  # a window that cannot be reached must not end the session
                traceback.print_exc()
                self._close(send)


def _nothing() -> None:
    """Does nothing."""
