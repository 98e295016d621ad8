"""The protocol of the page that corrects an example; `grammarlab.pages.requests` has the form of requests."""

from __future__ import annotations

from grammarlab.errors import UsageError
from grammarlab.pages import example_desk
from grammarlab.pages.desk import DESK_COMMANDS, Command
from grammarlab.pages.desktop import StateEvent
from grammarlab.pages.example_desk import ExampleDesk
from grammarlab.pages.requests import Request
from grammarlab.pages.windows import PROTOCOL, Message
from grammarlab.runs.facade.gallery import png_of
from grammarlab.synthesis.example_pictures import wall_picture

MOST_UNITS = 60
"""Largest number of rows or columns of a building on the page; the command has no such limit."""


def state_of(desk: ExampleDesk) -> StateEvent:
    """The whole state of the page, except pictures."""
    included = {wall["name"]: wall for wall in desk.document["walls"]}
    walls = []
    for region, first in zip(desk.analysis.regions, desk.first["walls"], strict=True):
        walls.append(
            {
                **included.get(region.name, first),
                "kept": region.name in included,
                "box": region.wall.tolist(),
                "elements": region.elements.round(4).tolist(),
            }
        )
    state = {
        "protocol": PROTOCOL,
        **desk.summary(),
        "title": desk.file.name,
        "main": desk.analysis.main.name,
        "names": desk.label_names(),
        "walls": walls,
    }
    return {"event": "state", "state": state}, ()


def _relabel(desk: ExampleDesk, request: Request) -> Message:
    row, column, last_row, last_column = (
        request.integer(name, 0, 10_000, 0) for name in ("row", "column", "last_row", "last_column")
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
    index, position = request.integer("line", 0, 10_000, -1), round(request.number("at"), 4)
    desk.do(
        "move a line", example_desk.moved(desk.document, request.text("wall"), request.text("axis"), index, position)
    )
    return {}


def _split(desk: ExampleDesk, request: Request) -> Message:
    position = round(request.number("at"), 4)
    desk.do("one more line", example_desk.split(desk.document, request.text("wall"), request.text("axis"), position))
    return {}


def _join(desk: ExampleDesk, request: Request) -> Message:
    index = request.integer("line", 0, 10_000, -1)
    desk.do("one line less", example_desk.joined(desk.document, request.text("wall"), request.text("axis"), index))
    return {}


def _exclude(desk: ExampleDesk, request: Request) -> Message:
    wall = request.text("wall")
    if wall == desk.analysis.main.name:
        raise UsageError("The main wall cannot be excluded: its rows and columns are those of the result.")
    desk.do(f"exclude {wall}", example_desk.excluded(desk.document, wall))
    return {}


def _include(desk: ExampleDesk, request: Request) -> Message:
    wall = request.text("wall")
    desk.do(f"include {wall}", example_desk.included(desk.document, desk.first, wall))
    return {}


def _picture(desk: ExampleDesk, request: Request) -> None:
    name = request.text("wall")
    region = next((region for region in desk.analysis.regions if region.name == name), None)
    if region is None:
        raise UsageError(f"unknown wall {name!r}.")
    request.answer({}, (png_of(wall_picture(desk.analysis, region)),))


def _synthesize(desk: ExampleDesk, request: Request) -> None:
    rows, columns = (request.integer(name, 1, MOST_UNITS, 0) for name in ("rows", "columns"))
    building, picture = desk.synthesized(rows, columns, request.integer("seed", 0, 2**31 - 1, 0))
    request.answer(building.as_dict(), (png_of(picture),))


COMMANDS: dict[str, Command[ExampleDesk]] = {
    **DESK_COMMANDS,
    "relabel": _relabel,
    "merge": _merge,
    "move": _move,
    "split": _split,
    "join": _join,
    "exclude": _exclude,
    "include": _include,
    "picture": _picture,
    "synthesize": _synthesize,
}
"""Functions of commands."""
