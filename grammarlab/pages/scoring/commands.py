"""Protocol of a scoring session: checked requests of windows, and their answers.

See `grammarlab.pages.requests` for the form of requests.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import asdict

from grammarlab.errors import UsageError
from grammarlab.learning.designs.addresses import Address, shown
from grammarlab.pages import STATIC
from grammarlab.pages.desktop import Message, Send
from grammarlab.pages.record.events import Record
from grammarlab.pages.record.model_grids import Body, checked_models
from grammarlab.pages.requests import Request, answered
from grammarlab.pages.scoring.rounds import Rounds
from grammarlab.pages.scoring.sorting import Order
from grammarlab.pages.scoring.state import state_of
from grammarlab.pages.workers.tasks import FindPart, MakeGlb
from grammarlab.pages.workers.thumbnails import LARGEST, SMALLEST

MAX_PICTURES = 400
"""Largest number of models in one request for pictures."""
MAX_SHEET = 64
"""Models on a sheet."""
MAX_FILE_BYTES = 32 << 20
"""Of a label file."""
FORMATS = ("csv", "jsonl", "parquet")
"""Of exported label files."""
IMPORTED = (*FORMATS, "tsv")
"""Formats of label files that are read."""
VIEWER = STATIC / "scoring" / "viewer.js"

Command = Callable[[Rounds, Request], Message | None]


def run(rounds: Rounds, message: object, buffers: Sequence[bytes], window: Send) -> None:
    """Run a request of a window, and answer, now or later; `message` may be any value."""
    answered(COMMANDS, rounds, message, buffers, window)


def _state(rounds: Rounds, _request: Request) -> Message:
    return state_of(rounds)


def _saying(kind: str, *names: str) -> Command:
    """A command that scores or compares; missing arguments are not stored."""

    def say(rounds: Rounds, request: Request) -> Message:
        said = {name: request.values[name] for name in names if name in request.values}
        revision = rounds.desk.say(kind, said, request.values.get("factor", ""), request.text("key", ""))
        return {"saved": True, "revision": revision}

    return say


def _event(kind: str, *names: str) -> Callable[[Rounds, Request], Message]:
    """A command that only adds an event."""

    def add(rounds: Rounds, request: Request) -> Message:
        body = {name: request.values.get(name) for name in names}
        return {"saved": True, "revision": rounds.desk.do(kind, body)}

    return add


def _factor_event(kind: str, *names: str) -> Callable[[Rounds, Request], Message]:
    """The same for a factor, given by its name or, since names change, by its number."""

    def add(rounds: Rounds, request: Request) -> Message:
        given = {name: request.values.get(name) for name in names}

        def body(record: Record) -> Body:
            return given | {"name": record.name_of(request.values.get("name"))}

        return {"saved": True, "revision": rounds.desk.do(kind, body)}

    return add


def _layout(rounds: Rounds, request: Request) -> Message:
    rounds.layout({name: request.values.get(name) for name in ("grids", "rows", "columns")})
    return {"revision": rounds.desk.record.revision}


def _populate(rounds: Rounds, request: Request) -> Message:
    rounds.learning.populate(request.text("way", rounds.desk.record.way))
    return {"revision": rounds.desk.record.revision}


def _sort(rounds: Rounds, request: Request) -> Message:
    models = tuple(checked_models(request.values.get("models", []), MAX_PICTURES))
    rounds.desk.sort(Order(request.text("by"), request.text("feature", ""), models))
    return {"revision": rounds.desk.record.revision}


def _features(rounds: Rounds, request: Request) -> Message:
    rounds.learning.prepare()
    return {"features": rounds.desk.knowledge.names_like(request.text("query", ""))}


def _update(rounds: Rounds, _request: Request) -> Message:
    rounds.learning.update()
    return {}


def _cancel(rounds: Rounds, _request: Request) -> Message:
    rounds.learning.cancel()
    return {}


def _pictures(rounds: Rounds, request: Request) -> None:
    models = checked_models(request.values.get("models"), MAX_PICTURES)
    size = request.whole("size", SMALLEST, LARGEST, 160)
    request.answer({}, ())
    rounds.thumbnails.request(models, size, request.window)


def _model(rounds: Rounds, request: Request) -> None:
    model = str(Address.parse(request.values.get("model")))
    label = rounds.desk.pool.label_of(model)
    rounds.ask_artist(MakeGlb(model), lambda glb: ({"label": label}, [glb]), request.answer, request.refuse)


def _part(rounds: Rounds, request: Request) -> None:
    kind = "triangle" if "triangle" in request.values else "part"
    number = request.whole(kind, -(2**53), 2**53, 0)
    task = FindPart(str(Address.parse(request.values.get("model"))), number, kind == "triangle")
    rounds.ask_artist(task, lambda part: (asdict(part), []), request.answer, request.refuse)


def _viewer(_rounds: Rounds, request: Request) -> None:
    request.answer({}, (VIEWER.read_bytes(),))


def _export(rounds: Rounds, request: Request) -> None:
    rounds.files.export(_suffix(request, FORMATS), request.answer, request.refuse)


def _import(rounds: Rounds, request: Request) -> None:
    if len(request.buffers) != 1 or len(request.buffers[0]) > MAX_FILE_BYTES:
        raise UsageError(f"expected one label file of at most {MAX_FILE_BYTES >> 20} MiB.")
    rounds.files.read(bytes(request.buffers[0]), _suffix(request, IMPORTED), request.answer, request.refuse)


def _suffix(request: Request, formats: Sequence[str]) -> str:
    name = request.text("format")
    if name not in formats:
        raise UsageError(f"format: expected one of {', '.join(formats)}, found {shown(name)}.")
    return f".{name}"


def _learn(rounds: Rounds, request: Request) -> None:
    rounds.files.learn_grammar(request.answer, request.refuse)


def _sheet(rounds: Rounds, request: Request) -> None:
    rounds.files.sheet(request.whole("num", 1, MAX_SHEET, 16), request.answer, request.refuse)


COMMANDS: dict[str, Command] = {
    "state": _state,
    "score": _saying("score", "models", "score", "kind"),
    "compare": _saying("compare", "models", "kind"),
    "undo": _event("undo"),
    "redo": _event("redo"),
    "factor_create": _event("factor_create", "name"),
    "factor_rename": _factor_event("factor_rename", "to"),
    "factor_delete": _factor_event("factor_delete"),
    "factor_activate": _factor_event("factor_activate"),
    "view": _event("view", "kind"),
    "layout": _layout,
    "populate": _populate,
    "sort": _sort,
    "features": _features,
    "update": _update,
    "cancel": _cancel,
    "pictures": _pictures,
    "model": _model,
    "part": _part,
    "viewer": _viewer,
    "export": _export,
    "import": _import,
    "learn": _learn,
    "sheet": _sheet,
}
"""Functions of the commands; those without a result send their own answer."""
