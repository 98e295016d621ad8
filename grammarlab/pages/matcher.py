"""Matching with corrections."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial

from grammarlab.matching.corrections import correction_of
from grammarlab.pages.desktop import Desktop, Message
from grammarlab.pages.requests import Request, answered
from grammarlab.pages.scan_desk import ScanDesk
from grammarlab.pages.server import built_page

PAGE = built_page("scan", "grammarlab facade open", max_bytes=1 << 20)


class Matcher(Desktop[ScanDesk]):
    """Elements corrected by several windows; matched again once no requests wait."""

    def __init__(self, desk: ScanDesk) -> None:
        super().__init__(desk, partial(answered, COMMANDS), _state_of, _match)


def _state_of(desk: ScanDesk) -> tuple[Message, Sequence[bytes]]:
    return {"event": "state", "state": desk.state()}, ()


def _match(desk: ScanDesk) -> None:
    # Waiting requests came first, so that one match covers all of them.
    if desk.is_stale:
        desk.rematch()


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
"""Functions of commands."""
