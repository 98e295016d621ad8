"""Protocol of the page of a city; `grammarlab.pages.requests` has the form of requests."""

from __future__ import annotations

from grammarlab.pages.city.desk import CityDesk
from grammarlab.pages.desk import DESK_COMMANDS, Command
from grammarlab.pages.desktop import StateEvent
from grammarlab.pages.requests import Request
from grammarlab.pages.windows import Message


def state_event(desk: CityDesk) -> StateEvent:
    """The whole state of the page."""
    return {"event": "state", "state": desk.state()}, ()


def _ground(desk: CityDesk, request: Request) -> None:
    if desk.ground is None:
        request.answer({"ids": None}, ())
    else:
        request.answer({"ids": desk.facts.rows.id.tolist()}, desk.ground.buffers)


def _parcel(desk: CityDesk, request: Request) -> Message:
    return desk.parcel(request.text("parcel"))


def _rules(desk: CityDesk, request: Request) -> None:
    desk.tell_rules(request.text("parcel"), request.answer)


def _reroll(desk: CityDesk, request: Request) -> Message:
    desk.reroll(request.text("parcel"))
    return desk.done()


def _pin(desk: CityDesk, request: Request) -> Message:
    desk.pin(request.text("parcel"))
    return desk.done()


def _exclude(desk: CityDesk, request: Request) -> Message:
    desk.exclude(request.text("parcel"))
    return desk.done()


def _score(desk: CityDesk, request: Request) -> Message:
    score = None if request.values.get("score") is None else request.number("score")
    desk.score(request.text("parcel"), score, request.text("kind", "score"), request.text("key", ""))
    return {"saved": True}


def _learn(desk: CityDesk, request: Request) -> Message:
    desk.learn(request.text("zone"))
    return {}


COMMANDS: dict[str, Command[CityDesk]] = {
    **DESK_COMMANDS,
    "ground": _ground,
    "parcel": _parcel,
    "rules": _rules,
    "reroll": _reroll,
    "pin": _pin,
    "exclude": _exclude,
    "score": _score,
    "learn": _learn,
}
"""Functions of commands."""
