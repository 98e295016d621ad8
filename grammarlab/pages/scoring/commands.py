"""Protocol of a scoring session: checked requests of windows, and their answers.

See `grammarlab.pages.requests` for the form of requests.
"""

from __future__ import annotations

from dataclasses import asdict

from grammarlab.errors import UsageError, shown
from grammarlab.learning.designs.addresses import Address
from grammarlab.pages import STATIC
from grammarlab.pages.desk import DESK_COMMANDS, Command
from grammarlab.pages.record.events import Record
from grammarlab.pages.record.model_grids import Body, checked_models
from grammarlab.pages.requests import Request
from grammarlab.pages.scoring.desk import SessionDesk
from grammarlab.pages.scoring.session_files import FORMATS
from grammarlab.pages.scoring.sorting import Order
from grammarlab.pages.scoring.state import state_of
from grammarlab.pages.windows import Message
from grammarlab.pages.workers.tasks import DrawContrast, FindPart, MakeGlb
from grammarlab.pages.workers.thumbnails import GOOD, LARGEST, SMALLEST, sprite_sheet

MAX_PICTURES = 1000
"""Largest number of models in one request for pictures."""
MAX_SHEET = 64
"""Models on a sheet."""
MAX_FILE_BYTES = 32 << 20
"""Largest size of a label file in bytes."""
IMPORTED = (*FORMATS, "tsv")
"""Formats of label files that are read."""
VIEWER = STATIC / "scoring" / "viewer.js"


def _state(desk: SessionDesk, _request: Request) -> Message:
    return state_of(desk)


def _label_event(kind: str, *names: str) -> Command[SessionDesk]:
    """A command that scores or compares; missing arguments are not stored."""

    def add(desk: SessionDesk, request: Request) -> Message:
        label = {name: request.values[name] for name in names if name in request.values}
        revision = desk.display.label(kind, label, request.values.get("factor", ""), request.text("key", ""))
        return {"saved": True, "revision": revision}

    return add


def _event(kind: str, *names: str) -> Command[SessionDesk]:
    """A command that only adds an event."""

    def add(desk: SessionDesk, request: Request) -> Message:
        body = {name: request.values.get(name) for name in names}
        return desk.do(kind, body)

    return add


def _factor_event(kind: str, *names: str) -> Command[SessionDesk]:
    """The same for a factor, given by its name or, since names change, by its number."""

    def add(desk: SessionDesk, request: Request) -> Message:
        values = {name: request.values.get(name) for name in names}

        def body(record: Record) -> Body:
            return values | {"name": record.name_of(request.values.get("name"))}

        return desk.do(kind, body)

    return add


def _layout(desk: SessionDesk, request: Request) -> Message:
    desk.layout({name: request.values.get(name) for name in ("grids", "rows", "columns")})
    return {"revision": desk.display.record.revision}


def _new_models(desk: SessionDesk, request: Request) -> Message:
    desk.learning.new_models(request.text("way", desk.display.record.way))
    return {"revision": desk.display.record.revision}


def _more(desk: SessionDesk, _request: Request) -> Message:
    desk.learning.more()
    return {"revision": desk.display.record.revision}


def _sort(desk: SessionDesk, request: Request) -> Message:
    models = tuple(checked_models(request.values.get("models", []), MAX_PICTURES))
    desk.display.sort(Order(request.text("by"), request.text("feature", ""), models))
    return {"revision": desk.display.record.revision}


def _features(desk: SessionDesk, request: Request) -> Message:
    desk.learning.prepare()
    return {"features": desk.display.knowledge.names_like(request.text("query", ""))}


def _update(desk: SessionDesk, _request: Request) -> Message:
    desk.learning.update()
    return {}


def _cancel(desk: SessionDesk, request: Request) -> Message:
    if request.one_of("of", ("update", "result"), "update") == "update":
        desk.learning.cancel()
    else:
        desk.files.cancel()
    return {}


def _pictures(desk: SessionDesk, request: Request) -> None:
    models = checked_models(request.values.get("models"), MAX_PICTURES)
    good = checked_models(request.values.get("good", models), MAX_PICTURES)
    size = request.integer("size", SMALLEST, LARGEST, 160)
    request.answer({}, ())
    desk.thumbnails.request(models, size, request.window, good)


def _model(desk: SessionDesk, request: Request) -> None:
    model = str(Address.parse(request.values.get("model")))
    label = desk.display.pool.label_of(model)
    desk.ask_artist(MakeGlb(model), lambda glb: ({"label": label}, [glb]), request.answer, request.refuse)


def _contrast(desk: SessionDesk, request: Request) -> None:
    learned = desk.display.knowledge.learned
    contrasts = {contrast.text: contrast for contrast in (() if learned is None else learned.contrasts)}
    text = request.text("choice")
    if text not in contrasts:
        raise UsageError(f"choice: expected one that was learned, found {shown(text)}.")
    task = DrawContrast(contrasts[text], request.integer("size", SMALLEST, LARGEST, 160), GOOD)
    desk.ask_artist(task, lambda drawn: ({}, [sprite_sheet(drawn.pictures, 2)]), request.answer, request.refuse)


def _part(desk: SessionDesk, request: Request) -> None:
    kind = "triangle" if "triangle" in request.values else "part"
    number = request.integer(kind, -(2**53), 2**53, 0)
    task = FindPart(str(Address.parse(request.values.get("model"))), number, kind == "triangle")
    desk.ask_artist(task, lambda part: (asdict(part), []), request.answer, request.refuse)


def _viewer(_desk: SessionDesk, request: Request) -> None:
    request.answer({}, (VIEWER.read_bytes(),))


def _import(desk: SessionDesk, request: Request) -> None:
    if len(request.buffers) != 1 or len(request.buffers[0]) > MAX_FILE_BYTES:
        raise UsageError(f"expected one label file of at most {MAX_FILE_BYTES >> 20} MiB.")
    desk.files.read(bytes(request.buffers[0]), f".{request.one_of('format', IMPORTED)}", request.answer, request.refuse)


def _learn(desk: SessionDesk, request: Request) -> None:
    desk.files.learn_grammar(request.answer, request.refuse)


def _sheet(desk: SessionDesk, request: Request) -> None:
    desk.files.sheet(request.integer("num", 1, MAX_SHEET, 16), request.answer, request.refuse)


COMMANDS: dict[str, Command[SessionDesk]] = {
    **DESK_COMMANDS,
    "state": _state,
    "score": _label_event("score", "models", "score", "kind"),
    "compare": _label_event("compare", "models", "kind"),
    "factor_create": _event("factor_create", "name"),
    "factor_rename": _factor_event("factor_rename", "to"),
    "factor_delete": _factor_event("factor_delete"),
    "factor_activate": _factor_event("factor_activate"),
    "view": _event("view", "kind"),
    "layout": _layout,
    "new_models": _new_models,
    "more": _more,
    "sort": _sort,
    "features": _features,
    "update": _update,
    "cancel": _cancel,
    "pictures": _pictures,
    "model": _model,
    "contrast": _contrast,
    "part": _part,
    "viewer": _viewer,
    "import": _import,
    "learn": _learn,
    "sheet": _sheet,
}
"""Functions of commands."""
