"""Matching with corrections."""

from __future__ import annotations

from grammarlab.matching.corrections import correction_of
from grammarlab.pages.desk import DESK_COMMANDS, Command
from grammarlab.pages.desktop import DeskHooks, Desktop, StateEvent
from grammarlab.pages.requests import Request
from grammarlab.pages.scan_desk import ScanDesk
from grammarlab.pages.server import built_page
from grammarlab.pages.windows import Message

PAGE = built_page("scan", "grammarlab facade open", max_bytes=1 << 20)


class Matcher(Desktop[ScanDesk]):
    """Elements corrected by several windows; matched again once no requests wait."""

    def __init__(self, desk: ScanDesk) -> None:
        super().__init__(lambda _: desk, COMMANDS, _state_of, DeskHooks(idle=_match))


def _state_of(desk: ScanDesk) -> StateEvent:
    return {"event": "state", "state": desk.state()}, ()


def _match(desk: ScanDesk) -> None:
    # Waiting requests came first, so that one match covers all of them.
    if desk.is_stale:
        desk.rematch()


def _correct(desk: ScanDesk, request: Request) -> Message:
    correction = correction_of(request.values.get("correction"), "correction")
    desk.do("correct", (*desk.document, correction))
    return desk.done()


def _remove(desk: ScanDesk, request: Request) -> Message:
    number = request.integer("number", 0, len(desk.document) - 1, -1)
    desk.do("remove", (*desk.document[:number], *desk.document[number + 1 :]))
    return desk.done()


COMMANDS: dict[str, Command[ScanDesk]] = {
    **DESK_COMMANDS,
    "correct": _correct,
    "remove": _remove,
}
"""Functions of commands."""
