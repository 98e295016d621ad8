"""The protocol of the page that edits a facade; see `grammarlab.pages.requests` for the form of requests.

Manual editing of grids: the nodes of a click and a lasso, and names.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from grammarlab.errors import FacadeError, UsageError
from grammarlab.facade.editing.grid_proposals import unused, with_proposals
from grammarlab.facade.editing.grids import grid_of, lasso, toggled, with_grid, without_grid
from grammarlab.facade.size_locks import KINDS
from grammarlab.facade.sizes.size_wishes import Wish, checked
from grammarlab.facade.sizes.solve import Sizing
from grammarlab.facade.tree import Facade, Ints, X, Y
from grammarlab.pages.desktop import Message, Send
from grammarlab.pages.editor.desk import EditorDesk, boxes, drawing
from grammarlab.pages.editor.document import (
    Document,
    arranged,
    contradiction,
    is_possible,
    locked,
    unlocked,
    with_locks,
)
from grammarlab.pages.editor.suggestions import none_found
from grammarlab.pages.requests import Request, answered


def pressed(facade: Facade, grid: str, node: int) -> int:
    """The node selected by a press on a leaf, for a grid.

    It is the element of the grid that contains the leaf; otherwise the topmost node around it that has the label of an
    element and contains none of the others; otherwise the leaf.

    Raises:
        FacadeError: If the facade has no such node.
    """
    if not 0 <= node < len(facade):
        raise FacadeError(f"Node {node}: expected 0 to {len(facade) - 1}.")
    elements = grid_of(facade, grid).node
    around = _around(facade, node)
    holding = np.intersect1d(around, elements)
    if holding.size:
        return int(holding[0])
    called = set(facade.label[elements].tolist()) - {-1}
    free = [
        each
        for each in around.tolist()
        if facade.label[each] in called and not ((elements > each) & (elements < facade.end[each])).any()
    ]
    return free[0] if free else node


def with_pressed(facade: Facade, grid: str, node: int) -> Facade:
    """A facade after a press on a leaf: the selected node is added to the grid, or removed from it."""
    return toggled(facade, grid, [pressed(facade, grid, node)])


def with_lasso(facade: Facade, low: ArrayLike, high: ArrayLike) -> tuple[Facade, str]:
    """A facade with a new grid of the elements in a rectangle, and the name of the grid.

    Raises:
        FacadeError: If only background is entirely inside it.
    """
    nodes = lasso(facade, low, high)
    if not nodes.size:
        raise FacadeError("No element is inside this rectangle: draw it around windows, doors or other elements.")
    names = {facade.name_of(node) for node in nodes.tolist()}
    name = unused(names.pop() if len(names) == 1 else "grid", [grid.name for grid in facade.grids])
    return with_grid(facade, name, nodes), name


def renamed(facade: Facade, name: str, to: str) -> Facade:
    """A facade with a renamed grid.

    Raises:
        FacadeError: If the name is empty, or another grid has it.
    """
    grid, to = grid_of(facade, name), to.strip()
    if not to or to in {other.name for other in facade.grids if other is not grid}:
        raise FacadeError(f"{to!r}: expected a name that no other grid has.")
    return replace(facade, grids=tuple(replace(each, name=to) if each is grid else each for each in facade.grids))


def _around(facade: Facade, node: int) -> Ints:
    """The ancestors of a node, and itself, the topmost first."""
    found = [node]
    while facade.parent[found[-1]] >= 0:
        found.append(int(facade.parent[found[-1]]))
    return np.array(found[::-1])


MOST_SUGGESTIONS = 60
MOST_EXPLAINED = 2_000
"""Largest number of leaves for which contradictions are explained during a drag; that takes up to a second."""
LATER = "These sizes contradict locks, alignments or equal sizes: release to see which."


def run(desk: EditorDesk, message: object, buffers: Sequence[bytes], window: Send) -> None:
    """Executes the request of a window, and answers it; `message` may be any value."""
    answered(COMMANDS, desk, message, buffers, window)


def _drag(desk: EditorDesk, request: Request) -> None:
    """Sizes during a drag of a side or a part: nothing is stored, and contradictory sizes are not shown."""
    if "node" in request.values:
        wished, sizing = _moved(desk, request)
        wishes = wished.wishes(wished.facade.width, wished.facade.height)
    else:
        sizing, wishes = desk.sizing(desk.document), _resized(desk, request)
    if len(sizing.facade.leaves) > MOST_EXPLAINED and not is_possible(sizing, checked(wishes, sizing.facade)):
        return request.answer({"conflict": LATER}, ())
    resized = sizing.resized(wishes)
    if resized.conflict:
        return request.answer({"conflict": contradiction(resized.conflict)}, ())
    sizes = {"width": resized.facade.width, "height": resized.facade.height, "conflict": ""}
    return request.answer(sizes, (boxes(resized.facade).astype("<f8").tobytes(),))


def _skip(_desk: EditorDesk, _request: Request) -> Message:
    """The answer to a drag that a later one has replaced."""
    return {"skipped": True}


def _resize(desk: EditorDesk, request: Request) -> Message:
    document = desk.document
    made = document.settled(desk.sizing(document).resized(_resized(desk, request)))
    facade = made.facade
    unchanged = (np.array_equal(getattr(facade, name), getattr(document.facade, name)) for name in ("size", "position"))
    if not all(unchanged):
        desk.do(f"{facade.width:.2f} × {facade.height:.2f} m", made)
    return _done(desk)


def _resized(desk: EditorDesk, request: Request) -> tuple[Wish, ...]:
    width, height = (_metres(request, name) for name in ("width", "height"))
    return desk.document.wishes(width, height)


def _move(desk: EditorDesk, request: Request) -> Message:
    wished, sizing = _moved(desk, request)
    desk.do("move", wished.settled(sizing.resized(wished.wishes(wished.facade.width, wished.facade.height))))
    return _done(desk)


def _moved(desk: EditorDesk, request: Request) -> tuple[Document, Sizing]:
    node = _place(desk, request)
    wished = with_locks(desk.document, node, {name: request.number(name) for name in ("left", "bottom")})
    return wished, desk.sizing(wished, node)


def _give(desk: EditorDesk, request: Request) -> Message:
    what = _what(request)
    is_range = what == "aspect"
    value = (request.number("least"), request.number("most")) if is_range else request.number("value")
    desk.do(f"set {what}", arranged(desk.document, _place(desk, request), {what: value}))
    return _done(desk)


def _lock(desk: EditorDesk, request: Request) -> Message:
    desk.do("lock", locked(desk.document, _place(desk, request), _what(request)))
    return _done(desk)


def _unlock(desk: EditorDesk, request: Request) -> Message:
    desk.do("unlock", unlocked(desk.document, _place(desk, request), _what(request)))
    return _done(desk)


def _undo(desk: EditorDesk, _request: Request) -> Message:
    return {"words": desk.step(desk.history.undo), **_done(desk)}


def _redo(desk: EditorDesk, _request: Request) -> Message:
    return {"words": desk.step(desk.history.redo), **_done(desk)}


def _choose(desk: EditorDesk, request: Request) -> Message:
    desk.choose(request.text("grid"))
    return _done(desk)


def _press(desk: EditorDesk, request: Request) -> Message:
    node, facade = _place(desk, request), desk.document.facade
    if not desk.active:
        raise UsageError("There is no grid: draw a rectangle around some windows to make one.")
    desk.regrid(f"change {desk.active}", with_pressed(facade, desk.active, node))
    return _done(desk)


def _lasso(desk: EditorDesk, request: Request) -> Message:
    sides = [request.number(name) for name in ("left", "bottom", "right", "top")]
    facade, name = with_lasso(desk.document.facade, np.array(sides[:2]), np.array(sides[2:]))
    desk.regrid(f"new grid {name}", facade, name)
    return {"grid": name, **_done(desk)}


def _rename(desk: EditorDesk, request: Request) -> Message:
    name, to = request.text("grid"), request.text("to")
    desk.regrid(f"rename {name}", renamed(desk.document.facade, name, to), to.strip())
    return _done(desk)


def _delete(desk: EditorDesk, request: Request) -> Message:
    name = request.text("grid")
    desk.regrid(f"delete {name}", without_grid(desk.document.facade, name))
    return _done(desk)


def _propose(desk: EditorDesk, _request: Request) -> Message:
    desk.regrid("propose grids", with_proposals(desk.document.facade))
    return _done(desk)


def _vary(desk: EditorDesk, request: Request) -> None:
    axis, more = _axis(request), request.whole("change", -1, 1, 1) > 0
    suggestions = desk.suggest(axis, more=more, most=request.whole("most", 1, MOST_SUGGESTIONS, 12))
    found, buffers = [], []
    for each in suggestions.found:
        values, columns = drawing(each.document.facade)
        told = [contradiction(each.resized.conflict)] if each.resized.conflict else list(each.missing)
        found.append({"words": each.words, "told": told, **values})
        buffers.append(columns)
    result = {
        "revision": desk.revision,
        "variations": found,
        "total": suggestions.total,
        "none": none_found(suggestions, desk.active, axis, more=more),
    }
    request.answer(result, buffers)


def _accept(desk: EditorDesk, request: Request) -> Message:
    suggestions = desk.suggestions
    if suggestions is None or suggestions.of is not desk.document:
        raise UsageError("The facade has changed since these variations were made; choose from the new ones.")
    chosen = suggestions.found[request.whole("number", 0, len(suggestions.found) - 1, 0)]
    if chosen.resized.conflict:
        raise FacadeError(contradiction(chosen.resized.conflict))
    desk.chosen = desk.active
    desk.do(chosen.words, chosen.document)
    return _done(desk)


def _save(desk: EditorDesk, _request: Request) -> Message:
    desk.save()
    return {"file": str(desk.target), **_done(desk)}


def _export(desk: EditorDesk, request: Request) -> Message:
    return {"file": str(desk.export(request.text("format")))}


def _picture(desk: EditorDesk, request: Request) -> None:
    pictures = desk.document.facade.pictures
    picture = pictures[request.whole("number", 0, len(pictures) - 1, 0)]
    request.answer({"name": picture.name}, (picture.content,))


def _done(desk: EditorDesk) -> Message:
    return {"revision": desk.revision}


def _metres(request: Request, name: str) -> float:
    metres = request.number(name)
    if metres <= 0.0:
        raise UsageError(f"{name}: expected metres above 0, found {metres:g}.")
    return metres


def _place(desk: EditorDesk, request: Request) -> int:
    return request.whole("node", 0, len(desk.document.facade) - 1, -1)


def _axis(request: Request) -> int:
    return {"x": X, "y": Y}[_one_of(request, "axis", ("x", "y"))]


def _what(request: Request) -> str:
    return _one_of(request, "what", KINDS)


def _one_of(request: Request, name: str, values: Sequence[str]) -> str:
    text = request.text(name)
    if text not in values:
        raise UsageError(f"{name}: expected one of {', '.join(values)}, found {text!r}.")
    return text


COMMANDS: dict[str, Callable[[EditorDesk, Request], Message | None]] = {
    "drag": _drag,
    "skip": _skip,
    "resize": _resize,
    "move": _move,
    "give": _give,
    "lock": _lock,
    "unlock": _unlock,
    "undo": _undo,
    "redo": _redo,
    "choose": _choose,
    "press": _press,
    "lasso": _lasso,
    "rename": _rename,
    "delete": _delete,
    "propose": _propose,
    "vary": _vary,
    "accept": _accept,
    "save": _save,
    "export": _export,
    "picture": _picture,
}
"""Functions of commands; those without a result send the answer themselves."""
