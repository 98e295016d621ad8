"""Commands of the page that edits a facade; see `grammarlab.pages.requests` for the form of requests."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from grammarlab.arrays import Ints
from grammarlab.errors import FacadeError, UsageError
from grammarlab.facade.editing.grid_proposals import unused, with_proposals
from grammarlab.facade.editing.grids import grid_of, lasso, toggled, with_grid, without_grid
from grammarlab.facade.size_locks import KINDS
from grammarlab.facade.sizes.size_wishes import Wish, checked
from grammarlab.facade.sizes.solve import Sizing
from grammarlab.facade.tree import Facade, X, Y
from grammarlab.pages.desk import DESK_COMMANDS, Command
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
from grammarlab.pages.requests import Request
from grammarlab.pages.windows import Message

MOST_EXPLAINED = 2_000
"""Largest number of leaves for which contradictions are explained during a drag; that takes up to a second."""
LATER = "These sizes contradict locks, alignments or equal sizes: release to see which."
"""Answer to a drag of larger facades whose sizes are contradictory."""
_MOST_SUGGESTIONS = 60
"""Largest number of variations in one answer."""


def with_pressed(facade: Facade, grid: str, node: int) -> Facade:
    """A facade after a press on a leaf: the selected node is added to the grid, or removed from it."""
    return toggled(facade, grid, [pressed(facade, grid, node)])


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
    labels = set(facade.label[elements].tolist()) - {-1}
    free = [
        ancestor
        for ancestor in around.tolist()
        if facade.label[ancestor] in labels and not ((elements > ancestor) & (elements < facade.end[ancestor])).any()
    ]
    return free[0] if free else node


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
    old, to = grid_of(facade, name), to.strip()
    if not to or to in {grid.name for grid in facade.grids if grid is not old}:
        raise FacadeError(f"{to!r}: expected a name that no other grid has.")
    return replace(facade, grids=tuple(replace(grid, name=to) if grid is old else grid for grid in facade.grids))


def _drag(desk: EditorDesk, request: Request) -> None:
    """Sizes during a drag of a side or a part: nothing is stored, and contradictory sizes are not shown."""
    if "node" in request.values:
        requested, sizing = _moved_sizing(desk, request)
        wishes = requested.wishes(requested.facade.width, requested.facade.height)
    else:
        sizing, wishes = desk.sizing(desk.document), _wishes(desk, request)
    if len(sizing.facade.leaves) > MOST_EXPLAINED and not is_possible(sizing, checked(wishes, sizing.facade)):
        return request.answer({"conflict": LATER}, ())
    resized = sizing.resized(wishes)
    if resized.conflict:
        return request.answer({"conflict": contradiction(resized.conflict)}, ())
    sizes = {"width": resized.facade.width, "height": resized.facade.height, "conflict": ""}
    return request.answer(sizes, (boxes(resized.facade).astype("<f8").tobytes(),))


def _resize(desk: EditorDesk, request: Request) -> Message:
    document = desk.document
    resized = document.settled(desk.sizing(document).resized(_wishes(desk, request)))
    facade = resized.facade
    unchanged = (np.array_equal(getattr(facade, name), getattr(document.facade, name)) for name in ("size", "position"))
    if not all(unchanged):
        desk.do(f"{facade.width:.2f} × {facade.height:.2f} m", resized)
    return desk.done()


def _move(desk: EditorDesk, request: Request) -> Message:
    requested, sizing = _moved_sizing(desk, request)
    desk.do(
        "move", requested.settled(sizing.resized(requested.wishes(requested.facade.width, requested.facade.height)))
    )
    return desk.done()


def _give(desk: EditorDesk, request: Request) -> Message:
    what = _property(request)
    is_range = what == "aspect"
    value = (request.number("least"), request.number("most")) if is_range else request.number("value")
    desk.do(f"set {what}", arranged(desk.document, _node(desk, request), {what: value}))
    return desk.done()


def _lock(desk: EditorDesk, request: Request) -> Message:
    desk.do("lock", locked(desk.document, _node(desk, request), _property(request)))
    return desk.done()


def _unlock(desk: EditorDesk, request: Request) -> Message:
    desk.do("unlock", unlocked(desk.document, _node(desk, request), _property(request)))
    return desk.done()


def _choose(desk: EditorDesk, request: Request) -> Message:
    desk.choose(request.text("grid"))
    return desk.done()


def _press(desk: EditorDesk, request: Request) -> Message:
    node, facade = _node(desk, request), desk.document.facade
    if not desk.active:
        raise UsageError("There is no grid: draw a rectangle around some windows to make one.")
    desk.regrid(f"change {desk.active}", with_pressed(facade, desk.active, node))
    return desk.done()


def _lasso(desk: EditorDesk, request: Request) -> Message:
    sides = [request.number(name) for name in ("left", "bottom", "right", "top")]
    facade, name = with_lasso(desk.document.facade, np.array(sides[:2]), np.array(sides[2:]))
    desk.regrid(f"new grid {name}", facade, name)
    return {"grid": name, **desk.done()}


def _rename(desk: EditorDesk, request: Request) -> Message:
    name, to = request.text("grid"), request.text("to")
    desk.regrid(f"rename {name}", renamed(desk.document.facade, name, to), to.strip())
    return desk.done()


def _delete(desk: EditorDesk, request: Request) -> Message:
    name = request.text("grid")
    desk.regrid(f"delete {name}", without_grid(desk.document.facade, name))
    return desk.done()


def _propose(desk: EditorDesk, _request: Request) -> Message:
    desk.regrid("propose grids", with_proposals(desk.document.facade))
    return desk.done()


def _vary(desk: EditorDesk, request: Request) -> None:
    axis, more = _axis(request), request.integer("change", -1, 1, 1) > 0
    suggestions = desk.suggest(axis, more=more, most=request.integer("most", 1, _MOST_SUGGESTIONS, 12))
    variations, buffers = [], []
    for suggestion in suggestions.variations:
        values, columns = drawing(suggestion.document.facade)
        conflict = suggestion.resized.conflict
        notes = [contradiction(conflict)] if conflict else list(suggestion.missing)
        variations.append({"words": suggestion.words, "told": notes, **values})
        buffers.append(columns)
    result = {
        "revision": desk.revision,
        "variations": variations,
        "total": suggestions.total,
        "none": none_found(suggestions, desk.active, axis, more=more),
    }
    request.answer(result, buffers)


def _accept(desk: EditorDesk, request: Request) -> Message:
    suggestions = desk.suggestions
    if suggestions is None or suggestions.document is not desk.document:
        raise UsageError("The facade has changed since these variations were made; choose from the new ones.")
    chosen = suggestions.variations[request.integer("number", 0, len(suggestions.variations) - 1, 0)]
    if chosen.resized.conflict:
        raise FacadeError(contradiction(chosen.resized.conflict))
    desk.chosen = desk.active
    desk.do(chosen.words, chosen.document)
    return desk.done()


def _picture(desk: EditorDesk, request: Request) -> None:
    pictures = desk.document.facade.pictures
    picture = pictures[request.integer("number", 0, len(pictures) - 1, 0)]
    request.answer({"name": picture.name}, (picture.content,))


COMMANDS: dict[str, Command[EditorDesk]] = {
    **DESK_COMMANDS,
    "drag": _drag,
    "resize": _resize,
    "move": _move,
    "give": _give,
    "lock": _lock,
    "unlock": _unlock,
    "choose": _choose,
    "press": _press,
    "lasso": _lasso,
    "rename": _rename,
    "delete": _delete,
    "propose": _propose,
    "vary": _vary,
    "accept": _accept,
    "picture": _picture,
}
"""Functions of commands."""


def _around(facade: Facade, node: int) -> Ints:
    """The ancestors of a node, and itself, the topmost first."""
    nodes = [node]
    while facade.parent[nodes[-1]] >= 0:
        nodes.append(int(facade.parent[nodes[-1]]))
    return np.array(nodes[::-1])


def _moved_sizing(desk: EditorDesk, request: Request) -> tuple[Document, Sizing]:
    node = _node(desk, request)
    requested = with_locks(desk.document, node, {name: request.number(name) for name in ("left", "bottom")})
    return requested, desk.sizing(requested, node)


def _node(desk: EditorDesk, request: Request) -> int:
    return request.integer("node", 0, len(desk.document.facade) - 1, -1)


def _wishes(desk: EditorDesk, request: Request) -> tuple[Wish, ...]:
    width, height = (_metres(request, name) for name in ("width", "height"))
    return desk.document.wishes(width, height)


def _metres(request: Request, name: str) -> float:
    metres = request.number(name)
    if metres <= 0.0:
        raise UsageError(f"{name}: expected metres above 0, found {metres:g}.")
    return metres


def _property(request: Request) -> str:
    return request.one_of("what", KINDS)


def _axis(request: Request) -> int:
    return {"x": X, "y": Y}[request.one_of("axis", ("x", "y"))]
