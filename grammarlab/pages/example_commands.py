"""The protocol of the page that corrects an example; `grammarlab.pages.requests` has the form of requests."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from io import BytesIO

from PIL import Image

from grammarlab.errors import UsageError
from grammarlab.pages import example_desk
from grammarlab.pages.desktop import Message, Send
from grammarlab.pages.example_desk import ExampleDesk
from grammarlab.pages.requests import Request, answered
from grammarlab.synthesis.example_pictures import wall_picture

PROTOCOL = 1
MOST_TRIED = 60
"""Largest number of rows or columns of a building on the page; the command has no such limit."""


def run(desk: ExampleDesk, message: object, buffers: Sequence[bytes], window: Send) -> None:
    """Executes the request of a window, and answers it; `message` may be any value."""
    answered(COMMANDS, desk, message, buffers, window)


def state_of(desk: ExampleDesk) -> tuple[Message, Sequence[bytes]]:
    """The whole state of the page, except pictures."""
    kept = {wall["name"]: wall for wall in desk.document["walls"]}
    walls = []
    for region, first in zip(desk.found.regions, desk.first["walls"], strict=True):
        walls.append(
            {
                **kept.get(region.name, first),
                "kept": region.name in kept,
                "box": region.wall.tolist(),
                "elements": region.elements.round(4).tolist(),
            }
        )
    past, future = desk.history.past, desk.history.future
    state = {
        "protocol": PROTOCOL,
        "revision": desk.revision,
        "title": desk.file.name,
        "file": str(desk.target),
        "saved": desk.is_saved,
        "undo": past[-1][0] if past else "",
        "redo": future[-1][0] if future else "",
        "main": desk.found.main.name,
        "names": desk.label_names(),
        "walls": walls,
    }
    return {"event": "state", "state": state}, ()


def _relabel(desk: ExampleDesk, request: Request) -> Message:
    row, column, last_row, last_column = (
        request.whole(name, 0, 10_000, 0) for name in ("row", "column", "last_row", "last_column")
    )
    name = request.text("label")
    cells = (row, column, last_row, last_column)
    desk.do(f"call units {name}", example_desk.relabelled(desk.document, request.text("wall"), cells, name))
    return {}


def _merge(desk: ExampleDesk, request: Request) -> Message:
    name, into = request.text("label"), request.text("into")
    desk.do(f"merge {name} into {into}", example_desk.merged(desk.document, request.text("wall"), name, into))
    return {}


def _move(desk: ExampleDesk, request: Request) -> Message:
    index, at = request.whole("line", 0, 10_000, -1), round(request.number("at"), 4)
    desk.do("move a line", example_desk.moved(desk.document, request.text("wall"), request.text("axis"), index, at))
    return {}


def _split(desk: ExampleDesk, request: Request) -> Message:
    at = round(request.number("at"), 4)
    desk.do("one more line", example_desk.split(desk.document, request.text("wall"), request.text("axis"), at))
    return {}


def _join(desk: ExampleDesk, request: Request) -> Message:
    index = request.whole("line", 0, 10_000, -1)
    desk.do("one line less", example_desk.joined(desk.document, request.text("wall"), request.text("axis"), index))
    return {}


def _exclude(desk: ExampleDesk, request: Request) -> Message:
    wall = request.text("wall")
    if wall == desk.found.main.name:
        raise UsageError("The main wall cannot be excluded: its rows and columns are those of the result.")
    desk.do(f"exclude {wall}", example_desk.excluded(desk.document, wall))
    return {}


def _include(desk: ExampleDesk, request: Request) -> Message:
    wall = request.text("wall")
    desk.do(f"include {wall}", example_desk.included(desk.document, desk.first, wall))
    return {}


def _undo(desk: ExampleDesk, _request: Request) -> Message:
    return {"words": desk.step(forward=False)}


def _redo(desk: ExampleDesk, _request: Request) -> Message:
    return {"words": desk.step(forward=True)}


def _save(desk: ExampleDesk, _request: Request) -> Message:
    desk.save()
    return {"file": str(desk.target)}


def _picture(desk: ExampleDesk, request: Request) -> None:
    name = request.text("wall")
    region = next((each for each in desk.found.regions if each.name == name), None)
    if region is None:
        raise UsageError(f"unknown wall {name!r}.")
    request.answer({}, (_png(wall_picture(desk.found, region)),))


def _synthesize(desk: ExampleDesk, request: Request) -> None:
    rows, columns = (request.whole(name, 1, MOST_TRIED, 0) for name in ("rows", "columns"))
    made, picture = desk.tried(rows, columns, request.whole("seed", 0, 2**31 - 1, 0))
    request.answer(made.as_dict(), (_png(picture),))


def _png(picture: Image.Image) -> bytes:
    content = BytesIO()
    picture.save(content, "PNG")
    return content.getvalue()


COMMANDS: dict[str, Callable[[ExampleDesk, Request], Message | None]] = {
    "relabel": _relabel,
    "merge": _merge,
    "move": _move,
    "split": _split,
    "join": _join,
    "exclude": _exclude,
    "include": _include,
    "undo": _undo,
    "redo": _redo,
    "save": _save,
    "picture": _picture,
    "synthesize": _synthesize,
}
